// SPDX-License-Identifier: GPL-3.0-or-later
// Points of a file, told by its content as the server does. What cannot be read here is for the server to judge.
import { toCloudData, UnreadableCloud, type CloudData } from './cloud_data';
import { decodeDraco } from './draco';
import { openGlb, openGltf, readScenePoints } from './gltf';
import { readLas } from './las';
import { readPcd } from './pcd';
import { readPly } from './ply';
import { isBinaryStl, readStl } from './stl';
import { isObj, readObj, readText } from './text';

export async function readCloud(bytes: Uint8Array): Promise<CloudData> {
  const head = new TextDecoder('latin1').decode(bytes.subarray(0, 4096));
  if (head.startsWith('ply')) return toCloudData(readPly(bytes), 'PLY');
  if (head.startsWith('DRACO')) return toCloudData((await decodeDraco(bytes)).positions, 'Draco');
  if (head.startsWith('LASF')) return toCloudData(readLas(bytes), 'LAS');
  if (head.startsWith('glTF')) {
    const { json, buffer } = openGlb(bytes);
    return toCloudData(await readScenePoints(json, buffer), 'GLB');
  }
  if (/^\s*\{/.test(head)) {
    const { json, buffer } = openGltf(bytes);
    return toCloudData(await readScenePoints(json, buffer), 'glTF');
  }
  if (/^(#[^\n]*\n|\s)*(VERSION|FIELDS)\s/.test(head)) return toCloudData(readPcd(bytes), 'PCD');
  if (isBinaryStl(bytes) || /^\s*solid\b[^]*\bfacet\b/.test(head)) return toCloudData(readStl(bytes), 'STL');
  if (isObj(head)) return toCloudData(readObj(bytes), 'OBJ');
  // eslint-disable-next-line no-control-regex
  if (/[\x00-\x08\x0e-\x1f]/.test(head)) throw new UnreadableCloud('the file is in no format that this page reads');
  return toCloudData(readText(bytes), 'text');
}
