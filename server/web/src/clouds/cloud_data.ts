// SPDX-License-Identifier: GPL-3.0-or-later
import type {TableForm} from './table';

/** Points as the viewer draws them. */
export interface CloudData {
  /** xyz of each point, less the origin. */
  positions: Float32Array;
  /** What was taken from every coordinate, so that float32 is enough for the rest. */
  origin: [number, number, number];
  /** In the order of the words the server uses: PLY, Draco, LAS, ... */
  format: string;
  /** Points of the file that have no measurement and are not among the positions. */
  missing: number;
  /** How a text was taken. */
  table?: TableForm;
}

export class UnreadableCloud extends Error {}

/** Points that have no measurement are left out, as the server does. */
function measured<T extends Float64Array|Float32Array>(xyz: T): T {
  if (xyz.every((value) => Number.isFinite(value))) return xyz;
  return xyz.filter((_, i) => [0, 1, 2].every((axis) => Number.isFinite(xyz[i - (i % 3) + axis]))) as T;
}

/** Coordinates that float32 does not hold exactly are taken from the middle of their box. */
export function toCloudData(given: Float64Array|Float32Array, format: string): CloudData {
  const xyz = measured(given);
  const missing = (given.length - xyz.length) / 3;
  if (xyz.length === 0) throw new UnreadableCloud('the file holds no points');
  if (xyz instanceof Float32Array || xyz.every((value) => Math.fround(value) === value)) {
    return {positions: xyz instanceof Float32Array ? xyz : Float32Array.from(xyz), origin: [0, 0, 0], format, missing};
  }
  const origin = originOf(xyz);
  const positions = new Float32Array(xyz.length);
  for (let i = 0; i < xyz.length; i += 1) positions[i] = xyz[i] - origin[i % 3];
  return {positions, origin, format, missing};
}

function originOf(xyz: Float64Array): [number, number, number] {
  const middle = (axis: number): number => {
    let low = Infinity;
    let high = -Infinity;
    for (let i = axis; i < xyz.length; i += 3) {
      low = Math.min(low, xyz[i]);
      high = Math.max(high, xyz[i]);
    }
    return Math.fround((low + high) / 2);
  };
  return [middle(0), middle(1), middle(2)];
}
