// SPDX-License-Identifier: GPL-3.0-or-later
// Points of a file, told by its content as the server does. What cannot be read here is for the server to judge.
import {toCloudData, UnreadableCloud, type CloudData} from './cloud_data';
import {decodeDraco, pointsOf} from './draco';
import {openGlb, openGltf, readScenePoints} from './gltf';
import {readLas} from './las';
import {readPcd} from './pcd';
import {readPly} from './ply';
import {isBinaryStl, readStl} from './stl';
import type {TableOptions} from './table';
import {decodeText, encodingOf, isObj, readObj, readText} from './text';

/** How texts of other formats begin. */
const kStrangers =
    /^\s*(\[\s*[[{"\]\d-]|<|newmtl|p[1-7f][\r\n]|[cn]?off\s|# vtk datafile|ncols\s|dsaa\s|; fbx|#usda|#vrml|#x3d|iso-10303-21|\{\\rtf|version https:\/\/git-lfs|0\s*\r?\n\s*section)/i;

const isGzip = (bytes: Uint8Array): boolean => bytes[0] === 0x1f && bytes[1] === 0x8b;

async function gunzipped(bytes: Uint8Array): Promise<Uint8Array> {
  const stream = new Blob([bytes as BlobPart]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** @param table how a text is to be read. */
export async function readCloud(given: Uint8Array, table: TableOptions = {}): Promise<CloudData> {
  const unpacked = isGzip(given) ? await gunzipped(given) : given;
  // A byte order mark may stand before any format of text.
  const marked = unpacked[0] === 0xef && unpacked[1] === 0xbb && unpacked[2] === 0xbf;
  const bytes = marked ? unpacked.subarray(3) : unpacked;
  if (encodingOf(bytes) !== 'utf-8') return readCloud(new TextEncoder().encode(decodeText(bytes)), table);
  const head = new TextDecoder('latin1').decode(bytes.subarray(0, 4096));
  if (/^ply[ \t]*[\r\n]/i.test(head)) return toCloudData(readPly(bytes), 'PLY');
  if (head.startsWith('DRACO')) return toCloudData(pointsOf(await decodeDraco(bytes)), 'Draco');
  if (head.startsWith('LASF')) return toCloudData(readLas(bytes), 'LAS');
  if (head.startsWith('glTF')) {
    const {json, buffer} = openGlb(bytes);
    return toCloudData(await readScenePoints(json, buffer), 'GLB');
  }
  if (/^\s*\{/.test(head)) {
    const {json, buffer} = openGltf(bytes);
    return toCloudData(await readScenePoints(json, buffer), 'glTF');
  }
  if (/^(#[^\n]*\n|\s)*(VERSION|FIELDS)\s/.test(head)) return toCloudData(readPcd(bytes), 'PCD');
  if (isBinaryStl(bytes) || /^\s*solid\b[^]*\bfacet\b/.test(head)) return toCloudData(readStl(bytes), 'STL');
  if (isObj(head)) return toCloudData(readObj(bytes), 'OBJ');
  // eslint-disable-next-line no-control-regex
  if (/[\x00-\x08\x0e-\x19\x1c-\x1f]/.test(new TextDecoder('latin1').decode(bytes.subarray(0, 16_384))))
    throw new UnreadableCloud('the file is in no format that this page reads');
  if (kStrangers.test(head)) throw new UnreadableCloud('the file is in no format that this page reads');
  const {form, ...points} = readText(bytes, table);
  return {...toCloudData(points, 'text'), table: form};
}
