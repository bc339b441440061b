// SPDX-License-Identifier: GPL-3.0-or-later
// A box that points are kept in, a plane that cuts the picture.
import {cropCloud} from '../app/cropping';
import type {Session} from '../app/session';
import type {State} from '../app/state';
import {countInside, type Box} from '../geometry/box';
import type {Stage} from '../view/stage';
import {count} from '../words/numbers';
import {t} from '../words/words';
import {h} from './dom';

const kAxes = ['x', 'y', 'z'] as const;

export function cropControls(session: Session, box: Box, changed: (crop: Box) => void): HTMLElement {
  const crop: Box = {low: [...box.low], high: [...box.high]};
  const positions = session.state.cloud?.data?.positions ?? new Float32Array();
  const tally = h('p', {class: 'number'});
  const tell = (): void => {
    tally.textContent = t.tools.kept(count(countInside(positions, crop)), count(positions.length / 3));
    changed(crop);
  };
  const slider = (axis: 0|1|2, side: 'low'|'high') => {
    const [from, to] = [box.low[axis], box.high[axis]];
    const input = h('input', {
      type: 'range',
      min: 0,
      max: 1000,
      value: side === 'low' ? '0' : '1000',
      id: `crop-${kAxes[axis]}-${side}`,
      'aria-label': (side === 'low' ? t.tools.low : t.tools.high)(kAxes[axis])
    });
    input.addEventListener('input', () => {
      crop[side][axis] = from + (Number(input.value) / 1000) * (to - from);
      tell();
    });
    return input;
  };
  const rows = ([0, 1, 2] as const)
                   .map(
                       (axis) =>
                           h('div', {class: 'pair'}, h('span', {class: 'label'}, kAxes[axis]), slider(axis, 'low'),
                             slider(axis, 'high')));
  const apply =
      h('button',
        {type: 'button', class: 'button primary small', id: 'crop-apply', onclick: () => void cropCloud(session, crop)},
        t.tools.apply);
  tell();
  return h('div', {class: 'crop'}, h('p', {class: 'hint'}, t.tools.cropHint), ...rows, tally, apply);
}

export function clipControls(session: Session, stage: Stage): HTMLElement {
  const {clip} = session.state;
  const names = (['none', ...kAxes] as const)
                    .map(
                        (name) =>
                            h('option', {value: name, selected: name === clip.axis},
                              name === 'none' ? t.view.notCut : t.view.cut(name)));
  const axis = h('select', {'aria-label': t.view.clip, id: 'clip'}, ...names);
  const slider = h('input', {
    type: 'range',
    min: 0,
    max: 1,
    step: 0.002,
    value: String(clip.place),
    'aria-label': t.view.place,
    id: 'clip-place'
  });
  const flip =
      h('button', {type: 'button', class: 'toggle', title: t.view.otherSide}, '⇄',
        h('span', {class: 'visually-hidden'}, t.view.otherSide));
  const set = (part: Partial<State['clip']>): void => {
    const rebuilt = (part.axis ?? clip.axis) !== clip.axis && (part.axis === 'none' || clip.axis === 'none');
    Object.assign(clip, part);
    slider.hidden = flip.hidden = clip.axis === 'none';
    if (rebuilt)
      session.change({}, 'view');
    else
      stage.setClip(clip);
  };
  slider.hidden = flip.hidden = clip.axis === 'none';
  axis.addEventListener('change', () => set({axis: axis.value as State['clip']['axis']}));
  slider.addEventListener('input', () => set({place: Number(slider.value)}));
  flip.addEventListener('click', () => set({flip: !clip.flip}));
  return h('span', {class: 'pair'}, axis, slider, flip);
}
