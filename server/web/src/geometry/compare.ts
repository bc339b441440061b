// SPDX-License-Identifier: GPL-3.0-or-later
// How far one mesh is from another, and which points a mesh encloses.
import {BufferAttribute, BufferGeometry, DoubleSide, Ray, Vector3} from 'three';
import {MeshBVH, type HitPointInfo} from 'three-mesh-bvh';
import type {MeshData} from './mesh_data';

export type Shift = [number, number, number];
export const shiftBetween = (from: Shift, to: Shift): Shift => [from[0] - to[0], from[1] - to[1], from[2] - to[2]];

export function treeOf(mesh: MeshData): MeshBVH {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(mesh.positions, 3));
  // The tree reorders what it is given.
  geometry.setIndex(new BufferAttribute(mesh.index.slice(), 1));
  return new MeshBVH(geometry);
}

/** From here on a triangle is judged by its middle alone. */
const kMany = 300_000;

/**
 * The largest of the distances at the corners, the middles of the edges and the middle of each triangle. Corners alone
 * would not do: two meshes through the same points have them all in common.
 */
export function distancesOfTriangles(
    {positions: p, index}: MeshData, shift: Shift,
    distance: (x: number, y: number, z: number) => number): Float32Array {
  const triangles = index.length / 3;
  const values = new Float32Array(triangles);
  const weights = triangles > kMany ?
      [[1 / 3, 1 / 3, 1 / 3]] :
      [[1 / 3, 1 / 3, 1 / 3], [0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
  for (let t = 0; t < triangles; t += 1) {
    const [u, v, w] = [3 * index[3 * t], 3 * index[3 * t + 1], 3 * index[3 * t + 2]];
    for (const [a, b, c] of weights) {
      const at = (k: number) => a * p[u + k] + b * p[v + k] + c * p[w + k] + shift[k];
      values[t] = Math.max(values[t], distance(at(0), at(1), at(2)));
    }
  }
  return values;
}

/** Distance of a place to the surface. */
export function toSurface(tree: MeshBVH): (x: number, y: number, z: number) => number {
  const point = new Vector3();
  const hit: HitPointInfo = {point: new Vector3(), distance: 0, faceIndex: 0};
  return (x, y, z) => tree.closestPointToPoint(point.set(x, y, z), hit)?.distance ?? 0;
}

/** True if a ray from the point passes the closed surface an odd number of times. */
export function encloses(tree: MeshBVH, x: number, y: number, z: number): boolean {
  // A direction that no edge of a made shape is likely to lie in.
  const ray = new Ray(new Vector3(x, y, z), new Vector3(0.5403, 0.2831, 0.7923).normalize());
  return tree.raycast(ray, DoubleSide).length % 2 === 1;
}
