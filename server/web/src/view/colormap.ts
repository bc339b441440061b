// SPDX-License-Identifier: GPL-3.0-or-later
// Colour scales. Both are monotone in lightness, so they survive print and colour blindness.
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

function distance(t: number): Rgb {
  const place = Math.min(1, Math.max(0, t)) * (stops.length - 1);
  const at = Math.min(stops.length - 2, Math.floor(place));
  const mix = (k: number) => stops[at][k] + (place - at) * (stops[at + 1][k] - stops[at][k]);
  return [mix(0), mix(1), mix(2)];
}

export const scales = {
  quality,
  distance
};
export type ScaleName = keyof typeof scales;

/** Bytes of colours for the values, in sRGB; `upper` is the value of the scale's end. */
export function coloursOf(values: Float32Array, upper: number, scale: ScaleName): Uint8Array {
  const table = Array.from({length: 256}, (_, i) => scales[scale](i / 255).map((x) => Math.round(255 * x)));
  const colours = new Uint8Array(3 * values.length);
  for (let i = 0; i < values.length; i += 1) {
    const t = upper > 0 ? Math.round((255 * values[i]) / upper) : 0;
    colours.set(table[Math.min(255, Math.max(0, t))], 3 * i);
  }
  return colours;
}

export function gradient(scale: ScaleName): string {
  const parts =
      Array.from({length: 9}, (_, i) => `rgb(${scales[scale](i / 8).map((x) => Math.round(255 * x)).join(' ')})`);
  return `linear-gradient(to right, ${parts.join(', ')})`;
}
