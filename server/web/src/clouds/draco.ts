// SPDX-License-Identifier: GPL-3.0-or-later
// Draco, by three.js's own decoder, served beside the page. The wrapper's types are those of emscripten: declared here.
import decoderUrl from 'three/examples/jsm/libs/draco/draco_decoder.wasm?url';
import createDecoder from 'three/examples/jsm/libs/draco/draco_wasm_wrapper.js';

import {colourBytes, UnreadableCloud, type Points} from './cloud_data';

interface Geometry {
  ptr: number;
  num_points(): number;
  num_faces(): number;
}
interface Attribute {
  num_components(): number;
}
interface Status {
  ok(): boolean;
  error_msg(): string;
}
interface Decoder {
  GetEncodedGeometryType(buffer: unknown): number;
  DecodeBufferToMesh(buffer: unknown, mesh: Geometry): Status;
  DecodeBufferToPointCloud(buffer: unknown, cloud: Geometry): Status;
  GetAttributeId(geometry: Geometry, type: number): number;
  GetAttribute(geometry: Geometry, id: number): Attribute;
  GetAttributeByUniqueId(geometry: Geometry, id: number): Attribute;
  GetAttributeDataArrayForAllPoints(
      geometry: Geometry, attribute: unknown, type: number, bytes: number, target: number): boolean;
  GetTrianglesUInt32Array(geometry: Geometry, bytes: number, target: number): boolean;
}
interface DracoModule {
  Decoder: new() => Decoder;
  DecoderBuffer: new() => {
    Init(bytes: Int8Array, size: number): void
  };
  Mesh: new() => Geometry;
  PointCloud: new() => Geometry;
  TRIANGULAR_MESH: number;
  POSITION: number;
  NORMAL: number;
  COLOR: number;
  DT_FLOAT32: number;
  HEAPU8: Uint8Array;
  _malloc(size: number): number;
  _free(at: number): void;
  destroy(object: unknown): void;
}

let loading: Promise<DracoModule>|undefined;

async function load(): Promise<DracoModule> {
  const wasmBinary = await (await fetch(decoderUrl)).arrayBuffer();
  return (await createDecoder({wasmBinary})) as DracoModule;
}

function copyOut(module: DracoModule, size: number, write: (target: number) => boolean): ArrayBuffer {
  const target = module._malloc(size);
  try {
    if (!write(target)) throw new UnreadableCloud('the Draco data cannot be read');
    return module.HEAPU8.slice(target, target + size).buffer;
  } finally {
    module._free(target);
  }
}

export interface DracoData {
  positions: Float32Array;
  index?: Uint32Array|undefined;
  colours?: Uint8Array|undefined;
  normals: boolean;
}

export const pointsOf = ({positions, colours, normals}: DracoData): Points => ({xyz: positions, colours, normals});

/** The attribute under its number in the file, or the first of a type; none if there is none. */
type Find = (type: number, unique?: number) => Attribute|undefined;

function floatsOf(module: DracoModule, decoder: Decoder, geometry: Geometry, attribute: Attribute): Float32Array {
  const size = 4 * attribute.num_components() * geometry.num_points();
  return new Float32Array(copyOut(
      module, size,
      (target) => decoder.GetAttributeDataArrayForAllPoints(geometry, attribute, module.DT_FLOAT32, size, target)));
}

function coloursOf(module: DracoModule, decoder: Decoder, geometry: Geometry, attribute: Attribute): Uint8Array|
    undefined {
  const width = attribute.num_components();
  if (width < 3) return undefined;
  const values = floatsOf(module, decoder, geometry, attribute);
  const channels = width === 3 ? values : values.filter((_, i) => i % width < 3);
  return colourBytes(channels, channels.some((value) => value > 1));
}

/** Positions of all points, and the triangles and colours if there are any. */
export async function decodeDraco(bytes: Uint8Array, ids: Record<string, number> = {}): Promise<DracoData> {
  loading ??= load();
  const module = await loading;
  const decoder = new module.Decoder();
  const buffer = new module.DecoderBuffer();
  buffer.Init(new Int8Array(bytes.buffer, bytes.byteOffset, bytes.byteLength), bytes.byteLength);
  const isMesh = decoder.GetEncodedGeometryType(buffer) === module.TRIANGULAR_MESH;
  const geometry = isMesh ? new module.Mesh() : new module.PointCloud();
  try {
    const status =
        isMesh ? decoder.DecodeBufferToMesh(buffer, geometry) : decoder.DecodeBufferToPointCloud(buffer, geometry);
    if (!status.ok() || geometry.ptr === 0)
      throw new UnreadableCloud(`the Draco data cannot be read: ${status.error_msg()}`);
    const find: Find = (type, unique) => {
      if (unique !== undefined) return decoder.GetAttributeByUniqueId(geometry, unique);
      const id = decoder.GetAttributeId(geometry, type);
      return id < 0 ? undefined : decoder.GetAttribute(geometry, id);
    };
    const [place, colour] = [find(module.POSITION, ids.POSITION), find(module.COLOR, ids.COLOR_0)];
    if (!place) throw new UnreadableCloud('the Draco data has no positions');
    const positions = floatsOf(module, decoder, geometry, place);
    const colours = colour && coloursOf(module, decoder, geometry, colour);
    const normals = find(module.NORMAL, ids.NORMAL) !== undefined;
    if (!isMesh) return {positions, colours, normals};
    const indexSize = 12 * geometry.num_faces();
    const index = new Uint32Array(
        copyOut(module, indexSize, (target) => decoder.GetTrianglesUInt32Array(geometry, indexSize, target)));
    return {positions, index, colours, normals};
  } finally {
    [geometry, buffer, decoder].forEach((object) => module.destroy(object));
  }
}
