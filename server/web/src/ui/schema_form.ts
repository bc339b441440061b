// SPDX-License-Identifier: GPL-3.0-or-later
// A form made of the JSON Schema of a method's parameters. Only what differs from its default is sent.
import type {Method, ParameterSchema} from '../api/types';
import {t} from '../words/words';
import {h} from './dom';

interface Input {
  input: HTMLElement;
  value(): unknown;
}

interface Field extends Input {
  row: HTMLElement;
}

export interface SchemaForm {
  element: HTMLElement;
  /** What differs from the defaults. */
  values(): Record<string, unknown>;
  /** Whether all fields hold what their schemas allow; shows the first that does not. */
  valid(): boolean;
  /** Marks a field as wrong until it is changed, and shows it. */
  mark(name: string): void;
}

const isNumber = (schema: ParameterSchema): boolean => schema.type === 'integer' || schema.type === 'number';

function numberInput(id: string, schema: ParameterSchema, value: unknown): HTMLInputElement {
  return h('input', {
    id,
    type: 'number',
    required: true,
    value: String(value),
    min: schema.minimum ?? schema.exclusiveMinimum,
    max: schema.maximum,
    step: schema.type === 'integer' ? '1' : 'any',
    'aria-describedby': `${id}-text`
  });
}

function choice(id: string, options: string[], value: unknown): HTMLSelectElement {
  const entries = options.map((option) => h('option', {value: option, selected: option === value}, option));
  return h('select', {id, 'aria-describedby': `${id}-text`}, ...entries);
}

/** A word, as `auto`, or a number. */
function wordOrNumber(id: string, words: string[], number: ParameterSchema, given: unknown): Input {
  const own = typeof given === 'number';
  const select = choice(id, [...words, t.method.value], own ? t.method.value : given);
  const input = numberInput(`${id}-number`, number, own ? given : (number.minimum ?? 1));
  input.setAttribute('aria-label', t.method.valueLabel);
  input.hidden = !own;
  input.disabled = !own;
  select.addEventListener('change', () => {
    input.hidden = select.value !== t.method.value;
    input.disabled = input.hidden;
  });
  const value = () => (select.value === t.method.value ? Number(input.value) : select.value);
  return {input: h('span', {class: 'pair'}, select, input), value};
}

function inputOf(id: string, schema: ParameterSchema, given: unknown): Input {
  const number = schema.oneOf?.find(isNumber);
  const words =
      (schema.oneOf ?? []).flatMap((each) => each.enum ?? (typeof each.const === 'string' ? [each.const] : []));
  if (number && words.length > 0) return wordOrNumber(id, words, number, given);
  if (schema.enum) {
    const select = choice(id, schema.enum, given);
    return {input: select, value: () => select.value};
  }
  if (schema.type === 'boolean') {
    const box = h('input', {id, type: 'checkbox', checked: given === true});
    return {input: box, value: () => box.checked};
  }
  if (isNumber(schema)) {
    const input = numberInput(id, schema, given ?? 0);
    return {input, value: () => Number(input.value)};
  }
  const text = h('input', {id, type: 'text', value: String(given ?? '')});
  return {input: text, value: () => text.value};
}

function fieldOf(prefix: string, name: string, schema: ParameterSchema, given: unknown): Field {
  const id = `${prefix}-${name}`;
  const {input, value} = inputOf(id, schema, given);
  const unit = schema['x-unit'] && schema['x-unit'] !== '1' ? ` [${schema['x-unit']}]` : '';
  const label = h('label', {'for': id}, schema.title ?? name, h('span', {class: 'unit'}, unit));
  const text = h('p', {id: `${id}-text`, class: 'hint'}, h('code', {}, name), ` — ${schema.description ?? ''}`);
  return {
    row: h('div', {class: schema.type === 'boolean' ? 'field check' : 'field'}, label, input, text),
    input,
    value
  };
}

/** Parameters that every method has are about what comes before and after it. */
export function sharedNames(methods: Method[]): Set<string> {
  const [first, ...others] = methods;
  const names = Object.keys(first?.parameters.properties ?? {});
  const inAll = (name: string): boolean => others.every((method) => name in method.parameters.properties);
  return new Set(others.length === 0 ? [] : names.filter(inAll));
}

function showField(row: HTMLElement): void {
  row.closest('details')?.setAttribute('open', '');
  row.scrollIntoView({block: 'center'});
}

/** @param given what the fields say at first; the others say their defaults. */
export function schemaForm(
    prefix: string, method: Method, shared: Set<string>, given: Record<string, unknown>): SchemaForm {
  const {properties} = method.parameters;
  const names = Object.keys(properties);
  const fields = new Map(
      names.map((name) => [name, fieldOf(prefix, name, properties[name], given[name] ?? properties[name].default)]));
  const group = (title: string, members: string[]): HTMLElement|null => {
    if (members.length === 0) return null;
    const set = members.filter((name) => given[name] !== undefined && given[name] !== properties[name].default).length;
    const tally = h('span', {class: 'tally'}, String(members.length), set > 0 ? ` · ${t.method.changed(set)}` : '');
    return h(
        'details', {class: 'group'}, h('summary', {}, title, tally), ...members.map((name) => fields.get(name)?.row));
  };
  const element =
      h('div', {class: 'schema-form'},
        group(t.method.parameters(method.title), names.filter((name) => !shared.has(name))),
        group(t.method.shared, names.filter((name) => shared.has(name))));
  // An empty text where nothing is the default is nothing, too.
  const isDefault = (name: string, value: unknown): boolean => value === (properties[name].default ?? '');
  const values = (): Record<string, unknown> => Object.fromEntries(
      names.map((name) => [name, fields.get(name)?.value()] as const).filter(([name,
                                                                               value]) => !isDefault(name, value)));
  const valid = (): boolean => {
    const wrong = [...element.querySelectorAll('input')].find((input) => !input.disabled && !input.validity.valid);
    wrong?.closest('details')?.setAttribute('open', '');
    wrong?.reportValidity();
    return wrong === undefined;
  };
  const mark = (name: string): void => {
    const field = fields.get(name);
    if (!field) return;
    const input = field.input.matches('input, select') ? field.input : field.input.querySelector('select');
    input?.setAttribute('aria-invalid', 'true');
    field.row.classList.add('wrong');
    field.row.addEventListener('change', () => {
      input?.removeAttribute('aria-invalid');
      field.row.classList.remove('wrong');
    }, {once: true});
    showField(field.row);
    input?.focus({preventScroll: true});
  };
  return {element, values, valid, mark};
}
