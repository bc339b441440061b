// SPDX-License-Identifier: GPL-3.0-or-later
// The nearest of many points: a balanced k-d tree in one array, the middle of each part being its node.

export class NearestPoints {
  private readonly order: Uint32Array;

  constructor(private readonly points: Float32Array) {
    this.order = Uint32Array.from({length: points.length / 3}, (_, i) => i);
    this.arrange();
  }

  private arrange(): void {
    const open: [number, number, number][] = [[0, this.order.length, 0]];
    for (let part = open.pop(); part; part = open.pop()) {
      const [from, to, axis] = part;
      if (to - from < 2) continue;
      const middle = (from + to) >> 1;
      this.select(from, to - 1, middle, axis);
      const next = (axis + 1) % 3;
      open.push([from, middle, next], [middle + 1, to, next]);
    }
  }

  /** Hoare's selection: what is not greater before `at`, what is not less behind it. */
  private select(from: number, to: number, at: number, axis: number): void {
    const {order, points} = this;
    let low = from;
    let high = to;
    while (low < high) {
      const pivot = points[3 * order[(low + high) >> 1] + axis];
      let i = low;
      let j = high;
      while (i <= j) {
        while (points[3 * order[i] + axis] < pivot) i += 1;
        while (points[3 * order[j] + axis] > pivot) j -= 1;
        if (i > j) break;
        const swapped = order[i];
        order[i] = order[j];
        order[j] = swapped;
        i += 1;
        j -= 1;
      }
      if (at <= j)
        high = j;
      else if (at >= i)
        low = i;
      else
        return;
    }
  }

  /** Distance to the nearest; infinite without points. */
  distance(x: number, y: number, z: number): number {
    return Math.sqrt(this.search([x, y, z], 0, this.order.length, 0, Infinity));
  }

  private search(query: [number, number, number], from: number, to: number, axis: number, best: number): number {
    if (from >= to) return best;
    const middle = (from + to) >> 1;
    const at = 3 * this.order[middle];
    const p = this.points;
    const [dx, dy, dz] = [query[0] - p[at], query[1] - p[at + 1], query[2] - p[at + 2]];
    let least = Math.min(best, dx * dx + dy * dy + dz * dz);
    const across = query[axis] - p[at + axis];
    const next = (axis + 1) % 3;
    const near: [number, number] = across < 0 ? [from, middle] : [middle + 1, to];
    const far: [number, number] = across < 0 ? [middle + 1, to] : [from, middle];
    least = this.search(query, ...near, next, least);
    return across * across < least ? this.search(query, ...far, next, least) : least;
  }
}

/** Distance of each query point to the nearest of the others. */
export function distancesTo(
    target: NearestPoints, queries: Float32Array, shift: [number, number, number]): Float32Array {
  const distances = new Float32Array(queries.length / 3);
  for (let i = 0; i < distances.length; i += 1) {
    distances[i] =
        target.distance(queries[3 * i] + shift[0], queries[3 * i + 1] + shift[1], queries[3 * i + 2] + shift[2]);
  }
  return distances;
}

export function diagonalOf(positions: Float32Array): number {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; i += 1) {
    low[i % 3] = Math.min(low[i % 3], positions[i]);
    high[i % 3] = Math.max(high[i % 3], positions[i]);
  }
  return Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
}
