// SPDX-License-Identifier: GPL-3.0-or-later
// Shapes of triangles: the papers' l/R (shortest edge over circumradius, 0 to √3), r/L (inradius over longest edge, 0
// to √3/6) and the smallest angle in degrees. A triangle without area has 0 of each.
import type {MeshData} from './mesh_data';

export const kLargest = {
  lR: Math.sqrt(3),
  rL: Math.sqrt(3) / 6,
  angle: 60
};
export type Shape = keyof typeof kLargest;

export interface Shapes {
  lR: Float32Array;
  rL: Float32Array;
  angle: Float32Array;
}

/** From the squared lengths of the edges. */
export function shapeOf(aa: number, bb: number, cc: number): {lR: number; rL: number; angle: number} {
  const [a, b, c] = [Math.sqrt(aa), Math.sqrt(bb), Math.sqrt(cc)].sort((x, y) => x - y);
  // Kahan's order keeps the area of needles.
  const sixteen = (c + (b + a)) * (a - (c - b)) * (a + (c - b)) * (c + (b - a));
  if (!(sixteen > 0)) return {lR: 0, rL: 0, angle: 0};
  const area = Math.sqrt(sixteen) / 4;
  const circumradius = (a * b * c) / (4 * area);
  const inradius = (2 * area) / (a + b + c);
  const angle = (Math.atan2(4 * area, bb + aa + cc - 2 * a * a) * 180) / Math.PI;
  return {lR: a / circumradius, rL: inradius / c, angle};
}

export function shapesOf({positions: p, index}: MeshData): Shapes {
  const triangles = index.length / 3;
  const shapes:
      Shapes = {lR: new Float32Array(triangles), rL: new Float32Array(triangles), angle: new Float32Array(triangles)};
  const squared = (u: number, v: number): number => {
    const [x, y, z] = [p[3 * u] - p[3 * v], p[3 * u + 1] - p[3 * v + 1], p[3 * u + 2] - p[3 * v + 2]];
    return x * x + y * y + z * z;
  };
  for (let t = 0; t < triangles; t += 1) {
    const [u, v, w] = [index[3 * t], index[3 * t + 1], index[3 * t + 2]];
    const shape = shapeOf(squared(u, v), squared(v, w), squared(w, u));
    shapes.lR[t] = shape.lR;
    shapes.rL[t] = shape.rL;
    shapes.angle[t] = shape.angle;
  }
  return shapes;
}

/** The triangles with the least values, worst first. */
export function worstOf(values: Float32Array, most: number): number[] {
  const kept: number[] = [];
  for (let t = 0; t < values.length; t += 1) {
    if (kept.length === most && values[t] >= values[kept[most - 1]]) continue;
    let at = kept.length;
    while (at > 0 && values[kept[at - 1]] > values[t]) at -= 1;
    kept.splice(at, 0, t);
    if (kept.length > most) kept.pop();
  }
  return kept;
}
