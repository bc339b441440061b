// SPDX-License-Identifier: GPL-3.0-or-later
// Edges by how many triangles they have. Each comes as two vertices.
import type {MeshData} from './mesh_data';

export interface Edges {
  all: Uint32Array;
  /** One triangle. */
  boundary: Uint32Array;
  /** More than two. */
  nonManifold: Uint32Array;
}

export function edgesOf({positions, index}: MeshData): Edges {
  const vertices = positions.length / 3;
  // Below 2^53: a mesh of 94 million vertices would be the first that does not fit.
  const keys = new Float64Array(index.length);
  for (let t = 0; t < index.length; t += 3) {
    for (let k = 0; k < 3; k += 1) {
      const [u, v] = [index[t + k], index[t + ((k + 1) % 3)]];
      keys[t + k] = Math.min(u, v) * vertices + Math.max(u, v);
    }
  }
  keys.sort();
  const all = new Uint32Array(2 * keys.length);
  const boundary: number[] = [];
  const nonManifold: number[] = [];
  let count = 0;
  for (let at = 0; at < keys.length;) {
    let next = at + 1;
    while (next < keys.length && keys[next] === keys[at]) next += 1;
    const u = Math.floor(keys[at] / vertices);
    const v = keys[at] - u * vertices;
    all[2 * count] = u;
    all[2 * count + 1] = v;
    count += 1;
    if (next - at === 1) boundary.push(u, v);
    if (next - at > 2) nonManifold.push(u, v);
    at = next;
  }
  return {
    all: all.slice(0, 2 * count),
    boundary: Uint32Array.from(boundary),
    nonManifold: Uint32Array.from(nonManifold)
  };
}
