// SPDX-License-Identifier: GPL-3.0-or-later
// A distribution as bars; of two results as bars and a line. The bounds of the papers are drawn in.
import type {Distribution} from '../api/types';
import {real} from '../words/numbers';
import {h, svg} from './dom';

export interface Bound {
  value: number;
  name: string;
}

const kWidth = 300;
const kHeight = 84;

/** Shares of the whole, so that meshes of different sizes compare. */
export function shares(counts: number[]): number[] {
  const total = counts.reduce((sum, each) => sum + each, 0) || 1;
  return counts.map((each) => each / total);
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
  const line =
      other.length > 0 ? [svg('polyline', {points: `0,${kHeight} ${steps} ${kWidth},${kHeight}`, class: 'other'})] : [];
  const marks = bounds.map(({value}) => svg('line', {x1: x(value), x2: x(value), y1: 0, y2: kHeight, class: 'bound'}));
  const words = `${title}: from ${real(first.min)} to ${real(first.max)}, half above ${real(first.p50)}, 95 % above ${
      real(first.p05)}.`;
  const picture =
      svg('svg', {viewBox: `0 0 ${kWidth} ${kHeight}`, role: 'img', 'aria-label': words, preserveAspectRatio: 'none'},
          ...bars, ...line, ...marks);
  const legend = bounds.map(({value, name}) => h('span', {class: 'bound-name'}, `${name} ${real(value)}`));
  return h(
      'figure', {class: 'histogram'},
      h('figcaption', {}, h('strong', {}, title), h('span', {class: 'hint'}, ` ${meaning}`)), picture,
      h('div', {class: 'axis number'}, h('span', {}, real(lower)), ...legend, h('span', {}, real(upper))),
      h('p', {class: 'number five'},
        `min ${real(first.min)} · 5 % ${real(first.p05)} · median ${real(first.p50)} · mean ${
            real(first.mean)} · 95 % ${real(first.p95)}`));
}
