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

/** The form as it stands, and what it was made of. */
class MethodForm {
  methods: Method[] = [];
  run: Run|undefined;
  private form: SchemaForm|undefined;
  readonly select = h('select', {id: 'method', 'aria-label': t.method.title});
  readonly body = h('div');

  /** What the fields say; nothing, and the reason shown, if one of them is wrong. */
  read(): Run|undefined {
    return this.form?.valid() ? {method: this.select.value, parameters: this.form.values()} : undefined;
  }

  /** As it is, wrong fields too. */
  now(): Run {
    return {method: this.select.value, parameters: this.form?.values() ?? {}};
  }

  build(wanted: Run): void {
    const method = this.methods.find(({id}) => id === wanted.method) ?? this.methods[0];
    if (!method) return;
    this.select.value = method.id;
    this.form = schemaForm('parameter', method, sharedNames(this.methods), wanted.parameters);
    fill(this.body, about(method), this.form.element);
  }

  /** Another method; what every method takes stays as it is. */
  change(): void {
    const shared = sharedNames(this.methods);
    const kept = Object.entries(this.form?.values() ?? {}).filter(([name]) => shared.has(name));
    this.build({method: this.select.value, parameters: Object.fromEntries(kept)});
  }

  mark(field: string): void {
    this.form?.mark(field.split('.').at(-1) ?? '');
  }
}

/** Shows what the state says in the form, and the form's first state in the state. */
function follow(session: Session, form: MethodForm, tell: () => void): void {
  let shown: ApiError|undefined;
  const update = ({methods, run, error}: State): void => {
    if (methods !== form.methods) {
      form.methods = methods;
      fill(form.select, ...methods.map((method) => h('option', {value: method.id}, method.title)));
      form.build(run ?? {method: '', parameters: {}});
      return tell();
    }
    if (run && run !== form.run) {
      form.run = run;
      form.build(run);
    }
    if (error !== shown && error?.field) form.mark(error.field);
    shown = error;
  };
  session.onChange(update);
  update(session.state);
}

export function mountMethodPanel(host: HTMLElement, session: Session): void {
  const form = new MethodForm();
  const button = (id: string, look: string, text: string) =>
      h('button', {type: 'button', class: `button ${look} wide`, id}, text);
  const run = button('run', 'primary', t.method.run);
  const beside = button('beside', '', t.method.beside);
  const batch = button('run-all', 'primary', t.batch.run);
  const tell = (): void => {
    form.run = form.now();
    session.setRun(form.run);
  };
  const begin = (side: Side) => (): void => {
    const {cloud, work} = session.state;
    const read = cloud && !work ? form.read() : undefined;
    if (read) void session.run(read, side);
  };
  form.select.addEventListener('change', () => {
    form.change();
    tell();
  });
  form.body.addEventListener('change', tell);
  run.addEventListener('click', begin(0));
  beside.addEventListener('click', begin(1));
  batch.addEventListener('click', () => {
    const read = form.read();
    if (read) void runBatch(session, session.state.dropped, read);
  });
  const step = h('span', {class: 'step', 'aria-hidden': 'true'}, '2');
  fill(
      host, h('h2', {}, step, t.method.title), form.select, form.body,
      h('div', {class: 'row actions'}, batch, run, beside));
  follow(session, form, tell);
  const update = (state: State): void => {
    setAble(run, state.cloud !== undefined && !state.work);
    setAble(beside, !state.work);
    run.hidden = state.dropped.length > 0;
    batch.hidden = !run.hidden;
    beside.hidden = !state.results[0] || !state.cloud || run.hidden;
  };
  session.onChange(update);
  update(session.state);
}
