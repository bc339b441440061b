// SPDX-License-Identifier: GPL-3.0-or-later
// A coarse stand-in to draw while the camera moves: vertices of a cell of a grid become one, triangles that lose a
// corner go.
import {boxOf, sizesOf} from './box';
import type {MeshData} from './mesh_data';

const kEmpty = 0xffffffff;

function clustered(mesh: MeshData, cells: number): Uint32Array {
  const box = boxOf(mesh.positions);
  const {low} = box;
  const size = sizesOf(box);
  const cell = Math.max(...size) / cells || 1;
  const shape = size.map((length) => Math.floor(length / cell) + 1);
  const table = new Uint32Array(shape[0] * shape[1] * shape[2]).fill(kEmpty);
  const p = mesh.positions;
  const representative = new Uint32Array(p.length / 3);
  for (let v = 0; v < representative.length; v += 1) {
    const at = [0, 1, 2].map((axis) => Math.floor((p[3 * v + axis] - low[axis]) / cell));
    const key = (at[2] * shape[1] + at[1]) * shape[0] + at[0];
    if (table[key] === kEmpty) table[key] = v;
    representative[v] = table[key];
  }
  const kept = new Uint32Array(mesh.index.length);
  let count = 0;
  for (let t = 0; t < mesh.index.length; t += 3) {
    const [u, v, w] =
        [representative[mesh.index[t]], representative[mesh.index[t + 1]], representative[mesh.index[t + 2]]];
    if (u === v || v === w || w === u) continue;
    kept[count] = u;
    kept[count + 1] = v;
    kept[count + 2] = w;
    count += 3;
  }
  return kept.slice(0, count);
}

/** Triangles over the same vertices, at most about so many. */
export function simplified(mesh: MeshData, most: number): Uint32Array {
  // A surface fills about two triangles a cell it passes, and passes a few times cells² of them.
  for (let cells = Math.min(160, Math.ceil(Math.sqrt(most / 2)));; cells = Math.floor(0.8 * cells)) {
    const index = clustered(mesh, cells);
    if (index.length <= 3 * most || cells < 8) return index;
  }
}
