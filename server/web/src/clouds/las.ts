// SPDX-License-Identifier: GPL-3.0-or-later
// Positions of a LAS (1.0 to 1.4): integers, scaled and moved as the header says. LAZ is left to the server.
import {UnreadableCloud} from './cloud_data';

export function readLas(bytes: Uint8Array): Float64Array {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const minor = view.getUint8(25);
  const start = view.getUint32(96, true);
  const kind = view.getUint8(104);
  if (kind & 0xc0) throw new UnreadableCloud('the points of the LAS are compressed (LAZ)');
  const stride = view.getUint16(105, true);
  const legacy = view.getUint32(107, true);
  const points = legacy === 0 && minor >= 4 ? Number(view.getBigUint64(247, true)) : legacy;
  if (stride < 12 || start + points * stride > bytes.length)
    throw new UnreadableCloud('the LAS ends before its points do');
  const scale = [131, 139, 147].map((at) => view.getFloat64(at, true));
  const offset = [155, 163, 171].map((at) => view.getFloat64(at, true));
  const xyz = new Float64Array(3 * points);
  for (let i = 0; i < points; i += 1) {
    for (let k = 0; k < 3; k += 1)
      xyz[3 * i + k] = view.getInt32(start + i * stride + 4 * k, true) * scale[k] + offset[k];
  }
  return xyz;
}
