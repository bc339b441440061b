// SPDX-License-Identifier: GPL-3.0-or-later
// A form made of the JSON Schema of a method's parameters. Only what differs from its default is sent.
import type {Method, ParameterSchema} from '../api/types';
import {h} from './dom';

interface Field {
  row: HTMLElement;
  value(): unknown;
}

export interface SchemaForm {
  element: HTMLElement;
  /** What differs from the defaults. */
  values(): Record<string, unknown>;
  /** The first field that holds what its schema does not allow; shows why. */
  valid(): boolean;
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
  return h(
      'select', {id, 'aria-describedby': `${id}-text`},
      ...options.map((option) => h('option', {value: option, selected: option === value}, option)));
}

/** A word, as `auto`, or a number. */
function wordOrNumber(id: string, words: string[], number: ParameterSchema, otherwise: unknown):
    {input: HTMLElement; value: () => unknown} {
  const own = typeof otherwise === 'number';
  const select = choice(id, [...words, 'a value'], own ? 'a value' : otherwise);
  const input = numberInput(`${id}-number`, number, own ? otherwise : (number.minimum ?? 1));
  input.setAttribute('aria-label', 'Value');
  input.hidden = !own;
  input.disabled = !own;
  select.addEventListener('change', () => {
    input.hidden = select.value !== 'a value';
    input.disabled = input.hidden;
  });
  return {
    input: h('span', {class: 'pair'}, select, input),
    value: () => (select.value === 'a value' ? Number(input.value) : select.value)
  };
}

function inputOf(id: string, schema: ParameterSchema): {input: HTMLElement; value: () => unknown} {
  const number = schema.oneOf?.find(isNumber);
  const words =
      (schema.oneOf ?? []).flatMap((each) => each.enum ?? (typeof each.const === 'string' ? [each.const] : []));
  if (number && words.length > 0) return wordOrNumber(id, words, number, schema.default);
  if (schema.enum) {
    const select = choice(id, schema.enum, schema.default);
    return {input: select, value: () => select.value};
  }
  if (schema.type === 'boolean') {
    const box = h('input', {id, type: 'checkbox', checked: schema.default === true});
    return {input: box, value: () => box.checked};
  }
  if (isNumber(schema)) {
    const input = numberInput(id, schema, schema.default ?? 0);
    return {input, value: () => Number(input.value)};
  }
  const text = h('input', {id, type: 'text', value: String(schema.default ?? '')});
  return {input: text, value: () => text.value};
}

function fieldOf(prefix: string, name: string, schema: ParameterSchema): Field {
  const id = `${prefix}-${name}`;
  const {input, value} = inputOf(id, schema);
  const unit = schema['x-unit'] && schema['x-unit'] !== '1' ? ` [${schema['x-unit']}]` : '';
  const row =
      h('div', {class: 'field'},
        h('label',
          { for: id
          },
          schema.title ?? name, h('span', {class: 'unit'}, unit)),
        input, h('p', {id: `${id}-text`, class: 'hint'}, h('code', {}, name), ` — ${schema.description ?? ''}`));
  return {row, value};
}

/** Parameters that every method has are about what comes before and after it. */
export function sharedNames(methods: Method[]): Set<string> {
  const [first, ...others] = methods;
  const names = Object.keys(first?.parameters.properties ?? {});
  return new Set(
      others.length === 0 ? [] :
                            names.filter((name) => others.every((method) => name in method.parameters.properties)));
}

export function schemaForm(prefix: string, method: Method, shared: Set<string>): SchemaForm {
  const entries = Object.entries(method.parameters.properties);
  const fields = new Map(entries.map(([name, schema]) => [name, fieldOf(prefix, name, schema)]));
  const group = (title: string, names: string[]): HTMLElement|null => {
    if (names.length === 0) return null;
    const rows = names.map((name) => fields.get(name)?.row);
    return h(
        'details', {class: 'group'}, h('summary', {}, title, h('span', {class: 'tally'}, String(names.length))),
        ...rows);
  };
  const names = [...fields.keys()];
  const element = h(
      'div', {class: 'schema-form'}, group(`Parameters of ${method.title}`, names.filter((name) => !shared.has(name))),
      group('Preparing and output', names.filter((name) => shared.has(name))));
  const values = (): Record<string, unknown> =>
      Object.fromEntries(entries.map(([name]) => [name, fields.get(name)?.value()] as const)
                             .filter(([name, value]) => value !== method.parameters.properties[name].default));
  const valid = (): boolean => {
    const wrong = [...element.querySelectorAll('input')].find((input) => !input.disabled && !input.validity.valid);
    wrong?.closest('details')?.setAttribute('open', '');
    wrong?.reportValidity();
    return wrong === undefined;
  };
  return {element, values, valid};
}
