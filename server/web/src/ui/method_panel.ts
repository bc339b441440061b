// SPDX-License-Identifier: GPL-3.0-or-later
// The second step: which method, with which parameters; and the button that begins.
import type {Session} from '../app/session';
import type {Side, State} from '../app/state';
import type {Method} from '../api/types';
import type {TableOptions} from '../clouds/table';
import {fill, h} from './dom';
import {schemaForm, sharedNames, type SchemaForm} from './schema_form';

function about(method: Method): HTMLElement {
  const list = (title: string, items: string[]) =>
      items.length > 0 && [h('h4', {}, title), h('ul', {}, ...items.map((item) => h('li', {}, item)))];
  return h(
      'div', {class: 'about'}, h('p', {class: 'hint'}, method.summary),
      h('details', {class: 'group'}, h('summary', {}, 'What it promises'),
        ...(list('It guarantees', method.guarantees) || []), ...(list('It does not', method.limitations) || []),
        h('p', {class: 'hint'}, method.source)));
}

export function mountMethodPanel(host: HTMLElement, session: Session): void {
  let methods: Method[] = [];
  let form: SchemaForm|undefined;
  const select = h('select', {id: 'method', 'aria-label': 'Method'});
  const body = h('div');
  const run = h('button', {type: 'button', class: 'button primary wide', id: 'run'}, 'Reconstruct');
  const beside = h('button', {type: 'button', class: 'button wide', id: 'beside'}, 'Run beside, to compare');
  const chosen = (): Method|undefined => methods.find((method) => method.id === select.value);
  /** The page reads a text as the server is going to. */
  const readTable = (): void => {
    const given = Object.entries(form?.values() ?? {});
    session.setTable(
        Object.fromEntries(given.filter(([name]) => ['columns', 'separator', 'decimal', 'skip'].includes(name))) as
        TableOptions);
  };
  const rebuild = (): void => {
    const method = chosen();
    if (!method) return;
    form = schemaForm('parameter', method, sharedNames(methods));
    fill(body, about(method), form.element);
    readTable();
  };
  const begin = (side: Side) => (): void => {
    if (form?.valid()) void session.run({method: select.value, parameters: form.values()}, side);
  };
  select.addEventListener('change', rebuild);
  body.addEventListener('change', readTable);
  run.addEventListener('click', begin(0));
  beside.addEventListener('click', begin(1));
  fill(
      host, h('h2', {}, h('span', {class: 'step', 'aria-hidden': 'true'}, '2'), 'Method'), select, body,
      h('div', {class: 'row actions'}, run, beside));
  const update = (state: State): void => {
    if (state.methods !== methods) {
      methods = state.methods;
      fill(select, ...methods.map((method) => h('option', {value: method.id}, method.title)));
      rebuild();
    }
    run.disabled = !state.cloud || state.work !== undefined;
    beside.hidden = !state.results[0] || !state.cloud;
    beside.disabled = state.work !== undefined;
  };
  session.onChange(update);
  update(session.state);
}
