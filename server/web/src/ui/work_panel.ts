// SPDX-License-Identifier: GPL-3.0-or-later
// How the present work goes, with its end in the user's hand; and what went wrong.
import type {ApiError} from '../api/client';
import type {Session} from '../app/session';
import type {State, Work} from '../app/state';
import {fill, h, must} from './dom';

const titles: Record<Work['what'], string> = {
  upload: 'Uploading the cloud',
  submit: 'Queueing the job',
  queue: 'Waiting in the queue',
  run: 'Reconstructing',
  load: 'Loading the mesh',
};

function phaseList({phases = []}: Work): HTMLElement|null {
  if (phases.length < 2) return null;
  return h('p', {class: 'hint phases'}, ...phases.slice(0, -1).map((phase) => h('span', {}, `${phase} ✓`)));
}

function workCard(session: Session, work: Work): HTMLElement {
  const known = work.fraction !== undefined;
  const bar = h('progress', {max: 1, 'aria-label': titles[work.what], ...(known ? {value: work.fraction} : {})});
  const percent = known ? `${Math.round(100 * (work.fraction ?? 0))} %` : '';
  return h(
      'div', {class: 'card work', 'data-what': work.what},
      h('div', {class: 'between'}, h('strong', {}, titles[work.what]), h('span', {class: 'number'}, percent)), bar,
      phaseList(work),
      h('div', {class: 'between'}, h('span', {class: 'hint'}, work.detail),
        h('button', {type: 'button', class: 'button small', id: 'cancel', onclick: () => void session.cancel()},
          'Cancel')));
}

function errorCard(session: Session, error: ApiError): HTMLElement {
  return h(
      'div', {class: 'card error', role: 'alert', 'data-code': error.code}, h('strong', {}, error.title),
      h('p', {}, error.detail), error.hint && h('p', {class: 'hint'}, error.hint),
      h('div', {class: 'between'}, h('code', {}, error.requestId ? `${error.code} · ${error.requestId}` : error.code),
        h('button', {type: 'button', class: 'button small', onclick: () => session.change({error: undefined})},
          'Dismiss')));
}

export function mountWorkPanel(host: HTMLElement, session: Session): void {
  const status = must<HTMLElement>('#status');
  let said = '';
  const update = (state: State): void => {
    const {work, error, notice} = state;
    // The button keeps the focus while the numbers beside it change.
    const focused = document.activeElement?.id === 'cancel';
    fill(
        host, work && workCard(session, work), error && errorCard(session, error),
        !work && notice !== '' && h('p', {class: 'note'}, notice));
    if (focused) document.getElementById('cancel')?.focus();
    const now = work ? `${titles[work.what]}${work.what === 'run' ? `: ${work.detail}` : ''}` : notice;
    if (now !== said) status.textContent = said = now;
  };
  session.onChange((state, what) => {
    if (what !== 'view') update(state);
  });
  update(session.state);
}
