// SPDX-License-Identifier: GPL-3.0-or-later
// Corners of the triangles of an STL, ascii or binary.
import {UnreadableCloud, type Points} from './cloud_data';

export function isBinaryStl(bytes: Uint8Array): boolean {
  if (bytes.length < 84) return false;
  const triangles = new DataView(bytes.buffer, bytes.byteOffset).getUint32(80, true);
  const length = 84 + 50 * triangles;
  // Bytes may follow the last triangle; text has no zero where the highest byte of a count is.
  const solid = new TextDecoder('latin1').decode(bytes.subarray(0, 5)).toLowerCase() === 'solid';
  return triangles > 0 && (bytes.length === length || (bytes.length > length && !solid && bytes[83] === 0));
}

export function readStl(bytes: Uint8Array): Points {
  if (!isBinaryStl(bytes)) {
    const values: number[] = [];
    const text = new TextDecoder('latin1').decode(bytes);
    for (const found of text.matchAll(/vertex\s+(\S+)\s+(\S+)\s+(\S+)/gi))
      values.push(Number(found[1]), Number(found[2]), Number(found[3]));
    if (values.length === 0) throw new UnreadableCloud('the STL holds no triangles');
    return {xyz: Float64Array.from(values)};
  }
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  const triangles = view.getUint32(80, true);
  const xyz = new Float32Array(9 * triangles);
  for (let t = 0; t < triangles; t += 1) {
    for (let k = 0; k < 9; k += 1) xyz[9 * t + k] = view.getFloat32(84 + 50 * t + 12 + 4 * k, true);
  }
  return {xyz};
}
