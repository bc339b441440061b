// SPDX-License-Identifier: GPL-3.0-or-later
// The jobs that the server knows as cards, newest first: open one, put one beside, try a failed one again, delete,
// share.
import {isEnded, type Job} from '../api/types';
import {pictureOf} from '../app/pictures';
import type {Session} from '../app/session';
import type {State} from '../app/state';
import {language} from '../words/language';
import {seconds} from '../words/numbers';
import {t} from '../words/words';
import {whenChanged} from './changed';
import {fill, h} from './dom';

const time = new Intl.DateTimeFormat(
    language, {day: 'numeric', month: 'short', hour: '2-digit', minute: '2-digit', hour12: false});
/** While jobs run, the list is asked for so often. */
const kRefresh = 3000;

const nameOf = (job: Job): string =>
    job.labels[0] ?? (job.cloud_id ? t.cloud.unnamed(job.cloud_id.slice(0, 8)) : t.jobs.unnamed);

function took({started_at: from, finished_at: to}: Job): string {
  return from && to ? ` · ${seconds((Date.parse(to) - Date.parse(from)) / 1000)}` : '';
}

function stateOf(job: Job): string {
  const percent = job.status === 'running' && job.progress > 0 ? ` ${Math.round(100 * job.progress)} %` : '';
  return `${t.jobs[job.status]}${percent}${took(job)}`;
}

async function share(session: Session, job: Job): Promise<void> {
  const link = new URL(`?job=${job.id}`, session.api.base).href;
  try {
    await navigator.clipboard.writeText(link);
    session.change({notice: t.result.copied(t.result.link)});
  } catch {
    session.change({notice: link});
  }
}

/** The button has to be pressed twice. */
function removeButton(session: Session, job: Job, label: string): HTMLButtonElement {
  const button =
      h('button', {type: 'button', class: 'button small', 'aria-label': `${t.jobs.remove}: ${label}`}, t.jobs.remove);
  const calm = (): void => {
    button.textContent = t.jobs.remove;
    button.setAttribute('aria-label', `${t.jobs.remove}: ${label}`);
    button.classList.remove('sure');
  };
  button.addEventListener('blur', calm);
  button.addEventListener('click', () => {
    if (button.classList.contains('sure')) {
      void session.remove(job.id);
      return;
    }
    button.classList.add('sure');
    button.textContent = t.jobs.sure;
    button.setAttribute('aria-label', `${t.jobs.sure} ${label}`);
  });
  return button;
}

function card(session: Session, state: State, job: Job): HTMLElement {
  const title = state.methods.find((method) => method.id === job.method)?.title ?? job.method;
  const [first] = state.results;
  const sameCloud = first && job.cloud_id !== null && job.cloud_id === first.job.cloud_id && job.id !== first.job.id;
  const label = `${nameOf(job)}, ${title}, ${job.id.slice(0, 6)}`;
  const button = (text: string, action: () => Promise<void>) =>
      h('button',
        {type: 'button', class: 'button small', 'aria-label': `${text}: ${label}`, onclick: () => void action()}, text);
  const done = job.status === 'successful';
  const url = pictureOf(job.id);
  const picture = url ? h('img', {src: url, alt: t.jobs.thumbnail(nameOf(job)), width: 64, height: 48}) :
                        h('span', {class: 'no-picture', 'aria-hidden': 'true'});
  const dot = h('span', {class: `dot ${job.status}`, 'aria-hidden': 'true'});
  return h(
      'li', {class: job.id === first?.job.id ? 'shown' : ''}, picture,
      h('div', {class: 'job'}, h('strong', {}, nameOf(job)), h('span', {class: 'hint'}, title),
        h('span', {class: 'hint number'}, dot, `${stateOf(job)} · ${time.format(new Date(job.created_at))}`)),
      h('div', {class: 'row'}, (done || !isEnded(job)) && button(t.jobs.open, () => session.open(job.id, 0)),
        done && sameCloud ? button(t.jobs.beside, () => session.open(job.id, 1)) : null,
        (job.status === 'failed' || job.status === 'dismissed') && button(t.jobs.again, () => session.retry(job.id)),
        done && button(t.jobs.share, () => share(session, job)), isEnded(job) && removeButton(session, job, label)));
}

/** Whether every word of the search is in what the card says. */
function matches(state: State, job: Job, search: string): boolean {
  const title = state.methods.find((method) => method.id === job.method)?.title ?? '';
  const text = `${nameOf(job)} ${job.method} ${title} ${t.jobs[job.status]} ${job.id}`.toLowerCase();
  return search.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}

export function mountHistoryPanel(host: HTMLElement, session: Session): void {
  const list = h('ul', {class: 'history'});
  const search = h('input', {type: 'search', class: 'search', placeholder: t.jobs.search, 'aria-label': t.jobs.search});
  const tally = h('span', {class: 'tally'});
  const details = h('details', {class: 'group'}, h('summary', {}, t.jobs.title, tally), search, list);
  fill(host, details);
  let timer: number|undefined;
  const show = (state: State): void => {
    // The button that was pressed keeps the focus when the list comes anew.
    const focused =
        list.contains(document.activeElement) ? document.activeElement?.getAttribute('aria-label') : undefined;
    const jobs = state.history.filter((job) => matches(state, job, search.value));
    tally.textContent = state.history.length > 0 ? String(state.history.length) : '';
    search.hidden = state.history.length < 4;
    fill(
        list,
        ...(jobs.length > 0 ? jobs.map((job) => card(session, state, job)) : [h('li', {class: 'hint'}, t.jobs.none)]));
    if (focused)
      [...list.querySelectorAll('button')].find((button) => button.getAttribute('aria-label') === focused)?.focus();
    clearTimeout(timer);
    if (details.open && state.history.some((job) => !isEnded(job)))
      timer = window.setTimeout(() => void session.refreshHistory().catch(() => undefined), kRefresh);
  };
  search.addEventListener('input', () => show(session.state));
  details.addEventListener('toggle', () => show(session.state));
  session.onChange(
      whenChanged(({history, methods, results, pictures}) => [history, methods, results[0], pictures], show));
}
