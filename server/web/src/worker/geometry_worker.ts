// SPDX-License-Identifier: GPL-3.0-or-later
// Everything that takes long: reading files, measuring, comparing.
import type {CloudData} from '../clouds/cloud_data';
import {openGlb, readPrimitive} from '../clouds/gltf';
import {readCloud} from '../clouds/read_cloud';
import {writePly} from '../clouds/write_ply';
import {distancesOfTriangles, encloses, shiftBetween, toSurface, treeOf} from '../geometry/compare';
import {edgesOf} from '../geometry/edges';
import type {MeshData} from '../geometry/mesh_data';
import {diagonalOf, distancesTo, NearestPoints} from '../geometry/nearest';
import {isHeightField} from '../geometry/relief';
import {shapesOf} from '../geometry/quality';
import {simplified} from '../geometry/simplify';
import type {Answer, GeometryCalls, Question} from './protocol';

/** From here on a coarse stand-in is drawn while the camera moves. */
const kLarge = 40_000;
const kCoarse = 20_000;
/** A vertex is the point it was made of up to what rounding its origin takes: this part of the cloud's diagonal. */
const kRounding = 2 ** -20;

const clouds = new Map<number, CloudData>();
const meshes = new Map<number, MeshData&{colours?: Uint8Array | undefined}>();
let handles = 0;

function held<T>(all: Map<number, T>, handle: number): T {
  const found = all.get(handle);
  if (!found) throw new Error(`nothing is held under ${handle}`);
  return found;
}

async function meshOf(glb: ArrayBuffer): Promise<MeshData&{colours?: Uint8Array | undefined}> {
  const {json, buffer} = openGlb(new Uint8Array(glb));
  const primitive = json.meshes?.[0]?.primitives[0];
  if (!primitive) throw new Error('the GLB holds no mesh');
  const {positions, index, colours} = await readPrimitive(json, buffer, primitive);
  if (!index) throw new Error('the mesh has no triangles');
  const origin = json.nodes?.find((node) => node.mesh === 0)?.extras?.origin ?? [0, 0, 0];
  return {positions, index, origin, colours};
}

const calls: GeometryCalls = {
  async loadCloud(bytes, table) {
    const cloud = await readCloud(new Uint8Array(bytes), table);
    clouds.set(++handles, cloud);
    const zUp = cloud.format === 'LAS' || isHeightField(cloud.positions);
    return {...cloud, handle: handles, zUp};
  },
  async loadMesh(glb) {
    const mesh = await meshOf(glb);
    meshes.set(++handles, mesh);
    const {boundary, nonManifold} = edgesOf(mesh);
    const coarse = mesh.index.length > 3 * kLarge ? simplified(mesh, kCoarse) : undefined;
    return {...mesh, handle: handles, shapes: shapesOf(mesh), edges: {boundary, nonManifold}, coarse};
  },
  wireframe: (mesh) => Promise.resolve(edgesOf(held(meshes, mesh)).all),
  distances(mesh, cloud) {
    const [m, c] = [held(meshes, mesh), held(clouds, cloud)];
    const points = new NearestPoints(c.positions);
    return Promise.resolve(
        distancesOfTriangles(m, shiftBetween(m.origin, c.origin), (x, y, z) => points.distance(x, y, z)));
  },
  unused(mesh, cloud, closed) {
    const [m, c] = [held(meshes, mesh), held(clouds, cloud)];
    const shift = shiftBetween(c.origin, m.origin);
    const distances = distancesTo(new NearestPoints(m.positions), c.positions, shift);
    const tolerance = m.origin.concat(c.origin).every((x) => x === 0) ? 0 : kRounding * diagonalOf(c.positions);
    const tree = closed ? treeOf(m) : undefined;
    const found = {outside: [] as number[], interior: [] as number[]};
    distances.forEach((distance, i) => {
      if (distance <= tolerance) return;
      const [x, y, z] = c.positions.subarray(3 * i, 3 * i + 3);
      const inside = tree ? encloses(tree, x + shift[0], y + shift[1], z + shift[2]) : false;
      (inside ? found.interior : found.outside).push(x, y, z);
    });
    return Promise.resolve({outside: Float32Array.from(found.outside), interior: Float32Array.from(found.interior)});
  },
  difference(first, second) {
    const [a, b] = [held(meshes, first), held(meshes, second)];
    return Promise.resolve({
      first: distancesOfTriangles(a, shiftBetween(a.origin, b.origin), toSurface(treeOf(b))),
      second: distancesOfTriangles(b, shiftBetween(b.origin, a.origin), toSurface(treeOf(a))),
    });
  },
  cropped: (cloud, box) => Promise.resolve(writePly(held(clouds, cloud), box)),
  forget(handle) {
    clouds.delete(handle);
    meshes.delete(handle);
    return Promise.resolve();
  },
};

self.onmessage = async ({data}: MessageEvent<Question>) => {
  const answer: Answer = {id: data.id};
  try {
    answer.value = await (calls[data.call] as (...words: unknown[]) => Promise<unknown>)(...data.words);
  } catch (failure) {
    answer.error = failure instanceof Error ? failure.message : String(failure);
  }
  self.postMessage(answer);
};
