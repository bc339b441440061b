// SPDX-License-Identifier: GPL-3.0-or-later
// The page at / as a newcomer uses it, in a real browser.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {test} from 'node:test';

import {browser, dropFile, facts, knot, openPage, ply, reconstruct, serveAndBrowse, server, silhouette, spherePoints} from './support.mjs';

serveAndBrowse();

const words = (page) => page.$$eval('.words li', (items) => items.map((item) => item.textContent));

test('a dropped cloud is seen at once, and becomes a closed mesh with two more clicks at most', async () => {
  const page = await openPage(browser, server.base);
  await dropFile(page, 'sphere.ply', ply(spherePoints(2000)));
  await page.waitForFunction(() => document.querySelectorAll('.facts dd').length === 4);
  assert.deepEqual((await facts(page)).slice(1, 3), ['PLY', '2,000']);
  const dots = await silhouette(page);
  assert.ok(dots.share > 0.01 && Math.abs(dots.width / dots.height - 1) < 0.03, JSON.stringify(dots));
  await reconstruct(page);
  const disc = await silhouette(page);
  assert.ok(Math.abs(disc.width / disc.height - 1) < 0.03, `as wide as high: ${JSON.stringify(disc)}`);
  assert.ok(Math.abs(disc.fill - Math.PI / 4) < 0.03, `a filled disc: ${JSON.stringify(disc)}`);
  assert.ok(disc.colours > 8, 'shaded');
  assert.match(
      (await words(page)).join('\n'), /Watertight[^]*genus 0[^]*Every one of the 2,000 distinct points is a vertex/);
  assert.match(page.url(), /\?job=[a-z0-9]+$/);
  assert.ok(
      page.requests.every((url) => url.startsWith(server.base) || /^(data|blob):/.test(url)),
      'nothing is loaded from elsewhere');
  assert.deepEqual(page.complaints, []);
  await page.context().close();
});

test('two methods stand side by side, their difference is measured, and the link brings both back', async () => {
  const page = await openPage(browser, server.base);
  await page.click('[data-sample="knot.ply"]');
  await reconstruct(page, 'advancing-front');
  await page.selectOption('#method', 'local-delaunay');
  await page.click('#beside');
  await page.waitForSelector('.comparison');
  const half = (side) => (box) =>
      ({x: box.x + (side * box.width) / 2, y: box.y, width: box.width / 2 - 2, height: box.height});
  const [left, right] = [await silhouette(page, half(0)), await silhouette(page, half(1))];
  assert.ok(
      left.share > 0.05 && Math.abs(left.width - right.width) < 8 && Math.abs(left.height - right.height) < 8,
      JSON.stringify([left, right]));
  assert.ok(left.width < left.picture[0] - 8, 'the whole knot is in view');
  await page.selectOption('#colour', 'difference');
  await page.waitForFunction(
      () => /Distance to the other mesh/.test(document.querySelector('.legend')?.textContent ?? ''));
  const link = () => page.$eval('[aria-label="Link to this result"]', (box) => box.value);
  const both = page.url();
  assert.match(both, /&with=/);
  assert.equal(await link(), both);
  await page.goto(both);
  await page.waitForSelector('.comparison');
  const heads = await page.$$eval('.comparison thead th', (cells) => cells.map((cell) => cell.textContent));
  assert.equal(heads.length, 2);
  await page.waitForFunction(() => document.querySelectorAll('.facts dd')[2]?.textContent === '6,000');
  await page.click('#close-second');
  await page.waitForSelector('.headline');
  assert.equal(await link(), both.replace(/&.*/, ''));
  await page.goto(both.replace(/job=[^&]+/, `job=${'0'.repeat(32)}`));
  await page.waitForSelector('.card.error[data-code="job_not_found"]');
  await page.waitForTimeout(200);
  assert.equal(await page.locator('.card.error').count(), 1, 'the error stays');
  assert.equal(await page.locator('.headline').count(), 0, 'and the second does not stand alone');
  assert.deepEqual(page.complaints, []);
  await page.context().close();
});

test('the mesh is saved in every format that is offered', async () => {
  const page = await openPage(browser, server.base);
  await dropFile(page, 'knot.ply', knot);
  await reconstruct(page, 'advancing-front');
  const begins = {
    'mesh.glb': /^glTF/,
    'mesh.gltf': /^\{/,
    'mesh.ply': /^ply/,
    'mesh.obj': /^#|^v /,
    'mesh.stl': /^/,
    'mesh.3mf': /^PK/,
    'mesh.drc': /^DRACO/,
    'report.json': /^\{/,
    'log.txt': /./
  };
  for (const [output, pattern] of Object.entries(begins)) {
    const [download] = await Promise.all([page.waitForEvent('download'), page.click(`[data-output="${output}"]`)]);
    assert.match(download.suggestedFilename(), /^knot/);
    const bytes = readFileSync(await download.path());
    assert.ok(bytes.length > 100, output);
    assert.match(bytes.subarray(0, 40).toString('latin1'), pattern, output);
  }
  await page.context().close();
});
