// SPDX-License-Identifier: GPL-3.0-or-later
// Positions of a PLY: ascii and binary, every scalar type, any order of properties and elements.
import {UnreadableCloud} from './cloud_data';

interface Property {
  name: string;
  type: string;
  countType?: string;
}
interface Element {
  name: string;
  count: number;
  properties: Property[];
}
interface Header {
  format: string;
  elements: Element[];
  bodyAt: number;
}

const sizes: Record<string, number> = {
  char: 1,
  int8: 1,
  uchar: 1,
  uint8: 1,
  short: 2,
  int16: 2,
  ushort: 2,
  uint16: 2,
  int: 4,
  int32: 4,
  uint: 4,
  uint32: 4,
  float: 4,
  float32: 4,
  double: 8,
  float64: 8,
};

function readScalar(view: DataView, at: number, type: string, little: boolean): number {
  switch (type) {
    case 'char':
    case 'int8':
      return view.getInt8(at);
    case 'uchar':
    case 'uint8':
      return view.getUint8(at);
    case 'short':
    case 'int16':
      return view.getInt16(at, little);
    case 'ushort':
    case 'uint16':
      return view.getUint16(at, little);
    case 'int':
    case 'int32':
      return view.getInt32(at, little);
    case 'uint':
    case 'uint32':
      return view.getUint32(at, little);
    case 'float':
    case 'float32':
      return view.getFloat32(at, little);
    default:
      return view.getFloat64(at, little);
  }
}

function readHeader(bytes: Uint8Array): Header {
  const text = new TextDecoder('latin1').decode(bytes.subarray(0, 1 << 16));
  const end = /[\r\n]end_header[ \t]*(?:\r\n|\n|\r)/.exec(text);
  if (!end) throw new UnreadableCloud('the header of the PLY has no end');
  const header: Header = {format: '', elements: [], bodyAt: end.index + end[0].length};
  for (const line of text.slice(0, end.index).split(/\r\n|\n|\r/)) {
    const words = line.trim().split(/\s+/);
    if (words[0] === 'format') header.format = words[1];
    if (words[0] === 'element') header.elements.push({name: words[1], count: Number(words[2]), properties: []});
    if (words[0] === 'property') {
      const list = words[1] === 'list';
      const property: Property =
          list ? {name: words[4], type: words[3], countType: words[2]} : {name: words[2], type: words[1]};
      if (!(property.type in sizes))
        throw new UnreadableCloud(`the PLY has a property of the unknown type '${property.type}'`);
      header.elements.at(-1)?.properties.push(property);
    }
  }
  return header;
}

function axesOf(vertex: Element): number[] {
  const axes = ['x', 'y', 'z'].map(
      (name) => vertex.properties.findIndex((property) => property.name.toLowerCase() === name && !property.countType));
  if (axes.includes(-1)) throw new UnreadableCloud('the PLY has no scalars x, y and z');
  return axes;
}

function skipRow(view: DataView, at: number, element: Element, little: boolean): number {
  let place = at;
  for (const property of element.properties) {
    let repeats = 1;
    if (property.countType) {
      repeats = readScalar(view, place, property.countType, little);
      place += sizes[property.countType];
    }
    place += repeats * sizes[property.type];
  }
  return place;
}

function readBinary(bytes: Uint8Array, header: Header, vertexAt: number): Float32Array|Float64Array {
  const little = header.format === 'binary_little_endian';
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let at = header.bodyAt;
  for (const element of header.elements.slice(0, vertexAt)) {
    for (let i = 0; i < element.count; i += 1) at = skipRow(view, at, element, little);
  }
  const vertex = header.elements[vertexAt];
  const axes = axesOf(vertex);
  if (vertex.properties.some((property) => property.countType))
    throw new UnreadableCloud('the vertices of the PLY hold lists');
  const offsets: number[] = [];
  let stride = 0;
  for (const property of vertex.properties) {
    offsets.push(stride);
    stride += sizes[property.type];
  }
  if (at + vertex.count * stride > bytes.length) throw new UnreadableCloud('the PLY ends before its points do');
  const types = axes.map((axis) => vertex.properties[axis].type);
  const single = types.every((type) => type === 'float' || type === 'float32');
  const xyz = single ? new Float32Array(3 * vertex.count) : new Float64Array(3 * vertex.count);
  for (let i = 0; i < vertex.count; i += 1, at += stride) {
    for (let k = 0; k < 3; k += 1) xyz[3 * i + k] = readScalar(view, at + offsets[axes[k]], types[k], little);
  }
  return xyz;
}

function readAscii(bytes: Uint8Array, header: Header, vertexAt: number): Float64Array {
  const vertex = header.elements[vertexAt];
  const axes = axesOf(vertex);
  const lines =
      new TextDecoder('latin1').decode(bytes.subarray(header.bodyAt)).split('\n').filter((line) => line.trim() !== '');
  const skip = header.elements.slice(0, vertexAt).reduce((sum, element) => sum + element.count, 0);
  if (lines.length < skip + vertex.count) throw new UnreadableCloud('the PLY ends before its points do');
  const xyz = new Float64Array(3 * vertex.count);
  for (let i = 0; i < vertex.count; i += 1) {
    const words = lines[skip + i].trim().split(/\s+/);
    for (let k = 0; k < 3; k += 1) xyz[3 * i + k] = Number(words[axes[k]]);
  }
  return xyz;
}

export function readPly(bytes: Uint8Array): Float32Array|Float64Array {
  const header = readHeader(bytes);
  const vertexAt = header.elements.findIndex((element) => element.name === 'vertex');
  if (vertexAt < 0) throw new UnreadableCloud('the PLY has no vertices');
  return header.format === 'ascii' ? readAscii(bytes, header, vertexAt) : readBinary(bytes, header, vertexAt);
}
