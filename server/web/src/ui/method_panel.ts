// SPDX-License-Identifier: GPL-3.0-or-later
// The second step: which method, with which parameters; and the button that begins.
import type {ApiError} from '../api/client';
import type {Method} from '../api/types';
import {runBatch} from '../app/batch';
import type {Session} from '../app/session';
import type {Run, Side, State} from '../app/state';
import {t} from '../words/words';
import {fill, h} from './dom';
import {schemaForm, sharedNames, type SchemaForm} from './schema_form';

function about(method: Method): HTMLElement {
  const list = (title: string, items: string[]) => items.length > 0 ?
      [h('h3', {class: 'small'}, title), h('ul', {}, ...items.map((item) => h('li', {}, item)))] :
      [];
  return h(
      'div', {class: 'about'}, h('p', {class: 'hint'}, method.summary),
      h('details', {class: 'group'}, h('summary', {}, t.method.promises),
        ...list(t.method.guarantees, method.guarantees), ...list(t.method.limits, method.limitations),
        h('p', {class: 'hint'}, method.source)));
}

/** Stays reachable while it cannot be pressed, so that it keeps the focus. */
function setAble(button: HTMLButtonElement, able: boolean): void {
  button.setAttribute('aria-disabled', String(!able));
}

interface Panel {
  methods: Method[];
  form?: SchemaForm;
  /** What the form was made of. */
  run?: Run;
}

export function mountMethodPanel(host: HTMLElement, session: Session): void {
  const panel: Panel = {methods: []};
  const select = h('select', {id: 'method', 'aria-label': t.method.title});
  const body = h('div');
  const button = (id: string, look: string, text: string) =>
      h('button', {type: 'button', class: `button ${look} wide`, id}, text);
  const run = button('run', 'primary', t.method.run);
  const beside = button('beside', '', t.method.beside);
  const batch = button('run-all', 'primary', t.batch.run);
  const rebuild = (wanted: Run): void => {
    const method = panel.methods.find(({id}) => id === wanted.method) ?? panel.methods[0];
    if (!method) return;
    select.value = method.id;
    panel.form = schemaForm('parameter', method, sharedNames(panel.methods), wanted.parameters);
    fill(body, about(method), panel.form.element);
  };
  const tell = (): void => {
    panel.run = {method: select.value, parameters: panel.form?.values() ?? {}};
    session.setRun(panel.run);
  };
  const begin = (side: Side) => (): void => {
    if (!session.state.cloud || session.state.work || !panel.form?.valid()) return;
    tell();
    if (panel.run) void session.run(panel.run, side);
  };
  select.addEventListener('change', () => {
    // What every method takes stays as it is.
    const shared = sharedNames(panel.methods);
    const kept = Object.entries(panel.form?.values() ?? {}).filter(([name]) => shared.has(name));
    rebuild({method: select.value, parameters: Object.fromEntries(kept)});
    tell();
  });
  body.addEventListener('change', tell);
  run.addEventListener('click', begin(0));
  beside.addEventListener('click', begin(1));
  batch.addEventListener('click', () => {
    if (panel.form?.valid())
      void runBatch(session, session.state.dropped, {method: select.value, parameters: panel.form.values()});
  });
  const step = h('span', {class: 'step', 'aria-hidden': 'true'}, '2');
  fill(host, h('h2', {}, step, t.method.title), select, body, h('div', {class: 'row actions'}, batch, run, beside));
  let shownError: ApiError|undefined;
  const update = (state: State): void => {
    if (state.methods !== panel.methods) {
      panel.methods = state.methods;
      fill(select, ...state.methods.map((method) => h('option', {value: method.id}, method.title)));
      rebuild(state.run ?? {method: '', parameters: {}});
      return tell();
    }
    if (state.run && state.run !== panel.run) {
      panel.run = state.run;
      rebuild(state.run);
    }
    if (state.error !== shownError) {
      shownError = state.error;
      if (shownError?.field) panel.form?.mark(shownError.field.split('.').at(-1) ?? '');
    }
    setAble(run, state.cloud !== undefined && !state.work);
    setAble(beside, !state.work);
    run.hidden = state.dropped.length > 0;
    batch.hidden = !run.hidden;
    beside.hidden = !state.results[0] || !state.cloud || run.hidden;
  };
  session.onChange(update);
  update(session.state);
}
