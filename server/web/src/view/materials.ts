// SPDX-License-Identifier: GPL-3.0-or-later
// How surfaces, points and lines look.
import {Color, DoubleSide, FrontSide, LineBasicMaterial, MeshLambertMaterial, PointsMaterial, type ColorRepresentation, type Plane} from 'three';

export interface Palette {
  background: ColorRepresentation;
  surface: ColorRepresentation;
  inside: ColorRepresentation;
  point: ColorRepresentation;
  edge: ColorRepresentation;
  boundary: ColorRepresentation;
  nonManifold: ColorRepresentation;
  unused: ColorRepresentation;
  interior: ColorRepresentation;
  mark: ColorRepresentation;
}

export const palettes: Record<'light'|'dark', Palette> = {
  light: {
    background: '#eef1f3',
    surface: '#cdd6dd',
    inside: '#d69a55',
    point: '#1d5273',
    edge: '#23323f',
    boundary: '#c2185b',
    nonManifold: '#2e7d32',
    unused: '#d97706',
    interior: '#7c3aed',
    mark: '#d81b60'
  },
  dark: {
    background: '#10151a',
    surface: '#a9b6c0',
    inside: '#b97a3a',
    point: '#7fc4e8',
    edge: '#0b0f13',
    boundary: '#ff5c9a',
    nonManifold: '#66d16f',
    unused: '#ffb347',
    interior: '#b794f6',
    mark: '#ff4f8b'
  },
};

/** The inside of the surface has a colour of its own, so that holes and faces turned over show. */
export function surfaceMaterial(
    palette: Palette, smooth: boolean, coloured: boolean, solid: boolean, planes: Plane[]): MeshLambertMaterial {
  const material = new MeshLambertMaterial({
    color: coloured ? '#ffffff' : palette.surface,
    vertexColors: coloured,
    flatShading: !smooth,
    side: solid ? FrontSide : DoubleSide,
    clippingPlanes: planes,
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
  });
  const inside = new Color(palette.inside);
  material.onBeforeCompile = (shader) => {
    shader.uniforms.insideColor = {value: inside};
    shader.fragmentShader = `uniform vec3 insideColor;\n${shader.fragmentShader}`.replace(
        '#include <color_fragment>',
        '#include <color_fragment>\n  if (!gl_FrontFacing) diffuseColor.rgb = insideColor;');
  };
  return material;
}

export function pointsMaterial(color: ColorRepresentation, size: number, planes: Plane[]): PointsMaterial {
  const material = new PointsMaterial({color, size, sizeAttenuation: false, clippingPlanes: planes});
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace(
        '#include <color_fragment>', '#include <color_fragment>\n  if (length(gl_PointCoord - 0.5) > 0.5) discard;');
  };
  return material;
}

export const lineMaterial = (color: ColorRepresentation, opacity: number, planes: Plane[]): LineBasicMaterial =>
    new LineBasicMaterial({color, opacity, transparent: opacity < 1, clippingPlanes: planes});
