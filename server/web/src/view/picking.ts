// SPDX-License-Identifier: GPL-3.0-or-later
// What lies under a place of the picture: a triangle of a mesh, or a point.
import {Matrix4, Mesh, Raycaster, Vector2, Vector3, type Object3D, type PerspectiveCamera, type Plane} from 'three';

export interface Picked {
  kind: 'triangle'|'point';
  index: number;
  /** In the frame of the mesh or cloud, without its origin. */
  place: [number, number, number];
}

/** So near, in pixels, a point is meant. */
const kReach = 9;

/** @param at -1 to 1 in both directions. */
export function pickTriangle(object: Object3D, camera: PerspectiveCamera, at: Vector2, planes: Plane[]): Picked|
    undefined {
  const ray = new Raycaster();
  ray.setFromCamera(at, camera);
  const surfaces = object.children.filter((child): child is Mesh => child instanceof Mesh && child.visible);
  const hit = ray.intersectObjects(surfaces, false)
                  .find(({point}) => planes.every((plane) => plane.distanceToPoint(point) >= 0));
  if (!hit || hit.faceIndex === undefined || hit.faceIndex === null) return undefined;
  return {kind: 'triangle', index: hit.faceIndex, place: hit.object.worldToLocal(hit.point.clone()).toArray()};
}

/**
 * The nearest to the eye of the points near the place on the screen.
 * @param matrix of the positions to the world.
 * @param pixels of the picture.
 */
export function pickPoint(
    positions: Float32Array, matrix: Matrix4, camera: PerspectiveCamera, at: Vector2, pixels: Vector2,
    planes: Plane[]): Picked|undefined {
  const full = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse).multiply(matrix);
  const p = new Vector3();
  let best: {index: number; score: number}|undefined;
  for (let i = 0; i < positions.length; i += 3) {
    p.fromArray(positions, i).applyMatrix4(full);
    const off = Math.hypot(((p.x - at.x) * pixels.x) / 2, ((p.y - at.y) * pixels.y) / 2);
    if (off > kReach || p.z > 1 || p.z < -1) continue;
    // The depth decides, the distance on the screen between points of about the same depth.
    const score = p.z + 0.002 * off;
    if (best && best.score <= score) continue;
    const world = new Vector3().fromArray(positions, i).applyMatrix4(matrix);
    if (planes.every((plane) => plane.distanceToPoint(world) >= 0)) best = {index: i / 3, score};
  }
  if (!best) return undefined;
  const {index} = best;
  return {kind: 'point', index, place: [positions[3 * index], positions[3 * index + 1], positions[3 * index + 2]]};
}
