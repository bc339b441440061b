// SPDX-License-Identifier: GPL-3.0-or-later
// Points that become a surface: a knot that turns, drawn by the page itself, on a canvas without WebGL.

const kAround = 72;
const kAcross = 10;
const kTube = 0.42;
const kTilt = 0.5;
/** Seconds a turn. */
const kTurn = 24;

type Vector = [number, number, number];

const cross =
    (a: Vector, b: Vector): Vector => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (v: Vector): Vector => v.map((x) => x / Math.hypot(...v)) as Vector;

function centre(t: number): Vector {
  return [Math.sin(t) + 2 * Math.sin(2 * t), Math.cos(t) - 2 * Math.cos(2 * t), -Math.sin(3 * t)];
}

/** Rows of points around the knot. */
function knotPoints(): Vector[] {
  return Array.from({length: kAround * kAcross}, (_, i) => {
    const [t, s] = [(2 * Math.PI * Math.floor(i / kAcross)) / kAround, (2 * Math.PI * (i % kAcross)) / kAcross];
    const [c, next] = [centre(t), centre(t + 1e-3)];
    const along = unit([next[0] - c[0], next[1] - c[1], next[2] - c[2]]);
    const side = unit(cross(along, [0, 0, 1]));
    const up = cross(side, along);
    return c.map((x, k) => x + kTube * (Math.cos(s) * side[k] + Math.sin(s) * up[k])) as Vector;
  });
}

interface Quad {
  corners: number[];
  depth: number;
  light: number;
  /** Where along the knot, 0 to 1. */
  along: number;
}

function quadsOf(points: Vector[]): Quad[] {
  const quads: Quad[] = [];
  for (let i = 0; i < kAround; i += 1) {
    for (let j = 0; j < kAcross; j += 1) {
      const at = (row: number, column: number) => (row % kAround) * kAcross + (column % kAcross);
      const corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
      const [a, b, , d] = corners.map((corner) => points[corner]);
      const edge = (from: Vector, to: Vector): Vector => [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
      const normal = unit(cross(edge(a, b), edge(a, d)));
      const depth = corners.reduce((sum, corner) => sum + points[corner][2], 0);
      quads.push(
          {corners, depth, light: Math.abs(normal[0] * -0.3 + normal[1] * -0.5 + normal[2] * 0.8), along: i / kAround});
    }
  }
  return quads.sort((a, b) => a.depth - b.depth);
}

function turned([x, y, z]: Vector, angle: number): Vector {
  const [u, w] = [x * Math.cos(angle) + z * Math.sin(angle), -x * Math.sin(angle) + z * Math.cos(angle)];
  return [u, y * Math.cos(kTilt) - w * Math.sin(kTilt), y * Math.sin(kTilt) + w * Math.cos(kTilt)];
}

/** Where the surface gives way to points, a quarter of the knot each. */
const surfaceAt = (along: number): number => Math.min(1, Math.max(0, 4 * (Math.abs(along - 0.5) - 0.12)));

function draw(canvas: HTMLCanvasElement, knot: Vector[], angle: number): void {
  const context = canvas.getContext('2d');
  if (!context) return;
  const style = getComputedStyle(canvas);
  const {width, height} = canvas;
  const scale = Math.min(width / 8, height / 7.2);
  const points = knot.map((point) => turned(point, angle));
  const place = ([x, y]: Vector): [number, number] => [width / 2 + scale * x, height / 2 - scale * y];
  context.clearRect(0, 0, width, height);
  for (const {corners, light, along} of quadsOf(points)) {
    const share = surfaceAt(along);
    context.beginPath();
    corners.forEach(
        (corner, k) => (k === 0 ? context.moveTo(...place(points[corner])) : context.lineTo(...place(points[corner]))));
    context.closePath();
    context.globalAlpha = share;
    context.fillStyle = `hsl(174 55% ${Math.round(22 + 42 * light)}%)`;
    context.fill();
    context.globalAlpha = 1;
    context.fillStyle = style.color;
    if (share < 1) context.fillRect(...place(points[corners[0]]), 2, 2);
  }
}

/** Turns it for as long as it is on the page, unless movement is not wanted. */
export function drawKnot(canvas: HTMLCanvasElement): void {
  const knot = knotPoints();
  const still = matchMedia('(prefers-reduced-motion: reduce)').matches;
  let shown = false;
  const next = (now: number): void => {
    if (shown && !canvas.isConnected) return;
    shown = canvas.isConnected;
    draw(canvas, knot, (2 * Math.PI * now) / (1000 * kTurn));
    if (!still || !shown) setTimeout(() => requestAnimationFrame(next), 80);
  };
  requestAnimationFrame(next);
}
