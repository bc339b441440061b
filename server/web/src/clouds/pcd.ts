// SPDX-License-Identifier: GPL-3.0-or-later
// Positions of a PCD: ascii, binary, binary_compressed.
import {UnreadableCloud} from './cloud_data';

interface Field {
  name: string;
  size: number;
  type: string;
  count: number;
}

function fieldsOf(header: Map<string, string[]>): Field[] {
  const names = (header.get('FIELDS') ?? []).map((name) => name.toLowerCase());
  const numbers = (key: string, otherwise: number) => names.map((_, i) => Number(header.get(key)?.[i] ?? otherwise));
  const size = numbers('SIZE', 4);
  const times = numbers('COUNT', 1);
  return names.map((name, i) => ({name, size: size[i], type: header.get('TYPE')?.[i] ?? 'F', count: times[i]}));
}

/** LZF, as PCL writes it. */
export function unpackLzf(packed: Uint8Array, size: number): Uint8Array {
  const out = new Uint8Array(size);
  let to = 0;
  for (let at = 0; at < packed.length;) {
    const control = packed[at++];
    if (control < 32) {
      out.set(packed.subarray(at, at + control + 1), to);
      at += control + 1;
      to += control + 1;
      continue;
    }
    let length = control >> 5;
    if (length === 7) length += packed[at++];
    let from = to - ((control & 0x1f) << 8) - packed[at++] - 1;
    if (from < 0 || to + length + 2 > size) throw new UnreadableCloud('the compressed points of the PCD are damaged');
    for (let k = 0; k < length + 2; k += 1) out[to++] = out[from++];
  }
  return out;
}

/** Where each of x, y, z begins, and how far it is from one point to the next. */
type Places = {
  at: number; stride: number; size: number
}[];

function placesOf(fields: Field[], points: number, columns: boolean): Places {
  const row = fields.reduce((sum, field) => sum + field.size * field.count, 0);
  return ['x', 'y', 'z'].map((name) => {
    let at = 0;
    for (const field of fields) {
      const width = field.size * field.count;
      if (field.name === name) {
        if (field.type !== 'F') throw new UnreadableCloud('the coordinates of the PCD are not floating point');
        return {at, stride: columns ? width : row, size: field.size};
      }
      at += columns ? width * points : width;
    }
    throw new UnreadableCloud('the PCD has no fields x, y and z');
  });
}

function pick(bytes: Uint8Array, places: Places, points: number): Float32Array|Float64Array {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const xyz = places[0].size === 8 ? new Float64Array(3 * points) : new Float32Array(3 * points);
  places.forEach(({at, stride, size}, k) => {
    for (let i = 0; i < points; i += 1) {
      xyz[3 * i + k] = size === 8 ? view.getFloat64(at + i * stride, true) : view.getFloat32(at + i * stride, true);
    }
  });
  return xyz;
}

function pickAscii(text: string, fields: Field[], points: number): Float64Array {
  const columns: Record<string, number> = {};
  let column = 0;
  for (const field of fields) {
    columns[field.name] = column;
    column += field.count;
  }
  const xyz = new Float64Array(3 * points);
  const lines = text.split('\n');
  for (let i = 0; i < points; i += 1) {
    const words = (lines[i] ?? '').trim().split(/\s+/);
    ['x', 'y', 'z'].forEach((name, k) => (xyz[3 * i + k] = Number(words[columns[name]])));
  }
  return xyz;
}

export function readPcd(bytes: Uint8Array): Float32Array|Float64Array {
  const text = new TextDecoder('latin1').decode(bytes.subarray(0, 1 << 16));
  const end = /\nDATA\s+(\w+)[^\n]*\n/.exec(text);
  if (!end) throw new UnreadableCloud('the header of the PCD has no end');
  const header = new Map(
      text.slice(0, end.index).split('\n').map((line) => line.trim().split(/\s+/)).map(([key,
                                                                                         ...rest]) => [key, rest]));
  const fields = fieldsOf(header);
  const points =
      Number(header.get('POINTS')?.[0] ?? Number(header.get('WIDTH')?.[0]) * Number(header.get('HEIGHT')?.[0]));
  const body = bytes.subarray(end.index + end[0].length);
  if (end[1] === 'ascii') return pickAscii(new TextDecoder('latin1').decode(body), fields, points);
  if (end[1] === 'binary') return pick(body, placesOf(fields, points, false), points);
  const view = new DataView(body.buffer, body.byteOffset);
  const unpacked = unpackLzf(body.subarray(8, 8 + view.getUint32(0, true)), view.getUint32(4, true));
  return pick(unpacked, placesOf(fields, points, true), points);
}
