// SPDX-License-Identifier: GPL-3.0-or-later
// What lies over the canvas: the invitation, the names of the panes, the scale of the colours.
import type {Session} from '../app/session';
import type {State} from '../app/state';
import {gradient} from '../view/colormap';
import {colouringsOf, type ScaleLegend} from '../view/contents';
import {count, real} from '../words/numbers';
import {fileButton, kFormats} from './cloud_panel';
import {whenChanged} from './changed';
import {fill, h} from './dom';

function invitation(session: Session, state: State): HTMLElement {
  return h(
      'div', {class: 'invitation'}, h('p', {class: 'big'}, 'Drop a point cloud'), h('p', {class: 'hint'}, kFormats),
      h('div', {class: 'row centred'}, fileButton(session, 'Choose a file …', 'primary'),
        ...state.samples.map(
            (sample) =>
                h('button', {
                  type: 'button',
                  class: 'button',
                  'data-sample': sample.name,
                  onclick: () => void session.chooseSample(sample)
                },
                  `Try the ${sample.title.toLowerCase()}`))),
      h('p', {class: 'hint'}, 'Choose a method, reconstruct, and judge the mesh: nothing leaves this server.'));
}

function legendOf(legend: ScaleLegend): HTMLElement {
  const bar = h('span', {class: 'gradient'});
  bar.style.background = gradient(legend.scale);
  return h(
      'div', {class: 'legend'}, h('span', {}, legend.title),
      h('div', {class: 'scale number'}, h('span', {}, '0'), bar, h('span', {}, real(legend.upper))));
}

function paneName(state: State, side: 0|1): HTMLElement|null {
  const result = state.results[side];
  if (!result || !state.results[1]) return null;
  const title = state.methods.find((method) => method.id === result.job.method)?.title ?? result.job.method;
  return h(
      'div', {class: side === 0 ? 'pane-name' : 'pane-name second'},
      `${title} · ${count(result.report.mesh.triangles)}`);
}

export function mountOverlay(host: HTMLElement, session: Session): void {
  const update = whenChanged(
      ({cloud, results, samples, methods, colour, difference}) =>
          [cloud, samples, methods, colour, difference, ...results.flatMap((result) => [result, result?.distances])],
      (state) => {
        const {legend} = colouringsOf(state);
        fill(
            host, !state.cloud && !state.results[0] && invitation(session, state), paneName(state, 0),
            paneName(state, 1), legend && legendOf(legend), state.results[1] && h('div', {class: 'divider'}));
      });
  session.onChange(update);
  update(session.state);
}

/** What a screen reader says of the canvas. */
export function describeView(state: State): string {
  const [first, second] = state.results;
  if (!first)
    return state.cloud?.data ? `${count(state.cloud.data.positions.length / 3)} points of ${state.cloud.name}` :
                               'Nothing is shown yet';
  const of = (result: typeof first) =>
      `mesh of ${count(result.report.mesh.triangles)} triangles by ${result.job.method}`;
  return second ? `A ${of(first)}, and a ${of(second)} beside it, seen from the same side` :
                  `A ${of(first)}; arrow keys turn it, plus and minus zoom`;
}
