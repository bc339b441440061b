// SPDX-License-Identifier: GPL-3.0-or-later
// Boxes along the axes.
export interface Box {
  low: [number, number, number];
  high: [number, number, number];
}

export function boxOf(positions: Float32Array): Box {
  const box: Box = {low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity]};
  for (let i = 0; i < positions.length; i += 1) {
    box.low[i % 3] = Math.min(box.low[i % 3], positions[i]);
    box.high[i % 3] = Math.max(box.high[i % 3], positions[i]);
  }
  return box;
}

export const sizesOf =
    ({low, high}: Box): [number, number, number] => [high[0] - low[0], high[1] - low[1], high[2] - low[2]];

export function isInside(positions: Float32Array, point: number, {low, high}: Box): boolean {
  for (let k = 0; k < 3; k += 1) {
    const value = positions[3 * point + k];
    if (value < low[k] || value > high[k]) return false;
  }
  return true;
}

export function countInside(positions: Float32Array, box: Box): number {
  let inside = 0;
  for (let i = 0; i < positions.length / 3; i += 1) inside += isInside(positions, i, box) ? 1 : 0;
  return inside;
}

/** Both ends of each of the twelve edges. */
export function boxEdges({low, high}: Box): number[] {
  const corner = (bits: number): number[] => [0, 1, 2].map((k) => ((bits >> k) & 1 ? high[k] : low[k]));
  const edges: number[] = [];
  for (let bits = 0; bits < 8; bits += 1) {
    for (let k = 0; k < 3; k += 1) {
      if (!((bits >> k) & 1)) edges.push(...corner(bits), ...corner(bits | (1 << k)));
    }
  }
  return edges;
}
