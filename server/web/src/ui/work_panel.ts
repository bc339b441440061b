// SPDX-License-Identifier: GPL-3.0-or-later
// How the present work goes, with its end in the user's hand; what went wrong stands over the picture.
import type {ApiError} from '../api/client';
import type {Session} from '../app/session';
import type {State, Work} from '../app/state';
import {errorWords} from '../words/error_words';
import {t} from '../words/words';
import {whenChanged} from './changed';
import {fill, h, must} from './dom';

function phaseList({phases = []}: Work): HTMLElement|null {
  if (phases.length < 2) return null;
  return h('p', {class: 'hint phases'}, ...phases.slice(0, -1).map((phase) => h('span', {}, `${phase} ✓`)));
}

function workCard(session: Session, work: Work): HTMLElement {
  const title = t.work[work.what];
  const known = work.fraction !== undefined;
  const bar = h('progress', {max: 1, 'aria-label': title, ...(known ? {value: work.fraction} : {})});
  const percent = known ? `${Math.round(100 * (work.fraction ?? 0))} %` : '';
  const cancel =
      h('button', {type: 'button', class: 'button small', id: 'cancel', onclick: () => void session.cancel()},
        t.work.cancel);
  return h(
      'div', {class: 'card work', 'data-what': work.what},
      h('div', {class: 'between'}, h('strong', {}, title), h('span', {class: 'number'}, percent)), bar, phaseList(work),
      h('div', {class: 'between'}, h('span', {class: 'hint'}, work.detail), cancel));
}

function errorCard(session: Session, error: ApiError): HTMLElement {
  const {title, detail, hint} = errorWords(error);
  const dismiss =
      h('button', {type: 'button', class: 'button small', onclick: () => session.change({error: undefined})},
        t.work.dismiss);
  const code = error.requestId ? `${error.code} · ${error.requestId}` : error.code;
  return h(
      'div', {class: 'card error', role: 'alert', 'data-code': error.code}, h('strong', {}, title), h('p', {}, detail),
      hint && h('p', {class: 'hint'}, hint),
      h('div', {class: 'between'}, h('span', {class: 'hint'}, `${t.errors.code} `, h('code', {}, code)), dismiss));
}

/** Errors lie over the picture, where everybody looks; on a telephone they are brought into view. */
export function mountErrors(host: HTMLElement, session: Session): void {
  session.onChange(whenChanged(({error}) => [error], ({error}) => {
    fill(host, error && errorCard(session, error));
    if (error && host.getBoundingClientRect().bottom < 0) host.scrollIntoView({block: 'center'});
  }));
}

export function mountWorkPanel(host: HTMLElement, session: Session): void {
  const status = must<HTMLElement>('#status');
  let said = '';
  const update = (state: State): void => {
    const {work, notice} = state;
    // The button keeps the focus while the numbers beside it change; when it goes, the one that begins has it.
    const focused = document.activeElement?.id === 'cancel';
    fill(host, work && workCard(session, work), !work && notice !== '' && h('p', {class: 'note'}, notice));
    if (focused) (document.getElementById('cancel') ?? document.getElementById('run'))?.focus({preventScroll: true});
    const now = work ? `${t.work[work.what]}${work.what === 'run' ? `: ${work.phases?.at(-1) ?? ''}` : ''}` : notice;
    if (now !== said) status.textContent = said = now;
  };
  session.onChange((state, what) => {
    if (what !== 'view') update(state);
  });
  update(session.state);
}
