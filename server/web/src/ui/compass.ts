// SPDX-License-Identifier: GPL-3.0-or-later
// Where the axes point, how long things are, and views along an axis, in a corner of the picture.
import type {Session} from '../app/session';
import type {Stage} from '../view/stage';
import {real} from '../words/numbers';
import {t} from '../words/words';
import {fill, h} from './dom';

type Axis = 'x'|'y'|'z';
const kAxes: Axis[] = ['x', 'y', 'z'];
/** Pixels from the middle of the compass to an end of an axis. */
const kReach = 28;
/** Pixels of the bar of the scale, at most. */
const kBar = 110;

/** 1, 2 or 5 times a power of ten, as long as the bar may be. */
export function roundLength(most: number): number {
  const power = 10 ** Math.floor(Math.log10(most));
  return [5, 2, 1].map((factor) => factor * power).find((length) => length <= most) ?? power;
}

export function mountCompass(host: HTMLElement, session: Session, stage: Stage): void {
  const lines = new Map(kAxes.map((axis) => [axis, h('span', {class: `axis-line ${axis}`})]));
  const ends = kAxes.flatMap((axis) => [true, false].map((positive) => {
    const name = `${positive ? '' : '−'}${axis}`;
    const end =
        h('button', {
          type: 'button',
          class: `axis-end ${axis}${positive ? '' : ' negative'}`,
          'aria-label': t.view.from(name),
          title: t.view.from(name),
          onclick: () => stage.lookAlong(axis, positive)
        },
          positive ? axis : '');
    return {axis, positive, end};
  }));
  const rose =
      h('div', {class: 'rose', role: 'group', 'aria-label': t.view.gizmo}, ...lines.values(),
        ...ends.map(({end}) => end));
  const length = h('span', {class: 'number'});
  const line = h('span', {class: 'bar-line'});
  const bar = h('div', {class: 'bar-scale'}, length, line);
  const up = h('button', {type: 'button', class: 'toggle', id: 'up', title: t.view.upTitle});
  up.addEventListener('click', () => turnUp(session));
  const fit =
      h('button', {type: 'button', class: 'toggle', title: t.view.fitTitle, onclick: () => stage.fit(session.state.up)},
        t.view.fit);
  fill(host, rose, h('div', {class: 'pair'}, up, fit), bar);
  stage.onView = () => {
    const axes = stage.axesOnScreen();
    for (const {axis, positive, end} of ends) {
      const {x, y, z} = axes[axis].clone().multiplyScalar(positive ? kReach : -kReach);
      end.style.transform = `translate(${x.toFixed(1)}px, ${(-y).toFixed(1)}px)`;
      end.style.zIndex = String(Math.round(z) + kReach);
    }
    for (const [axis, line] of lines) {
      const {x, y} = axes[axis];
      line.style.width = `${(kReach * Math.hypot(x, y)).toFixed(1)}px`;
      line.style.transform = `rotate(${Math.atan2(-y, x).toFixed(3)}rad)`;
    }
    const unit = stage.unitsOfPixel();
    bar.hidden = unit === 0;
    if (unit === 0) return;
    const round = roundLength(unit * kBar);
    line.style.width = `${(round / unit).toFixed(1)}px`;
    length.textContent = t.view.scale(round, real(round));
  };
  session.onChange((state) => {
    host.hidden = !state.cloud?.data && !state.results[0];
    up.textContent = t.view.up(state.up);
  });
}

/** The files of a result keep the axis that they were written with. */
export function turnUp(session: Session): void {
  const next = session.state.up === 'y' ? 'z' : 'y';
  session.setUp(next);
  if (session.state.results[0]) session.change({notice: t.view.upNotice(next)});
}
