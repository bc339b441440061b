// SPDX-License-Identifier: GPL-3.0-or-later
// The objects of one pane: a cloud, a mesh over it, and what is marked on them.
import {BufferAttribute, BufferGeometry, Group, LineSegments, Mesh, Points, type LineBasicMaterial, type Object3D, type Plane} from 'three';
import type {LoadedCloud, LoadedMesh, UnusedPoints} from '../worker/protocol';
import {coloursOf, type ScaleName} from './colormap';
import {lineMaterial, pointsMaterial, surfaceMaterial, type Palette} from './materials';

export interface Look {
  points: boolean;
  surface: boolean;
  wireframe: boolean;
  smooth: boolean;
  marks: boolean;
}

/** Values to colour the surface by, one a triangle. */
export interface Colouring {
  values: Float32Array;
  upper: number;
  scale: ScaleName;
}

export interface Content {
  /** Corners of triangles that are pointed at, in the frame of the mesh. */
  pointed?: Float32Array|undefined;
  /** Nothing of its inside can be seen. */
  solid?: boolean;
  cloud?: LoadedCloud|undefined;
  mesh?: LoadedMesh|undefined;
  wireframe?: Uint32Array|undefined;
  unused?: UnusedPoints|undefined;
  colouring?: Colouring|undefined;
}

const attribute = (positions: Float32Array) => new BufferAttribute(positions, 3);

function geometryOf(positions: BufferAttribute, index?: Uint32Array): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', positions);
  if (index) geometry.setIndex(new BufferAttribute(index, 1));
  return geometry;
}

/** A colour a triangle needs corners that no other triangle shares. */
function separated(mesh: LoadedMesh, colours: Uint8Array): BufferGeometry {
  const corners = mesh.index.length;
  const positions = new Float32Array(3 * corners);
  const bytes = new Uint8Array(3 * corners);
  for (let c = 0; c < corners; c += 1) {
    const [v, t] = [mesh.index[c], Math.floor(c / 3)];
    for (let k = 0; k < 3; k += 1) {
      positions[3 * c + k] = mesh.positions[3 * v + k];
      bytes[3 * c + k] = colours[3 * t + k];
    }
  }
  const geometry = geometryOf(attribute(positions));
  geometry.setAttribute('color', new BufferAttribute(bytes, 3, true));
  return geometry;
}

export class Layers {
  readonly group = new Group();
  private fine: Object3D[] = [];
  private coarse: Object3D|undefined;

  /** Builds everything anew; what was there is disposed of. */
  show(content: Content, look: Look, palette: Palette, planes: Plane[], origin: [number, number, number]): void {
    this.dispose();
    const {cloud, mesh} = content;
    if (cloud && look.points)
      this.addPoints(cloud.positions, cloud.origin, origin, palette.point, mesh ? 2.5 : 2, planes);
    if (mesh) this.addMesh(mesh, content, look, palette, planes, origin);
    if (cloud && content.unused && look.marks) {
      this.addPoints(content.unused.outside, cloud.origin, origin, palette.unused, 6, planes, true);
      this.addPoints(content.unused.interior, cloud.origin, origin, palette.interior, 6, planes, true);
    }
  }

  /** Draws the stand-in in place of a large mesh while the camera moves. */
  moving(on: boolean): void {
    if (!this.coarse) return;
    this.coarse.visible = on;
    for (const object of this.fine) object.visible = !on;
  }

  get heavy(): boolean {
    return this.coarse !== undefined;
  }

  private place(object: Object3D, from: [number, number, number], origin: [number, number, number], order = 0): void {
    object.position.set(from[0] - origin[0], from[1] - origin[1], from[2] - origin[2]);
    object.renderOrder = order;
    object.frustumCulled = false;
    this.group.add(object);
  }

  private addPoints(
      positions: Float32Array, from: [number, number, number], origin: [number, number, number],
      color: Palette['point'], size: number, planes: Plane[], front = false): void {
    if (positions.length === 0) return;
    const material = pointsMaterial(color, size, planes);
    // Marks inside a closed surface would be seen by nobody.
    material.depthTest = !front;
    this.place(new Points(geometryOf(attribute(positions)), material), from, origin, front ? 3 : 0);
  }

  private addMesh(mesh: LoadedMesh, content: Content, look: Look, palette: Palette, planes: Plane[], origin: [
    number, number, number
  ]): void {
    const positions = attribute(mesh.positions);
    const {colouring} = content;
    if (look.surface) {
      const surface = new Mesh(
          this.surfaceGeometry(mesh, positions, colouring, look.smooth),
          surfaceMaterial(palette, look.smooth && !colouring, colouring !== undefined, content.solid === true, planes));
      this.place(surface, mesh.origin, origin);
      this.fine = [surface];
    }
    if (look.wireframe && content.wireframe) {
      const lines = new LineSegments(
          geometryOf(positions, content.wireframe), lineMaterial(palette.edge, look.surface ? 0.35 : 0.8, planes));
      this.place(lines, mesh.origin, origin, 1);
      this.fine.push(lines);
    }
    if (mesh.coarse && look.surface) {
      this.coarse = new Mesh(
          geometryOf(positions, mesh.coarse), surfaceMaterial(palette, false, false, content.solid === true, planes));
      this.coarse.visible = false;
      this.place(this.coarse, mesh.origin, origin);
    }
    if (content.pointed) {
      const outline = new LineSegments(geometryOf(attribute(content.pointed)), lineMaterial(palette.mark, 1, []));
      (outline.material as LineBasicMaterial).depthTest = false;
      this.place(outline, mesh.origin, origin, 4);
    }
    if (!look.marks) return;
    for (const [edges, color] of [
             [mesh.edges.boundary, palette.boundary], [mesh.edges.nonManifold, palette.nonManifold]] as const) {
      if (edges.length > 0)
        this.place(
            new LineSegments(geometryOf(positions, edges), lineMaterial(color, 1, planes)), mesh.origin, origin, 2);
    }
  }

  private surfaceGeometry(
      mesh: LoadedMesh, positions: BufferAttribute, colouring: Colouring|undefined, smooth: boolean): BufferGeometry {
    if (colouring) return separated(mesh, coloursOf(colouring.values, colouring.upper, colouring.scale));
    const geometry = geometryOf(positions, mesh.index);
    if (smooth) geometry.computeVertexNormals();
    return geometry;
  }

  dispose(): void {
    for (const object of [...this.group.children]) {
      const drawn = object as Mesh;
      drawn.geometry.dispose();
      (Array.isArray(drawn.material) ? drawn.material : [drawn.material]).forEach((material) => material.dispose());
      this.group.remove(object);
    }
    this.fine = [];
    this.coarse = undefined;
  }
}
