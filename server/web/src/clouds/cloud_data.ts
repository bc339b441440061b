// SPDX-License-Identifier: GPL-3.0-or-later
import type {TableForm} from './table';

/** What a reader finds of each point. */
export interface Points {
  /** xyz of each. */
  xyz: Float32Array|Float64Array;
  /** Red, green, blue of each, in sRGB. */
  colours?: Uint8Array|undefined;
  normals?: boolean|undefined;
  intensity?: Float32Array|undefined;
  classes?: Uint8Array|undefined;
}

/** Points as the viewer draws them. */
export interface CloudData extends Omit<Points, 'xyz'> {
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

/** Bytes of colours out of channels of any range, which the largest tells: up to 1, up to 255, up to 65535. */
export function colourBytes(channels: ArrayLike<number>, integers: boolean): Uint8Array|undefined {
  let most = 0;
  for (let i = 0; i < channels.length; i += 1) {
    if (!(channels[i] >= 0)) return undefined;
    most = Math.max(most, channels[i]);
  }
  if (most === 0) return undefined;
  const scale = most <= 1 && !integers ? 255 : most <= 255 ? 1 : 1 / 257;
  return Uint8Array.from(channels, (value) => Math.round(value * scale));
}

/** Those of the rows, each so wide, that are kept. */
function keptRows<T extends Float32Array|Float64Array|Uint8Array>(values: T, width: number, keep: Uint8Array): T {
  return values.filter((_, i) => keep[Math.floor(i / width)] === 1) as T;
}

/** Points that have no measurement are left out, as the server does. */
function measured(points: Points): Points {
  const {xyz, colours, intensity, classes} = points;
  if (xyz.every((value) => Number.isFinite(value))) return points;
  const keep = new Uint8Array(xyz.length / 3).fill(1);
  xyz.forEach((value, i) => {
    if (!Number.isFinite(value)) keep[Math.floor(i / 3)] = 0;
  });
  return {
    ...points,
    xyz: keptRows(xyz, 3, keep),
    colours: colours && keptRows(colours, 3, keep),
    intensity: intensity && keptRows(intensity, 1, keep),
    classes: classes && keptRows(classes, 1, keep),
  };
}

/** Coordinates that float32 does not hold exactly are taken from the middle of their box. */
export function toCloudData(given: Points, format: string): CloudData {
  const {xyz, ...others} = measured(given);
  const missing = (given.xyz.length - xyz.length) / 3;
  if (xyz.length === 0) throw new UnreadableCloud('the file holds no points');
  if (xyz instanceof Float32Array || xyz.every((value) => Math.fround(value) === value)) {
    const positions = xyz instanceof Float32Array ? xyz : Float32Array.from(xyz);
    return {...others, positions, origin: [0, 0, 0], format, missing};
  }
  const origin = originOf(xyz);
  const positions = new Float32Array(xyz.length);
  for (let i = 0; i < xyz.length; i += 1) positions[i] = xyz[i] - origin[i % 3];
  return {...others, positions, origin, format, missing};
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
