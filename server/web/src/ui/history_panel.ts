// SPDX-License-Identifier: GPL-3.0-or-later
// The jobs that the server knows, newest first: open one, put one beside, try a failed one again.
import {isEnded, type Job} from '../api/types';
import type {Session} from '../app/session';
import type {State} from '../app/state';
import {whenChanged} from './changed';
import {fill, h} from './dom';

const words: Record<Job['status'], string> = {
  accepted: 'waits',
  running: 'runs',
  successful: 'done',
  failed: 'failed',
  dismissed: 'cancelled'
};

const time =
    new Intl.DateTimeFormat('en', {day: 'numeric', month: 'short', hour: '2-digit', minute: '2-digit', hour12: false});

function row(session: Session, state: State, job: Job): HTMLElement {
  const title = state.methods.find((method) => method.id === job.method)?.title ?? job.method;
  const sameCloud = state.results[0] && job.cloud_id !== null && job.cloud_id === state.results[0].job.cloud_id &&
      job.id !== state.results[0].job.id;
  const button = (text: string, action: () => Promise<void>) =>
      h('button', {
        type: 'button',
        class: 'button small',
        'aria-label': `${text}: ${title}, ${job.id.slice(0, 6)}`,
        onclick: () => void action()
      },
        text);
  return h(
      'li', {},
      h('div', {}, h('span', {class: `dot ${job.status}`, 'aria-hidden': 'true'}), h('span', {}, title),
        h('span', {class: 'hint'}, ` ${words[job.status]} · ${time.format(new Date(job.created_at))}`)),
      h('div', {class: 'row'},
        (job.status === 'successful' || !isEnded(job)) && button('Open', () => session.open(job.id, 0)),
        job.status === 'successful' && sameCloud ? button('Beside', () => session.open(job.id, 1)) : null,
        (job.status === 'failed' || job.status === 'dismissed') && button('Try again', () => session.retry(job.id))));
}

export function mountHistoryPanel(host: HTMLElement, session: Session): void {
  const list = h('ul', {class: 'history'});
  const details = h('details', {class: 'group'}, h('summary', {}, 'Jobs on this server'), list);
  fill(host, details);
  session.onChange(whenChanged(({history, methods, results}) => [history, methods, results[0]], (state) => {
    // The button that was pressed keeps the focus when the list comes anew.
    const focused =
        list.contains(document.activeElement) ? document.activeElement?.getAttribute('aria-label') : undefined;
    fill(
        list,
        ...(state.history.length > 0 ? state.history.map((job) => row(session, state, job)) :
                                       [h('li', {class: 'hint'}, 'None yet.')]));
    if (focused)
      Array.from(list.querySelectorAll('button'))
          .find((button) => button.getAttribute('aria-label') === focused)
          ?.focus();
  }));
}
