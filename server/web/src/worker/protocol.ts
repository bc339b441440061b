// SPDX-License-Identifier: GPL-3.0-or-later
// What the page asks of its worker. Meshes and clouds stay in the worker under a number; what is drawn is copied out.
import type {CloudData} from '../clouds/cloud_data';
import type {TableOptions} from '../clouds/table';
import type {Box} from '../geometry/box';
import type {Edges} from '../geometry/edges';
import type {MeshData} from '../geometry/mesh_data';
import type {Shapes} from '../geometry/quality';

export interface LoadedMesh extends MeshData {
  handle: number;
  /** Red, green, blue of each vertex, in sRGB. */
  colours?: Uint8Array|undefined;
  shapes: Shapes;
  edges: Omit<Edges, 'all'>;
  /** Drawn while the camera moves; none if the mesh is small. */
  coarse: Uint32Array|undefined;
}
export interface LoadedCloud extends CloudData {
  handle: number;
  /** A survey, or seen from above one height a place: z points up. */
  zUp: boolean;
}
export interface UnusedPoints {
  /** xyz in the frame of the cloud. */
  outside: Float32Array;
  interior: Float32Array;
}
export interface Difference {
  /** By triangle of the first mesh, then of the second, to the surface of the other one. */
  first: Float32Array;
  second: Float32Array;
}

export interface GeometryCalls {
  /** @param table how a text is to be read. */
  loadCloud(bytes: ArrayBuffer, table: TableOptions): Promise<LoadedCloud>;
  loadMesh(glb: ArrayBuffer): Promise<LoadedMesh>;
  wireframe(mesh: number): Promise<Uint32Array>;
  /** By triangle, to the nearest point of the cloud. */
  distances(mesh: number, cloud: number): Promise<Float32Array>;
  unused(mesh: number, cloud: number, closed: boolean): Promise<UnusedPoints>;
  difference(first: number, second: number): Promise<Difference>;
  /** The points within a box as a PLY; the box is in the frame of the positions. */
  cropped(cloud: number, box: Box): Promise<ArrayBuffer>;
  forget(handle: number): Promise<void>;
}

export interface Question {
  id: number;
  call: keyof GeometryCalls;
  words: unknown[];
}
export interface Answer {
  id: number;
  value?: unknown;
  error?: string;
}
