// SPDX-License-Identifier: GPL-3.0-or-later
// Positions, colours and triangles of glTF and GLB. three's GLTFLoader is not used: it also builds materials and
// textures, and its Draco loader starts workers from blobs, which the page's policy forbids.
import {Matrix4, Quaternion, Vector3} from 'three';
import {MeshoptDecoder} from 'three/examples/jsm/libs/meshopt_decoder.module.js';

import {UnreadableCloud, type Points} from './cloud_data';
import {decodeDraco} from './draco';

interface Primitive {
  attributes: Record<string, number>;
  indices?: number;
  mode?: number;
  extensions?: {KHR_draco_mesh_compression?: {bufferView: number; attributes: Record<string, number>}};
}
interface View {
  byteOffset?: number;
  byteLength: number;
  byteStride?: number;
  extensions?: {
    EXT_meshopt_compression?:
        {byteOffset?: number; byteLength: number; byteStride: number; count: number; mode: string; filter?: string}
  };
}
interface Node {
  mesh?: number;
  children?: number[];
  matrix?: number[];
  translation?: number[];
  rotation?: number[];
  scale?: number[];
  extras?: {origin?: [number, number, number]};
}
export interface Gltf {
  asset: {extras?: unknown};
  scene?: number;
  scenes?: {nodes?: number[]}[];
  nodes?: Node[];
  meshes?: {primitives: Primitive[]}[];
  accessors?: {
    bufferView?: number;
    byteOffset?: number; componentType: number; count: number; type: string;
    normalized?: boolean
  }[];
  bufferViews?: View[];
  buffers?: {uri?: string; byteLength: number}[];
}

const kJson = 0x4e4f534a;

export function openGlb(bytes: Uint8Array): {json: Gltf; buffer: Uint8Array} {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const length = view.getUint32(12, true);
  if (view.getUint32(16, true) !== kJson || 20 + length > bytes.length)
    throw new UnreadableCloud('the GLB has no JSON');
  const json = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length))) as Gltf;
  const at = 20 + length;
  const buffer = at + 8 <= bytes.length ? bytes.subarray(at + 8, at + 8 + view.getUint32(at, true)) : new Uint8Array();
  return {json, buffer};
}

export function openGltf(bytes: Uint8Array): {json: Gltf; buffer: Uint8Array} {
  const json = JSON.parse(new TextDecoder().decode(bytes)) as Gltf;
  const uri = json.buffers?.[0]?.uri ?? '';
  if (!uri.startsWith('data:')) throw new UnreadableCloud('the glTF keeps its points in another file');
  const text = atob(uri.slice(uri.indexOf(',') + 1));
  return {json, buffer: Uint8Array.from(text, (c) => c.charCodeAt(0))};
}

/** The bytes of a view, unpacked where meshoptimizer has packed them. */
async function bytesOf(view: View, buffer: Uint8Array): Promise<Uint8Array> {
  const packed = view.extensions?.EXT_meshopt_compression;
  const {byteOffset = 0, byteLength} = packed ?? view;
  if (byteOffset + byteLength > buffer.length) throw new UnreadableCloud('the glTF ends before its data does');
  const bytes = buffer.subarray(byteOffset, byteOffset + byteLength);
  if (!packed) return bytes;
  await MeshoptDecoder.ready;
  const unpacked = new Uint8Array(packed.count * packed.byteStride);
  MeshoptDecoder.decodeGltfBuffer(
      unpacked, packed.count, packed.byteStride, bytes, packed.mode, packed.filter ?? 'NONE');
  return unpacked;
}

type Read = (data: DataView, at: number) => number;
/** By component type: size, what reads one, and what 1 is if it is normalised. */
const components: Record<number, [number, Read, number]> = {
  5120: [1, (data, at) => data.getInt8(at), 127],
  5121: [1, (data, at) => data.getUint8(at), 255],
  5122: [2, (data, at) => data.getInt16(at, true), 32767],
  5123: [2, (data, at) => data.getUint16(at, true), 65535],
  5125: [4, (data, at) => data.getUint32(at, true), 1],
  5126: [4, (data, at) => data.getFloat32(at, true), 1],
};

async function readAccessor<T extends Float32Array|Uint32Array>(
    json: Gltf, buffer: Uint8Array, index: number, width: number, make: (size: number) => T): Promise<T> {
  const accessor = json.accessors?.[index];
  const view = json.bufferViews?.[accessor?.bufferView ?? -1];
  if (!accessor || !view) throw new UnreadableCloud('the glTF has positions without bytes');
  const known = components[accessor.componentType];
  if (!known)
    throw new UnreadableCloud(`the glTF has numbers of the type ${accessor.componentType}, which is not expected here`);
  const [size, get, one] = known;
  const bytes = await bytesOf(view, buffer);
  const stride = view.extensions?.EXT_meshopt_compression?.byteStride ?? view.byteStride ?? size * width;
  const start = accessor.byteOffset ?? 0;
  if (start + (accessor.count - 1) * stride + size * width > bytes.length)
    throw new UnreadableCloud('the glTF ends before its data does');
  const data = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const scale = accessor.normalized ? 1 / one : 1;
  const out = make(accessor.count * width);
  for (let i = 0, to = 0; i < accessor.count; i += 1) {
    for (let k = 0; k < width; k += 1) out[to++] = get(data, start + i * stride + k * size) * scale;
  }
  return out;
}

export interface PrimitiveData {
  positions: Float32Array;
  index?: Uint32Array|undefined;
  colours?: Uint8Array|undefined;
  normals: boolean;
}

/** Bytes of red, green and blue, whatever they are stored as. */
async function readColours(json: Gltf, buffer: Uint8Array, accessor: number): Promise<Uint8Array> {
  const width = json.accessors?.[accessor]?.type === 'VEC4' ? 4 : 3;
  const values = await readAccessor(json, buffer, accessor, width, (size) => new Float32Array(size));
  const channels = width === 3 ? values : values.filter((_, i) => i % 4 < 3);
  return Uint8Array.from(channels, (value) => Math.round(255 * Math.min(1, Math.max(0, value))));
}

export async function readPrimitive(json: Gltf, buffer: Uint8Array, primitive: Primitive): Promise<PrimitiveData> {
  const draco = primitive.extensions?.KHR_draco_mesh_compression;
  if (draco) {
    const view = json.bufferViews?.[draco.bufferView];
    if (!view) throw new UnreadableCloud('the glTF has Draco data without bytes');
    const start = view.byteOffset ?? 0;
    return decodeDraco(buffer.slice(start, start + view.byteLength), draco.attributes);
  }
  const {POSITION, NORMAL, COLOR_0} = primitive.attributes;
  const positions = await readAccessor(json, buffer, POSITION, 3, (size) => new Float32Array(size));
  const colours = COLOR_0 === undefined ? undefined : await readColours(json, buffer, COLOR_0);
  const normals = NORMAL !== undefined;
  if (primitive.indices === undefined) return {positions, colours, normals};
  const index = await readAccessor(json, buffer, primitive.indices, 1, (size) => new Uint32Array(size));
  return {positions, colours, normals, index};
}

function localMatrix(node: Node): Matrix4 {
  if (node.matrix) return new Matrix4().fromArray(node.matrix);
  const [t, r, s] = [node.translation ?? [0, 0, 0], node.rotation ?? [0, 0, 0, 1], node.scale ?? [1, 1, 1]];
  return new Matrix4().compose(new Vector3(...t), new Quaternion(...r), new Vector3(...s));
}

/** Points of all meshes of the scene, where their nodes put them. */
export async function readScenePoints(json: Gltf, buffer: Uint8Array): Promise<Points> {
  const values: number[] = [];
  const colours: number[] = [];
  let normals = false;
  const visit = async(index: number, parent: Matrix4, depth: number): Promise<void> => {
    const node = json.nodes?.[index];
    if (!node || depth > 64) return;
    const world = parent.clone().multiply(localMatrix(node));
    for (const primitive of json.meshes?.[node.mesh ?? -1]?.primitives ?? []) {
      const part = await readPrimitive(json, buffer, primitive);
      const p = new Vector3();
      for (let i = 0; i < part.positions.length; i += 3) {
        p.fromArray(part.positions, i).applyMatrix4(world);
        values.push(p.x, p.y, p.z);
      }
      part.colours?.forEach((byte) => colours.push(byte));
      normals ||= part.normals;
    }
    for (const child of node.children ?? []) await visit(child, world, depth + 1);
  };
  for (const root of json.scenes?.[json.scene ?? 0]?.nodes ?? []) await visit(root, new Matrix4(), 0);
  const coloured = colours.length === values.length;
  return {xyz: Float64Array.from(values), colours: coloured ? Uint8Array.from(colours) : undefined, normals};
}
