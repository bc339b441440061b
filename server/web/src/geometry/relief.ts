// SPDX-License-Identifier: GPL-3.0-or-later
// Tells terrain and the like: flat, and over each place of the ground one height.
import {boxOf, sizesOf} from './box';

/** So much lower than wide, either way. */
const kFlat = 0.5;
/** Points in a cell of the ground, about. */
const kInCell = 6;
/** So small a part of the whole height the heights within a cell differ by, in most cells. */
const kWithin = 0.3;
/** So many points tell enough. */
const kEnough = 60_000;

export function isHeightField(positions: Float32Array): boolean {
  const points = positions.length / 3;
  const box = boxOf(positions);
  const {low} = box;
  const [width, depth, height] = sizesOf(box);
  if (points < 100 || !(height > 0) || height > kFlat * Math.min(width, depth)) return false;
  const step = Math.ceil(points / kEnough);
  const cell = Math.sqrt((width * depth * kInCell * step) / points);
  const columns = Math.floor(width / cell) + 1;
  const cells = new Map < number, {
    low: number;
    high: number;
    points: number
  }
  > ();
  for (let i = 0; i < points; i += step) {
    const [x, y, z] = positions.subarray(3 * i, 3 * i + 3);
    const key = Math.floor((y - low[1]) / cell) * columns + Math.floor((x - low[0]) / cell);
    const found = cells.get(key);
    if (!found) {
      cells.set(key, {low: z, high: z, points: 1});
      continue;
    }
    found.low = Math.min(found.low, z);
    found.high = Math.max(found.high, z);
    found.points += 1;
  }
  const full = [...cells.values()].filter((each) => each.points >= kInCell / 2);
  const flat = full.filter((each) => each.high - each.low <= kWithin * height);
  return flat.length >= 0.8 * full.length && full.length > 0;
}
