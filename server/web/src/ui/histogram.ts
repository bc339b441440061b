// SPDX-License-Identifier: GPL-3.0-or-later
// A distribution as bars; of two results as bars and a line. The bounds of the papers are drawn in.
import type {Distribution} from '../api/types';
import {real} from '../words/numbers';
import {t} from '../words/words';
import {h, svg} from './dom';

export interface Bound {
  value: number;
  name: string;
}

const kWidth = 300;
const kHeight = 84;
/** Names of bounds that are nearer to each other, in percent of the width, stand in two rows. */
const kApart = 26;

/** Shares of the whole, so that meshes of different sizes compare. */
export function shares(counts: number[]): number[] {
  const total = counts.reduce((sum, each) => sum + each, 0) || 1;
  return counts.map((each) => each / total);
}

/** The name of each bound below its line. */
function boundNames(bounds: Bound[], place: (value: number) => number): HTMLElement|undefined {
  if (bounds.length === 0) return undefined;
  let before = -Infinity;
  let row = 0;
  const names = [...bounds].sort((a, b) => a.value - b.value).map(({value, name}) => {
    const at = place(value);
    row = at - before < kApart ? row + 1 : 0;
    before = at;
    const span = h('span', {class: 'bound-name'}, `${name} ${real(value)}`);
    span.style.left = `${at.toFixed(2)}%`;
    span.style.top = `${1.2 * row}em`;
    // At the edges of the picture it begins or ends at its line.
    span.style.transform = `translateX(${at < 15 ? 0 : at > 85 ? -100 : -50}%)`;
    return {span, row};
  });
  const rows = h('div', {class: 'bounds number'}, ...names.map(({span}) => span));
  rows.style.height = `${1.2 * (1 + Math.max(...names.map((each) => each.row)))}em`;
  return rows;
}

export function histogram(
    title: string, meaning: string, first: Distribution, second: Distribution|undefined, bounds: Bound[]): HTMLElement {
  const {lower, upper, counts} = first.histogram;
  const [mine, other] = [shares(counts), second ? shares(second.histogram.counts) : []];
  const top = Math.max(...mine, ...other, 1e-9);
  const x = (value: number) => (kWidth * (value - lower)) / (upper - lower);
  const y = (share: number) => kHeight - (kHeight - 4) * (share / top);
  const width = kWidth / counts.length;
  const bars = mine.map(
      (share, i) => svg(
          'rect', {x: i * width + 0.75, y: y(share), width: width - 1.5, height: kHeight - y(share), class: 'bar'}));
  const steps = other.map((share, i) => `${i * width},${y(share)} ${(i + 1) * width},${y(share)}`).join(' ');
  const points = `0,${kHeight} ${steps} ${kWidth},${kHeight}`;
  const line = other.length > 0 ? [svg('polyline', {points, class: 'other'})] : [];
  const marks = bounds.map(({value}) => svg('line', {x1: x(value), x2: x(value), y1: 0, y2: kHeight, class: 'bound'}));
  const words = t.result.histogram(title, real(first.min), real(first.max), real(first.p50), real(first.p05));
  const picture =
      svg('svg', {viewBox: `0 0 ${kWidth} ${kHeight}`, role: 'img', 'aria-label': words, preserveAspectRatio: 'none'},
          ...bars, ...line, ...marks);
  const numbers =
      t.result.numbers(real(first.min), real(first.p05), real(first.p50), real(first.mean), real(first.p95));
  return h(
      'figure', {class: 'histogram'},
      h('figcaption', {}, h('strong', {}, title), h('span', {class: 'hint'}, ` ${meaning}`)), picture,
      boundNames(bounds, (value) => (100 * x(value)) / kWidth),
      h('div', {class: 'axis number'}, h('span', {}, real(lower)), h('span', {}, real(upper))),
      h('p', {class: 'number five'}, numbers));
}
