// SPDX-License-Identifier: GPL-3.0-or-later
// The page /docs: shows the contract to people.
'use strict';
const make = (tag, text, ...children) => {
  const element = document.createElement(tag);
  if (text) element.textContent = text;
  element.append(...children);
  return element;
};
const resolve = (contract, node) =>
  node && node.$ref ? node.$ref.slice(2).split('/').reduce((at, key) => at[key], contract) : node;
const typeOf = (schema) => {
  if (!schema) return '';
  if (schema.$ref) return schema.$ref.split('/').pop();
  if (schema.enum) return schema.enum.join(' | ');
  return [].concat(schema.type ?? (schema.const !== undefined ? String(schema.const) : '')).join(' | ');
};
const row = (...cells) => make('tr', '', ...cells.map((cell) => make('td', cell)));
const table = (head, rows) => {
  const whole = make('table', '', make('tr', '', ...head.map((cell) => make('th', cell))));
  whole.append(...rows);
  return whole;
};
const show = (contract) => {
  document.querySelector('#about').textContent = `${contract.info.summary} ${contract.info.description} Version ${contract.info.version}.`;
  for (const [path, item] of Object.entries(contract.paths)) {
    for (const verb of ['get', 'head', 'post', 'put', 'patch', 'delete', 'options']) {
      const operation = item[verb];
      if (!operation) continue;
      const title = make('summary', '', make('span', verb.toUpperCase()), make('code', path), ` ${operation.summary ?? ''}`);
      title.firstChild.className = 'verb';
      const details = make('details', '', title);
      if (operation.description) details.append(make('p', operation.description));
      const parameters = [...(item.parameters ?? []), ...(operation.parameters ?? [])].map((each) => resolve(contract, each));
      if (parameters.length) {
        details.append(make('h3', 'Parameters'), table(['name', 'in', 'type', 'meaning'],
          parameters.map((each) => row(each.name, each.in, typeOf(each.schema), each.description ?? ''))));
      }
      const body = resolve(contract, operation.requestBody);
      if (body) {
        details.append(make('h3', 'Body'), make('p', body.description ?? ''), table(['media type', 'schema'],
          Object.entries(body.content).map(([type, media]) => row(type, typeOf(media.schema)))));
      }
      details.append(make('h3', 'Answers'), table(['status', 'meaning', 'body'],
        Object.entries(operation.responses).map(([status, given]) => {
          const answer = resolve(contract, given);
          const bodies = Object.entries(answer.content ?? {}).map(([type, media]) => `${type} ${typeOf(media.schema)}`.trim());
          return row(status, answer.description, bodies.join(', '));
        })));
      document.querySelector('#operations').append(make('section', '', details));
    }
  }
  for (const [name, schema] of Object.entries(contract.components.schemas)) {
    const details = make('details', '', make('summary', name), make('pre', JSON.stringify(schema, null, 2)));
    document.querySelector('#schemas').append(make('section', '', details));
  }
};
fetch('/openapi.json').then((answer) => answer.json()).then(show).catch((failure) => {
  document.querySelector('#about').textContent = `The contract could not be read: ${failure.message}`;
});
