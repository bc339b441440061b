// SPDX-License-Identifier: GPL-3.0-or-later
// What lies over the canvas: the invitation, the names of the panes, the scale of the colours.
import type {Session} from '../app/session';
import type {State} from '../app/state';
import {legendOf, type ScaleLegend} from '../app/contents';
import {gradient} from '../view/colormap';
import {count, real} from '../words/numbers';
import {t} from '../words/words';
import {whenChanged} from './changed';
import {fileButton, kFormats} from './cloud_panel';
import {fill, h} from './dom';
import {drawKnot} from './knot';

function samplesOf(session: Session, state: State): HTMLElement {
  return h(
      'ul', {class: 'row centred tries'},
      ...state.samples.map(
          (sample) =>
              h('li', {},
                h('button', {
                  type: 'button',
                  class: 'button',
                  'data-sample': sample.name,
                  onclick: () => void session.chooseSample(sample)
                },
                  t.invitation.try(sample.title)),
                h('p', {class: 'hint'}, t.invitation.samples[sample.name] ?? sample.description))));
}

function invitation(session: Session, state: State): HTMLElement {
  const picture = h('canvas', {class: 'knot', 'aria-hidden': 'true', width: 520, height: 240});
  drawKnot(picture);
  return h(
      'div', {class: 'invitation'}, picture, h('p', {class: 'big'}, t.invitation.title),
      h('p', {}, t.invitation.layman), h('div', {class: 'row centred'}, fileButton(session, t.cloud.choose, 'primary')),
      h('p', {class: 'hint'}, kFormats), samplesOf(session, state), h('p', {class: 'hint'}, t.invitation.local));
}

function legend({title, lower, upper, scale}: ScaleLegend): HTMLElement {
  const bar = h('span', {class: 'gradient'});
  bar.style.background = gradient(scale);
  return h(
      'div', {class: 'legend'}, h('span', {}, title),
      h('div', {class: 'scale number'}, h('span', {}, real(lower)), bar, h('span', {}, real(upper))));
}

function paneName(state: State, side: 0|1): HTMLElement|null {
  const result = state.results[side];
  if (!result || !state.results[1]) return null;
  const title = state.methods.find((method) => method.id === result.job.method)?.title ?? result.job.method;
  return h(
      'div', {class: side === 0 ? 'pane-name' : 'pane-name second'},
      `${title} · ${count(result.report.mesh.triangles)}`);
}

/** Without WebGL the results stand beside an empty picture, which says why. */
function blindness({blind, error}: State): HTMLElement|undefined {
  if (!blind || error) return undefined;
  return h('div', {class: 'blind'}, h('strong', {}, t.errors.noWebgl), h('p', {class: 'hint'}, t.errors.noWebglHint));
}

export function mountOverlay(host: HTMLElement, session: Session): void {
  const show = (state: State): void => {
    const begun = state.cloud !== undefined || state.results[0] !== undefined;
    // Who has chosen a sample goes on with the button that reconstructs it.
    const leaves = begun && host.contains(document.activeElement);
    const scale = legendOf(state);
    fill(
        host, !begun && invitation(session, state), begun && blindness(state), paneName(state, 0), paneName(state, 1),
        scale && legend(scale), state.results[1] && h('div', {class: 'divider'}));
    if (leaves) document.getElementById('run')?.focus({preventScroll: true});
  };
  const update = whenChanged(
      ({cloud, results, samples, methods, colour, difference, up, blind, error}) =>
          [cloud, cloud?.data, samples, methods, colour, difference, up, blind, blind && error,
           ...results.flatMap((result) => [result, result?.distances])],
      show);
  session.onChange(update);
  update(session.state);
}
