// SPDX-License-Identifier: GPL-3.0-or-later
// Draco, by three.js's own decoder, served beside the page. The wrapper's types are those of emscripten: declared here.
import decoderUrl from 'three/examples/jsm/libs/draco/draco_decoder.wasm?url';
import createDecoder from 'three/examples/jsm/libs/draco/draco_wasm_wrapper.js';

import {UnreadableCloud} from './cloud_data';

interface Geometry {
  ptr: number;
  num_points(): number;
  num_faces(): number;
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
  GetAttribute(geometry: Geometry, id: number): unknown;
  GetAttributeByUniqueId(geometry: Geometry, id: number): unknown;
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

/** Positions of all points, and the triangles if there are any. */
export async function decodeDraco(
    bytes: Uint8Array, positionId?: number): Promise<{positions: Float32Array; index?: Uint32Array}> {
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
    const attribute = positionId === undefined ?
        decoder.GetAttribute(geometry, decoder.GetAttributeId(geometry, module.POSITION)) :
        decoder.GetAttributeByUniqueId(geometry, positionId);
    const size = 12 * geometry.num_points();
    const positions = new Float32Array(copyOut(
        module, size,
        (target) => decoder.GetAttributeDataArrayForAllPoints(geometry, attribute, module.DT_FLOAT32, size, target)));
    if (!isMesh) return {positions};
    const indexSize = 12 * geometry.num_faces();
    const index = new Uint32Array(
        copyOut(module, indexSize, (target) => decoder.GetTrianglesUInt32Array(geometry, indexSize, target)));
    return {positions, index};
  } finally {
    [geometry, buffer, decoder].forEach((object) => module.destroy(object));
  }
}
