// SPDX-License-Identifier: GPL-3.0-or-later
// Points of a PCD, and their packed colours: ascii, binary, binary_compressed.
import {UnreadableCloud, type Points} from './cloud_data';

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

/** Where a field begins, and how far it is from one point to the next. */
interface Place {
  at: number;
  stride: number;
  field: Field;
}

function placeOf(fields: Field[], name: string, points: number, columns: boolean): Place|undefined {
  const row = fields.reduce((sum, field) => sum + field.size * field.count, 0);
  let at = 0;
  for (const field of fields) {
    const width = field.size * field.count;
    if (field.name === name && field.count === 1) return {at, stride: columns ? width : row, field};
    at += columns ? width * points : width;
  }
  return undefined;
}

/** Red, green and blue lie in one number of four bytes, blue first. */
function unpacked(packed: (i: number) => number, points: number): Uint8Array {
  const colours = new Uint8Array(3 * points);
  for (let i = 0; i < points; i += 1) {
    const colour = packed(i);
    colours.set([(colour >> 16) & 0xff, (colour >> 8) & 0xff, colour & 0xff], 3 * i);
  }
  return colours;
}

const hasNormals = (fields: Field[]): boolean => fields.some(({name}) => name === 'normal_x' || name === 'nx');

function pick(bytes: Uint8Array, fields: Field[], points: number, columns: boolean): Points {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const places = ['x', 'y', 'z'].map((name) => placeOf(fields, name, points, columns));
  if (places.includes(undefined)) throw new UnreadableCloud('the PCD has no fields x, y and z');
  const xyz = places[0]?.field.size === 8 ? new Float64Array(3 * points) : new Float32Array(3 * points);
  (places as Place[]).forEach(({at, stride, field}, k) => {
    if (field.type !== 'F') throw new UnreadableCloud('the coordinates of the PCD are not floating point');
    for (let i = 0; i < points; i += 1)
      xyz[3 * i + k] =
          field.size === 8 ? view.getFloat64(at + i * stride, true) : view.getFloat32(at + i * stride, true);
  });
  const colour = placeOf(fields, 'rgb', points, columns) ?? placeOf(fields, 'rgba', points, columns);
  const packed = colour?.field.size === 4 ? colour : undefined;
  return {
    xyz,
    colours: packed && unpacked((i) => view.getUint32(packed.at + i * packed.stride, true), points),
    normals: hasNormals(fields),
  };
}

function pickAscii(text: string, fields: Field[], points: number): Points {
  const columns: Record<string, number> = {};
  let column = 0;
  for (const field of fields) {
    columns[field.name] = column;
    column += field.count;
  }
  const lines = text.split('\n');
  const cell = (i: number, name: string): string => (lines[i] ?? '').trim().split(/\s+/)[columns[name]] ?? '';
  const xyz = new Float64Array(3 * points);
  for (let i = 0; i < points; i += 1) ['x', 'y', 'z'].forEach((name, k) => (xyz[3 * i + k] = Number(cell(i, name))));
  const colour = fields.find(({name}) => name === 'rgb' || name === 'rgba');
  const view = new DataView(new ArrayBuffer(4));
  const packed = ({name, type}: Field) => (i: number): number => {
    if (type !== 'F') return Number(cell(i, name));
    view.setFloat32(0, Number(cell(i, name)));
    return view.getUint32(0);
  };
  return {xyz, colours: colour && unpacked(packed(colour), points), normals: hasNormals(fields)};
}

export function readPcd(bytes: Uint8Array): Points {
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
  if (end[1] === 'binary') return pick(body, fields, points, false);
  const view = new DataView(body.buffer, body.byteOffset);
  const whole = unpackLzf(body.subarray(8, 8 + view.getUint32(0, true)), view.getUint32(4, true));
  return pick(whole, fields, points, true);
}
