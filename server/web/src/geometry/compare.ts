// How far one mesh is from another, and which points a mesh encloses.
import { BufferAttribute, BufferGeometry, DoubleSide, Ray, Vector3 } from 'three';
import { MeshBVH, type HitPointInfo } from 'three-mesh-bvh';
import type { MeshData } from './mesh_data';

export type Shift = [number, number, number];
export const shiftBetween = (from: Shift, to: Shift): Shift => [from[0] - to[0], from[1] - to[1], from[2] - to[2]];

export function treeOf(mesh: MeshData): MeshBVH {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(mesh.positions, 3));
  // The tree reorders what it is given.
  geometry.setIndex(new BufferAttribute(mesh.index.slice(), 1));
  return new MeshBVH(geometry);
}

/** Distance of each vertex to the surface of the other mesh. */
export function distancesToSurface(tree: MeshBVH, positions: Float32Array, shift: Shift): Float32Array {
  const distances = new Float32Array(positions.length / 3);
  const point = new Vector3();
  const hit: HitPointInfo = { point: new Vector3(), distance: 0, faceIndex: 0 };
  for (let v = 0; v < distances.length; v += 1) {
    point.set(positions[3 * v] + shift[0], positions[3 * v + 1] + shift[1], positions[3 * v + 2] + shift[2]);
    distances[v] = tree.closestPointToPoint(point, hit)?.distance ?? 0;
  }
  return distances;
}

/** True if a ray from the point passes the closed surface an odd number of times. */
export function encloses(tree: MeshBVH, x: number, y: number, z: number): boolean {
  // A direction that no edge of a made shape is likely to lie in.
  const ray = new Ray(new Vector3(x, y, z), new Vector3(0.5403, 0.2831, 0.7923).normalize());
  return tree.raycast(ray, DoubleSide).length % 2 === 1;
}
