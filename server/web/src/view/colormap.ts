// SPDX-License-Identifier: GPL-3.0-or-later
// Colour scales. Those of quality and distance are monotone in lightness, so they survive print and colour blindness.
export type Rgb = [number, number, number];

/** Matplotlib's viridis, as polynomials by Matt Zucker (CC0). */
const viridis = [
  [0.2777273272234177, 0.005407344544966578, 0.3340998053353061],
  [0.1050930431085774, 1.404613529898575, 1.384590162594685],
  [-0.3308618287255563, 0.214847559468213, 0.09509516302823659],
  [-4.634230498983486, -5.799100973351585, -19.33244095627987],
  [6.228269936347081, 14.17993336680509, 56.69055260068105],
  [4.776384997670288, -13.74514537774601, -65.35303263337234],
  [-5.435455855934631, 4.645852612178535, 26.3124352495832],
];

function quality(t: number): Rgb {
  const value = (k: number) => viridis.reduceRight((sum, row) => sum * t + row[k], 0);
  return [value(0), value(1), value(2)].map((x) => Math.min(1, Math.max(0, x))) as Rgb;
}

const stops: Rgb[] = [
  [0.9, 0.92, 0.93],
  [0.95, 0.8, 0.5],
  [0.87, 0.48, 0.22],
  [0.65, 0.17, 0.16],
  [0.32, 0.05, 0.14],
];

/** Low ground green, then ochre, then light rock. */
const heights: Rgb[] = [
  [0.1, 0.35, 0.42],
  [0.28, 0.55, 0.35],
  [0.72, 0.7, 0.4],
  [0.8, 0.62, 0.45],
  [0.96, 0.94, 0.92],
];
const greys: Rgb[] = [
  [0.12, 0.12, 0.14],
  [0.95, 0.95, 0.92],
];

function between(list: Rgb[], t: number): Rgb {
  const place = Math.min(1, Math.max(0, t)) * (list.length - 1);
  const at = Math.min(list.length - 2, Math.floor(place));
  const mix = (k: number) => list[at][k] + (place - at) * (list[at + 1][k] - list[at][k]);
  return [mix(0), mix(1), mix(2)];
}

const distance = (t: number): Rgb => between(stops, t);
const height = (t: number): Rgb => between(heights, t);
const grey = (t: number): Rgb => between(greys, t);

export const scales = {
  quality,
  distance,
  height,
  grey
};
export type ScaleName = keyof typeof scales;

/**
 * Classes of points as ASPRS numbers them: 2 ground, 3 to 5 vegetation, 6 building, 9 water; the others stand apart.
 */
export const kClassColours: Rgb[] = [
  [150, 150, 150],
  [120, 120, 120],
  [160, 110, 60],
  [150, 200, 90],
  [90, 170, 60],
  [40, 120, 40],
  [200, 70, 60],
  [240, 60, 200],
  [250, 210, 80],
  [60, 130, 220],
  [130, 90, 180],
  [90, 90, 100],
  [230, 150, 40],
  [60, 190, 190],
  [250, 120, 120],
  [90, 60, 40],
  [180, 180, 230],
  [110, 140, 160],
];

/** Bytes of colours for the values, in sRGB; the scale goes from `lower` to `upper`. */
export function coloursOf(values: ArrayLike<number>, upper: number, scale: ScaleName, lower = 0): Uint8Array {
  const table = Array.from({length: 256}, (_, i) => scales[scale](i / 255).map((x) => Math.round(255 * x)));
  const colours = new Uint8Array(3 * values.length);
  for (let i = 0; i < values.length; i += 1) {
    const t = upper > lower ? Math.round((255 * (values[i] - lower)) / (upper - lower)) : 0;
    colours.set(table[Math.min(255, Math.max(0, t))], 3 * i);
  }
  return colours;
}

export function gradient(scale: ScaleName): string {
  const parts =
      Array.from({length: 9}, (_, i) => `rgb(${scales[scale](i / 8).map((x) => Math.round(255 * x)).join(' ')})`);
  return `linear-gradient(to right, ${parts.join(', ')})`;
}
