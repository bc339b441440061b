// SPDX-License-Identifier: GPL-3.0-or-later
// The contract itself: schemas compile, examples and error codes obey them.
import assert from 'node:assert/strict';
import { readdirSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { execFileSync } from 'node:child_process';
import { newAjv, readJson, source } from './support.mjs';

const schemas = readdirSync(path.join(source, 'proto/schema'));

function ajvWithSchemas() {
  const ajv = newAjv();
  for (const name of schemas) ajv.addSchema({ ...readJson(`proto/schema/${name}`), $id: `surfaced:/${name}` });
  return ajv;
}

test('every schema compiles', () => {
  const ajv = ajvWithSchemas();
  for (const name of schemas) assert.ok(ajv.getSchema(`surfaced:/${name}`), name);
});

test('every example obeys the schema that its name begins with', () => {
  const ajv = ajvWithSchemas();
  const examples = readdirSync(path.join(source, 'proto/examples'));
  assert.ok(examples.length >= 4);
  for (const name of examples) {
    const validate = ajv.getSchema(`surfaced:/${name.split(/[-.]/)[0]}.json`);
    assert.ok(validate, `no schema for ${name}`);
    assert.ok(validate(readJson(`proto/examples/${name}`)), `${name}: ${ajv.errorsText(validate.errors)}`);
  }
});

test('error codes are unique, lower_snake, with a status, an exit code, a title and a hint', () => {
  const { errors } = readJson('proto/errors.json');
  assert.equal(new Set(errors.map((error) => error.code)).size, errors.length);
  for (const error of errors) {
    assert.match(error.code, /^[a-z][a-z0-9_]*$/);
    assert.ok(error.status >= 400 && error.status < 600, error.code);
    assert.ok(error.exit_code >= 2 && error.exit_code <= 5, error.code);
    assert.ok(error.title.length > 5 && error.hint.length > 5, error.code);
  }
});

test('the parameter schemas of the methods compile and their defaults obey them', () => {
  const methods = JSON.parse(execFileSync(process.env.SURFACED_BIN, ['methods', '--json']));
  assert.ok(methods.length > 0);
  const validateMethod = ajvWithSchemas().getSchema('surfaced:/method.json');
  for (const method of methods) {
    assert.ok(validateMethod(method), method.id);
    const validate = newAjv().compile(method.parameters);
    const defaults = Object.fromEntries(Object.entries(method.parameters.properties).map(([name, schema]) => [name, schema.default]));
    assert.ok(validate(defaults), `${method.id}: ${JSON.stringify(validate.errors)}`);
    for (const [name, schema] of Object.entries(method.parameters.properties)) {
      assert.ok(schema.title && schema.description, `${method.id}.${name} has no title or description`);
    }
  }
});
