// SPDX-License-Identifier: GPL-3.0-or-later
// The page guesses tables of text as the server does: both are held to the same cases.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import path from 'node:path';
import {test} from 'node:test';
import type {TableOptions} from '../../../server/web/src/clouds/table';
import {wordOf} from '../../../server/web/src/clouds/table_cells';
import {readText} from '../../../server/web/src/clouds/text';

interface Case {
  name: string;
  text: string;
  options?: TableOptions;
  refused?: string;
  columns?: string;
  separator?: string;
  decimal?: string;
  guessed?: boolean;
}

const cases =
    JSON.parse(readFileSync(path.join(process.env.SURFACED_SOURCE ?? '.', 'tests/support/tables.json'), 'utf8')) as
    Case[];

for (const each of cases) {
  test(`a table of ${each.name}`, () => {
    const read = (): ReturnType<typeof readText> => readText(new TextEncoder().encode(each.text), each.options);
    if (each.refused) {
      assert.throws(read);
      return;
    }
    const {form} = read();
    assert.equal(form.roles.join(','), each.columns);
    assert.equal(wordOf(form.separator), each.separator);
    assert.equal(form.decimalComma ? 'comma' : 'point', each.decimal);
    if (each.guessed !== undefined) assert.equal(form.guessed, each.guessed);
    assert.ok(form.preview.length >= 1 && form.preview.length <= 5);
  });
}

test('a text of UTF-16 is read in either order', () => {
  const text = 'x,y,z\r\n0.5,1,2\r\n3,4,5\r\n';
  for (const big of [false, true]) {
    for (const marked of [false, true]) {
      const bytes = [...(marked ? `\uFEFF${text}` : text)].flatMap((c) => {
        const unit = c.charCodeAt(0);
        return big ? [unit >> 8, unit & 255] : [unit & 255, unit >> 8];
      });
      assert.deepEqual([...readText(Uint8Array.from(bytes)).xyz], [0.5, 1, 2, 3, 4, 5]);
    }
  }
});
