// SPDX-License-Identifier: GPL-3.0-or-later
// How surfaces, points and lines look.
import {Color, DoubleSide, FrontSide, LineBasicMaterial, MeshLambertMaterial, PointsMaterial, type ColorRepresentation, type Plane, type WebGLProgramParametersWithUniforms} from 'three';

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

type Shader = WebGLProgramParametersWithUniforms;

/** Bytes of colours are given in sRGB; light is added up in linear values. */
function linearColours(shader: Shader): void {
  shader.vertexShader = shader.vertexShader.replace('#include <color_vertex>', `#include <color_vertex>
#ifdef USE_COLOR
  vColor.rgb = mix(pow((vColor.rgb + 0.055) / 1.055, vec3(2.4)), vColor.rgb / 12.92, step(vColor.rgb, vec3(0.04045)));
#endif`);
}

/** Whether a colour a triangle or a vertex is given. */
export interface SurfaceLook {
  smooth: boolean;
  coloured: boolean;
  /** Nothing of its inside can be seen. */
  solid: boolean;
}

/** The inside of the surface has a colour of its own, so that holes and faces turned over show. */
export function surfaceMaterial(palette: Palette, look: SurfaceLook, planes: Plane[]): MeshLambertMaterial {
  const material = new MeshLambertMaterial({
    color: look.coloured ? '#ffffff' : palette.surface,
    vertexColors: look.coloured,
    flatShading: !look.smooth,
    side: look.solid ? FrontSide : DoubleSide,
    clippingPlanes: planes,
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
  });
  const inside = new Color(palette.inside);
  material.onBeforeCompile = (shader) => {
    linearColours(shader);
    shader.uniforms.insideColor = {value: inside};
    shader.fragmentShader = `uniform vec3 insideColor;\n${shader.fragmentShader}`.replace(
        '#include <color_fragment>',
        '#include <color_fragment>\n  if (!gl_FrontFacing) diffuseColor.rgb = insideColor;');
  };
  return material;
}

/** Points of a cloud have a size in space, within these pixels; marks have one on the screen. */
const kPixels = {
  least: 1.6,
  most: 14
};

export interface PointLook {
  /** None if every point has a colour of its own. */
  color?: ColorRepresentation|undefined;
  size: number;
  inSpace: boolean;
}

export function pointsMaterial(look: PointLook, planes: Plane[]): PointsMaterial {
  const {color, size, inSpace} = look;
  const material = new PointsMaterial({
    color: color ?? '#ffffff',
    vertexColors: color === undefined,
    size,
    sizeAttenuation: inSpace,
    clippingPlanes: planes,
  });
  material.onBeforeCompile = (shader) => {
    linearColours(shader);
    if (inSpace) {
      shader.vertexShader = shader.vertexShader.replace(
          '#include <logdepthbuf_vertex>',
          `gl_PointSize = clamp(gl_PointSize, ${kPixels.least.toFixed(1)}, ${
              kPixels.most.toFixed(1)});\n  #include <logdepthbuf_vertex>`);
    }
    shader.fragmentShader = shader.fragmentShader.replace(
        '#include <color_fragment>', '#include <color_fragment>\n  if (length(gl_PointCoord - 0.5) > 0.5) discard;');
  };
  material.customProgramCacheKey = () => `points ${inSpace}`;
  return material;
}

export const lineMaterial = (color: ColorRepresentation, opacity: number, planes: Plane[]): LineBasicMaterial =>
    new LineBasicMaterial({color, opacity, transparent: opacity < 1, clippingPlanes: planes});
