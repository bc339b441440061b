// SPDX-License-Identifier: GPL-3.0-or-later
// For everybody: checked by axe, without a mouse, on a telephone, in the dark.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {test} from 'node:test';

import {browser, dropFile, knot, openPage, pointsShown, reconstruct, serveAndBrowse, server, silhouette} from './support.mjs';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
serveAndBrowse();

async function findings(page) {
  await page.evaluate(axe);
  const {violations} = await page.evaluate(() => window.axe.run(document, {resultTypes: ['violations']}));
  return violations.map(
      ({id, nodes}) => `${id}: ${nodes.map((node) => `${node.target} ${node.any[0]?.message ?? ''}`).join(' | ')}`);
}

for (const colorScheme of ['light', 'dark']) {
  test(
      `axe finds nothing on the page, a result, a comparison, an error, the jobs and /docs, ${colorScheme}`,
      async () => {
        const page = await openPage(browser, server.base, {colorScheme});
        assert.deepEqual(await findings(page), []);
        await dropFile(page, 'knot.ply', knot);
        for (const group of await page.$$('#setup details > summary')) await group.click();
        await reconstruct(page, 'advancing-front');
        for (const group of await page.$$('#results details:not([open]) > summary')) await group.click();
        await page.selectOption('#colour', 'lR');
        await page.waitForSelector('.legend');
        assert.deepEqual(await findings(page), []);
        await page.click('#beside');
        await page.waitForSelector('.comparison');
        await page.$eval('.history', (list) => list.closest('details').setAttribute('open', ''));
        await page.click('[data-tool="pick"]');
        assert.deepEqual(await findings(page), []);
        await page.goto(`${server.base}/?job=${'0'.repeat(32)}`);
        await page.waitForSelector('.card.error');
        assert.deepEqual(await findings(page), []);
        await page.goto(`${server.base}/docs`);
        await page.waitForSelector('#schemas section');
        assert.deepEqual(await findings(page), []);
        await page.context().close();
      });
}

test('everything is done without a mouse', async () => {
  const page = await openPage(browser, server.base);
  const reach = async (selector) => {
    for (let i = 0; i < 60; i += 1) {
      await page.keyboard.press('Tab');
      if (await page.evaluate((wanted) => document.activeElement?.matches(wanted), selector)) return;
    }
    throw new Error(`${selector} is not reached by Tab`);
  };
  await reach('.chip, [data-sample]');
  await page.keyboard.press('Enter');
  await pointsShown(page);
  const focused = () => page.evaluate(() => document.activeElement?.id);
  assert.equal(
      await page.evaluate(() => document.activeElement?.textContent), 'Knot', 'what was pressed keeps the focus');
  await reach('#run');
  await page.keyboard.press('Enter');
  await page.waitForSelector('.headline');
  assert.equal(await focused(), 'run', 'and keeps it');
  assert.match(
      await page.textContent('#status'), /Done: a mesh of 12,000 triangles, watertight/, 'the end is announced');
  await page.keyboard.press('e');
  await page.click('#canvas', {position: {x: 20, y: 200}});
  assert.equal(
      await page.getAttribute('[data-look="wireframe"]', 'aria-pressed'), 'false',
      'a letter does nothing outside of the picture');
  assert.ok(
      await page.evaluate(() => document.activeElement?.id === 'canvas'), 'a click into the picture gives it the keys');
  const earlier = await silhouette(page);
  for (let i = 0; i < 8; i += 1) await page.keyboard.press('ArrowRight');
  const later = await silhouette(page);
  assert.notEqual(earlier.width, later.width, 'the arrow keys turn the mesh');
  assert.match(await page.getAttribute('#canvas', 'aria-label'), /mesh of 12,000 triangles by minimum-boundary/);
  await page.keyboard.press('e');
  await page.waitForSelector('[data-look="wireframe"][aria-pressed="true"]');
  await page.focus('#setup .chip');
  await page.$eval('[data-output="log.txt"]', (button) => button.click());
  await page.waitForFunction(() => /is saved/.test(document.querySelector('#work').textContent));
  assert.ok(
      await page.evaluate(() => document.activeElement?.matches('#setup .chip')),
      'a notice takes the focus from nobody');
  await page.context().close();
});

test('a telephone shows all of it in one column, and the fingers reach it', async () => {
  const page =
      await openPage(browser, server.base, {viewport: {width: 390, height: 844}, isMobile: true, hasTouch: true});
  await page.tap('[data-sample="knot.ply"]');
  await page.tap('#run');
  await page.waitForSelector('.headline');
  const widths = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  assert.ok(widths[0] <= widths[1], `${widths}`);
  const seen = await silhouette(page);
  assert.ok(seen.share > 0.05 && seen.width < seen.picture[0], JSON.stringify(seen));
  await page.context().close();
});
