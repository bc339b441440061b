// SPDX-License-Identifier: GPL-3.0-or-later
// Points of a LAS (1.0 to 1.4): integers, scaled and moved as the header says; their intensity, class and colour.
// LAZ is left to the server.
import {colourBytes, UnreadableCloud, type Points} from './cloud_data';

/** Where the colour begins in a record, by its format. */
const kColour: Record<number, number> = {
  2: 20,
  3: 28,
  5: 28,
  7: 30,
  8: 30,
  10: 30
};

/** What is measured of each point besides its place; nothing where it is the same for all. */
function attributesOf(view: DataView, start: number, stride: number, points: number, kind: number):
    Pick<Points, 'colours'|'intensity'|'classes'> {
  const of = (i: number, at: number): number => start + i * stride + at;
  const intensity = Float32Array.from({length: points}, (_, i) => view.getUint16(of(i, 12), true));
  const [classAt, mask] = kind >= 6 ? [16, 0xff] : [15, 0x1f];
  const classes = Uint8Array.from({length: points}, (_, i) => view.getUint8(of(i, classAt)) & mask);
  const colourAt = kColour[kind];
  const channels = colourAt !== undefined && colourAt + 6 <= stride &&
      Float32Array.from(
          {length: 3 * points}, (_, c) => view.getUint16(of(Math.floor(c / 3), colourAt + 2 * (c % 3)), true));
  return {
    intensity: intensity.some((value) => value !== intensity[0]) ? intensity : undefined,
    classes: classes.some((value) => value !== classes[0]) ? classes : undefined,
    colours: channels ? colourBytes(channels, true) : undefined,
  };
}

export function readLas(bytes: Uint8Array): Points {
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
  return {xyz, ...(stride >= 20 ? attributesOf(view, start, stride, points, kind) : {})};
}
