// SPDX-License-Identifier: GPL-3.0-or-later
// Points as binary PLY: coordinates as they were in the file, colours where there are.
import {isInside, type Box} from '../geometry/box';
import type {CloudData} from './cloud_data';

/** The points within a box, which is in the frame of the positions. */
export function writePly({positions, origin, colours}: CloudData, box: Box): ArrayBuffer {
  const kept: number[] = [];
  for (let i = 0; i < positions.length / 3; i += 1) {
    if (isInside(positions, i, box)) kept.push(i);
  }
  // What float32 holds exactly stays float32.
  const wide = origin.some((value) => value !== 0);
  const [type, size] = wide ? ['double', 8] : ['float', 4];
  const properties = ['x', 'y', 'z'].map((name) => `property ${type} ${name}`);
  if (colours) properties.push(...['red', 'green', 'blue'].map((name) => `property uchar ${name}`));
  const header =
      `ply\nformat binary_little_endian 1.0\nelement vertex ${kept.length}\n${properties.join('\n')}\nend_header\n`;
  const head = new TextEncoder().encode(header);
  const stride = 3 * size + (colours ? 3 : 0);
  const bytes = new Uint8Array(head.length + stride * kept.length);
  bytes.set(head);
  const view = new DataView(bytes.buffer);
  kept.forEach((point, row) => {
    const at = head.length + stride * row;
    for (let k = 0; k < 3; k += 1) {
      const value = positions[3 * point + k] + origin[k];
      if (wide)
        view.setFloat64(at + size * k, value, true);
      else
        view.setFloat32(at + size * k, value, true);
      if (colours) view.setUint8(at + 3 * size + k, colours[3 * point + k]);
    }
  });
  return bytes.buffer;
}
