// SPDX-License-Identifier: GPL-3.0-or-later
// The objects of one pane: a cloud, a mesh over it, and what is marked on them.
import {BufferAttribute, BufferGeometry, Group, LineSegments, Mesh, Points, type Object3D, type Plane, type PointsMaterial} from 'three';
import {boxOf, sizesOf} from '../geometry/box';
import type {LoadedCloud, LoadedMesh, UnusedPoints} from '../worker/protocol';
import {coloursOf, type ScaleName} from './colormap';
import {lineMaterial, pointsMaterial, surfaceMaterial, type Palette} from './materials';

export interface Look {
  points: boolean;
  surface: boolean;
  wireframe: boolean;
  smooth: boolean;
  marks: boolean;
  /** Shading by depth. */
  shade: boolean;
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
  /** Red, green, blue of each point, in sRGB. */
  pointColours?: Uint8Array|undefined;
  mesh?: LoadedMesh|undefined;
  /** Red, green, blue of each vertex, in sRGB. */
  vertexColours?: Uint8Array|undefined;
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

/** How everything of one picture is drawn. */
export interface Setting {
  look: Look;
  palette: Palette;
  planes: Plane[];
  /** Of the picture: taken from everything in it. */
  origin: Place;
}

type Place = [number, number, number];

/** Order of drawing: lines over surfaces, marks over both. */
enum Order {
  body,
  wireframe,
  edges,
  marks,
  pointed
}

/** Pixels of a mark. */
const kMark = 6;
/** Of the distance of points on a surface of the size of the box, so that neighbours nearly touch. */
const kPointShare = 1.1;

/** The size of a point where the diagonal of the cloud has the length 2. */
function sizeOfPoint(positions: Float32Array): number {
  const [x, y, z] = sizesOf(boxOf(positions));
  const area = 2 * (x * y + y * z + z * x);
  return (kPointShare * 2 * Math.sqrt(area / (positions.length / 3))) / (Math.hypot(x, y, z) || 1);
}

export class Layers {
  readonly group = new Group();
  private fine: Object3D[] = [];
  private coarse: Object3D|undefined;

  /** Builds everything anew; what was there is disposed of. */
  show(content: Content, setting: Setting): void {
    this.dispose();
    const {cloud, mesh, unused, pointColours} = content;
    const {look, palette, origin} = setting;
    if (cloud && look.points) {
      const size = sizeOfPoint(cloud.positions);
      const material =
          pointsMaterial({color: pointColours ? undefined : palette.point, size, inSpace: true}, setting.planes);
      this.addPoints(cloud.positions, material, cloud.origin, setting, pointColours);
    }
    if (mesh) this.addMesh(mesh, content, setting);
    if (content.pointed) this.addPointed(content.pointed, (mesh ?? cloud)?.origin ?? origin, setting);
    if (!cloud || !unused || !look.marks) return;
    for (const [points, color] of [[unused.outside, palette.unused], [unused.interior, palette.interior]] as const) {
      const material = pointsMaterial({color, size: kMark, inSpace: false}, setting.planes);
      // Marks inside a closed surface would be seen by nobody.
      material.depthTest = false;
      this.addPoints(points, material, cloud.origin, setting);
    }
  }

  /** Draws the stand-in in place of a large mesh while the camera moves. */
  moving(on: boolean): void {
    if (!this.coarse) return;
    this.coarse.visible = on;
    for (const object of this.fine) object.visible = !on;
  }

  private place(object: Object3D, from: Place, {origin}: Setting, order = Order.body): void {
    object.position.set(from[0] - origin[0], from[1] - origin[1], from[2] - origin[2]);
    object.renderOrder = order;
    object.frustumCulled = false;
    this.group.add(object);
  }

  private addPoints(
      positions: Float32Array, material: PointsMaterial, from: Place, setting: Setting, colours?: Uint8Array): void {
    if (positions.length === 0) return;
    const geometry = geometryOf(attribute(positions));
    if (colours) geometry.setAttribute('color', new BufferAttribute(colours, 3, true));
    this.place(new Points(geometry, material), from, setting, material.depthTest ? Order.body : Order.marks);
  }

  private addPointed(segments: Float32Array, from: Place, setting: Setting): void {
    const material = lineMaterial(setting.palette.mark, 1, []);
    material.depthTest = false;
    this.place(new LineSegments(geometryOf(attribute(segments)), material), from, setting, Order.pointed);
  }

  private addMesh(mesh: LoadedMesh, content: Content, setting: Setting): void {
    const {look, palette, planes} = setting;
    const positions = attribute(mesh.positions);
    if (look.surface) this.addSurface(mesh, positions, content, setting);
    if (look.wireframe && content.wireframe) {
      const material = lineMaterial(palette.edge, look.surface ? 0.35 : 0.8, planes);
      const lines = new LineSegments(geometryOf(positions, content.wireframe), material);
      this.place(lines, mesh.origin, setting, Order.wireframe);
      this.fine.push(lines);
    }
    if (!look.marks) return;
    const {boundary, nonManifold} = mesh.edges;
    for (const [edges, color] of [[boundary, palette.boundary], [nonManifold, palette.nonManifold]] as const) {
      if (edges.length === 0) continue;
      const lines = new LineSegments(geometryOf(positions, edges), lineMaterial(color, 1, planes));
      this.place(lines, mesh.origin, setting, Order.edges);
    }
  }

  private addSurface(mesh: LoadedMesh, positions: BufferAttribute, content: Content, setting: Setting): void {
    const {look: {smooth}, palette, planes} = setting;
    const {colouring, vertexColours} = content;
    const solid = content.solid === true;
    const coloured = vertexColours !== undefined;
    const withColours = (geometry: BufferGeometry): BufferGeometry => {
      if (vertexColours) geometry.setAttribute('color', new BufferAttribute(vertexColours, 3, true));
      return geometry;
    };
    const surface = new Mesh(
        colouring ? separated(mesh, coloursOf(colouring.values, colouring.upper, colouring.scale)) :
                    withColours(geometryOf(positions, mesh.index)),
        surfaceMaterial(
            palette, {smooth: smooth && !colouring, coloured: coloured || colouring !== undefined, solid}, planes));
    if (smooth && !colouring) surface.geometry.computeVertexNormals();
    this.place(surface, mesh.origin, setting);
    this.fine = [surface];
    if (!mesh.coarse) return;
    this.coarse = new Mesh(
        withColours(geometryOf(positions, mesh.coarse)),
        surfaceMaterial(palette, {smooth: false, coloured, solid}, planes));
    this.coarse.visible = false;
    this.place(this.coarse, mesh.origin, setting);
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
