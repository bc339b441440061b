// SPDX-License-Identifier: GPL-3.0-or-later
/** Points as the viewer draws them. */
export interface CloudData {
  /** xyz of each point, less the origin. */
  positions: Float32Array;
  /** What was taken from every coordinate, so that float32 is enough for the rest. */
  origin: [number, number, number];
  /** In the order of the words the server uses: PLY, Draco, LAS, ... */
  format: string;
}

export class UnreadableCloud extends Error {}

/** Coordinates that float32 does not hold exactly are taken from the middle of their box. */
export function toCloudData(xyz: Float64Array | Float32Array, format: string): CloudData {
  if (xyz.length === 0) throw new UnreadableCloud('the file holds no points');
  const bad = xyz.findIndex((value) => !Number.isFinite(value));
  if (bad >= 0) throw new UnreadableCloud(`a coordinate of point ${Math.floor(bad / 3)} is not a finite number`);
  if (xyz instanceof Float32Array || xyz.every((value) => Math.fround(value) === value)) {
    return { positions: xyz instanceof Float32Array ? xyz : Float32Array.from(xyz), origin: [0, 0, 0], format };
  }
  const origin = originOf(xyz);
  const positions = new Float32Array(xyz.length);
  for (let i = 0; i < xyz.length; i += 1) positions[i] = xyz[i] - origin[i % 3];
  return { positions, origin, format };
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
