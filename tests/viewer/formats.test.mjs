// SPDX-License-Identifier: GPL-3.0-or-later
// What the page shows of a file before the server has it, against what the server says of the same bytes.
import assert from 'node:assert/strict';
import {readdirSync, readFileSync} from 'node:fs';
import path from 'node:path';
import {after, test} from 'node:test';

import {browser, dropFile, facts, openPage, serveAndBrowse, server, source} from './support.mjs';

serveAndBrowse();
let page;
const onePage = async () => (page ??= await openPage(browser, server.base));
after(() => page?.context().close());

/** Some of the clouds that the fuzz tests start from: every format, and of PLY and text every kind. */
const seeds = ['ply', 'text', 'pcd', 'las', 'obj', 'stl', 'gltf', 'draco'].flatMap((format) => {
  const folder = path.join(source, 'tests/fuzz/seeds', format);
  const names = readdirSync(folder).filter(
      (name) => format !== 'draco' ||
          /cloud_(kd|sequential)_bits11_speed5\.drc|mesh_edgebreaker_bits11_speed0\.drc/.test(name));
  return names.map((name) => ({format, name, bytes: readFileSync(path.join(folder, name))}));
});

async function serverSays(bytes) {
  const post = await fetch(
      `${server.base}/v1/clouds`, {method: 'POST', body: bytes, headers: {'content-type': 'application/octet-stream'}});
  let cloud = await post.json();
  for (let i = 0; i < 2000 && cloud.status === 'inspecting'; i += 1) {
    await new Promise((resolve) => setTimeout(resolve, 50));
    cloud = await (await fetch(`${server.base}/v1/clouds/${cloud.id}`)).json();
  }
  return cloud;
}

test('the page counts and measures the points of every format as the server does', async () => {
  await onePage();
  assert.ok(seeds.length > 25, `${seeds.length}`);
  const clouds = await Promise.all(seeds.map(({bytes}) => serverSays(bytes)));
  for (const [i, {format, name, bytes}] of seeds.entries()) {
    const cloud = clouds[i];
    await dropFile(page, `${format}-${name}`, bytes);
    await page.waitForFunction(
        () => document.querySelectorAll('.facts dd').length === 4 ||
            document.querySelector('#setup .panel:first-child .note'));
    const shown = await facts(page);
    if (cloud.status === 'refused') {
      assert.equal(
          shown.length, 1, `${format}/${name}: the server refuses it (${cloud.error.code}), the page shows ${shown}`);
      continue;
    }
    assert.equal(shown.length, 4, `${format}/${name}: ${await page.textContent('#setup .panel:first-child')}`);
    assert.equal(shown[2].replaceAll(',', ''), String(cloud.points), `${format}/${name}`);
    const extent = shown[3].split(' × ').map(Number);
    cloud.bounds.max.forEach((high, axis) => {
      const size = high - cloud.bounds.min[axis];
      assert.ok(
          Math.abs(extent[axis] - size) <= 2e-3 * size + 1e-12,
          `${format}/${name}: ${shown[3]} against ${JSON.stringify(cloud.bounds)}`);
    });
  }
  assert.deepEqual(page.complaints, []);
});

test('the first rows of a text are shown, and it is read again as the parameters say', async () => {
  await onePage();
  const rows = Array.from({length: 8}, (_, i) => `${i * i},${i},${i % 3}`);
  await dropFile(page, 'unknown.csv', Buffer.from(`a,b,c\n${rows.join('\n')}\n`));
  const note = await page.waitForSelector('#setup .panel:first-child .note');
  assert.match(await note.textContent(), /no columns x, y, z; found: a, b, c/);
  const set = (columns) => page.$eval('#parameter-columns', (input, value) => {
    input.value = value;
    input.dispatchEvent(new Event('change', {bubbles: true}));
  }, columns);
  await set('z,x,y');
  await page.waitForSelector('.table-preview', {state: 'attached'});
  assert.deepEqual(
      await page.$$eval('.table-preview th', (cells) => cells.map((cell) => cell.textContent)), ['z', 'x', 'y']);
  assert.deepEqual(
      await page.$$eval(
          '.table-preview tbody tr',
          (lines) => lines.map((line) => [...line.cells].map((cell) => cell.textContent).join())),
      rows.slice(0, 5));
  assert.equal((await facts(page))[2], '8');
  await set('auto');
  await page.waitForSelector('#setup .panel:first-child .note');
  assert.deepEqual(page.complaints, []);
});
