// SPDX-License-Identifier: GPL-3.0-or-later
// Points of a PLY, and their colours: ascii and binary, every scalar type, any order of properties and elements.
import {colourBytes, UnreadableCloud, type Points} from './cloud_data';

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

/** Where scalars of these names are among the properties; nothing if one is missing. */
function scalarsOf(vertex: Element, names: string[]): number[]|undefined {
  const found = names.map(
      (name) => vertex.properties.findIndex((property) => property.name.toLowerCase() === name && !property.countType));
  return found.includes(-1) ? undefined : found;
}

function axesOf(vertex: Element): number[] {
  const axes = scalarsOf(vertex, ['x', 'y', 'z']);
  if (!axes) throw new UnreadableCloud('the PLY has no scalars x, y and z');
  return axes;
}

const kColourNames = [['red', 'green', 'blue'], ['r', 'g', 'b'], ['diffuse_red', 'diffuse_green', 'diffuse_blue']];

const coloursOf = (vertex: Element): number[]|undefined =>
    kColourNames.map((names) => scalarsOf(vertex, names)).find((found) => found !== undefined);

/** Values of some properties of all vertices, by the vertex. */
type Pick = (properties: number[]) => Float64Array;

function pointsOf(vertex: Element, xyz: Float32Array|Float64Array, pick: Pick): Points {
  const colours = coloursOf(vertex);
  const integers = colours !== undefined && !/float|double/.test(vertex.properties[colours[0]].type);
  return {
    xyz,
    colours: colours && colourBytes(pick(colours), integers),
    normals: scalarsOf(vertex, ['nx', 'ny', 'nz']) !== undefined,
  };
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

function readBinary(bytes: Uint8Array, header: Header, vertexAt: number): Points {
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
  const pick = (properties: number[]): Float64Array => {
    const width = properties.length;
    const values = new Float64Array(width * vertex.count);
    properties.forEach((property, k) => {
      const {type} = vertex.properties[property];
      for (let i = 0; i < vertex.count; i += 1)
        values[width * i + k] = readScalar(view, at + i * stride + offsets[property], type, little);
    });
    return values;
  };
  return pointsOf(vertex, single ? Float32Array.from(pick(axes)) : pick(axes), pick);
}

function readAscii(bytes: Uint8Array, header: Header, vertexAt: number): Points {
  const vertex = header.elements[vertexAt];
  const lines =
      new TextDecoder('latin1').decode(bytes.subarray(header.bodyAt)).split('\n').filter((line) => line.trim() !== '');
  const skip = header.elements.slice(0, vertexAt).reduce((sum, element) => sum + element.count, 0);
  const axes = axesOf(vertex);
  if (lines.length < skip + vertex.count) throw new UnreadableCloud('the PLY ends before its points do');
  const pick = (properties: number[]): Float64Array => {
    const values = new Float64Array(properties.length * vertex.count);
    for (let i = 0; i < vertex.count; i += 1) {
      const words = lines[skip + i].trim().split(/\s+/);
      properties.forEach((property, k) => (values[properties.length * i + k] = Number(words[property])));
    }
    return values;
  };
  return pointsOf(vertex, pick(axes), pick);
}

export function readPly(bytes: Uint8Array): Points {
  const header = readHeader(bytes);
  const vertexAt = header.elements.findIndex((element) => element.name === 'vertex');
  if (vertexAt < 0) throw new UnreadableCloud('the PLY has no vertices');
  return header.format === 'ascii' ? readAscii(bytes, header, vertexAt) : readBinary(bytes, header, vertexAt);
}
