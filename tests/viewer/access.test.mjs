// SPDX-License-Identifier: GPL-3.0-or-later
// For everybody: checked by axe, without a mouse, on a telephone, in the dark; and fast enough without a graphics card.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { test } from 'node:test';
import { bumpySphere, glb } from './big_mesh.mjs';
import { browser, dropFile, knot, openPage, reconstruct, serveAndBrowse, server, silhouette } from './support.mjs';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
serveAndBrowse();

async function findings(page) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run(document, { resultTypes: ['violations'] }));
  return violations.filter(({ impact }) => impact === 'serious' || impact === 'critical')
    .map(({ id, nodes }) => `${id}: ${nodes.map((node) => `${node.target} ${node.any[0]?.message ?? ''}`).join(' | ')}`);
}

for (const colorScheme of ['light', 'dark']) {
  test(`axe has nothing serious to say of the page, of a result and of a comparison, ${colorScheme}`, async () => {
    const page = await openPage(browser, server.base, { colorScheme });
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
  await page.waitForSelector('.facts');
  await reach('#run');
  await page.keyboard.press('Enter');
  await page.waitForSelector('.headline');
  await page.keyboard.press('e');
  await page.click('#canvas', { position: { x: 20, y: 200 } });
  assert.equal(await page.getAttribute('[data-look="wireframe"]', 'aria-pressed'), 'false', 'a letter does nothing outside of the picture');
  assert.ok(await page.evaluate(() => document.activeElement?.id === 'canvas'), 'a click into the picture gives it the keys');
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
  assert.ok(await page.evaluate(() => document.activeElement?.matches('#setup .chip')), 'a notice takes the focus from nobody');
  await page.context().close();
});

test('a telephone shows all of it in one column, and the fingers reach it', async () => {
  const page = await openPage(browser, server.base, { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true });
  await page.tap('[data-sample="knot.ply"]');
  await page.tap('#run');
  await page.waitForSelector('.headline');
  const widths = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  assert.ok(widths[0] <= widths[1], `${widths}`);
  const seen = await silhouette(page);
  assert.ok(seen.share > 0.05 && seen.width < seen.picture[0], JSON.stringify(seen));
  await page.context().close();
});

/** Turns the mesh by the mouse; the times between frames, sorted. */
async function turn(page) {
  const box = await page.locator('#canvas').boundingBox();
  await page.mouse.move(box.x + 200, box.y + 200);
  await page.mouse.down();
  await page.mouse.move(box.x + 204, box.y + 200);
  await page.waitForTimeout(300);
  await page.evaluate(() => {
    window.frames_ = [];
    let last = performance.now();
    const next = (now) => {
      window.frames_.push(now - last);
      last = now;
      requestAnimationFrame(next);
    };
    requestAnimationFrame(next);
  });
  for (let i = 0; i < 25; i += 1) await page.mouse.move(box.x + 204 + 8 * i, box.y + 200 + i);
  const times = await page.evaluate(() => window.frames_.slice(2).sort((a, b) => a - b));
  await page.mouse.up();
  return times;
}

// SURFACED_BIG_MESH=1: two millions of triangles, instead of half a million.
for (const [rows, loads] of [[158, 30_000], [process.env.SURFACED_BIG_MESH ? 707 : 354, 120_000]]) {
  test(`a mesh of ${4 * rows * rows} triangles loads and turns, drawn in software`, { timeout: 600_000 }, async (t) => {
    const body = glb(bumpySphere(rows));
    const page = await openPage(browser, server.base);
    await page.route('**/outputs/mesh.glb', (route) => route.fulfill({ body, contentType: 'model/gltf-binary' }));
    await dropFile(page, 'knot.ply', knot);
    const began = Date.now();
    await reconstruct(page, 'advancing-front');
    const loaded = Date.now() - began;
    const disc = await silhouette(page);
    assert.ok(Math.abs(disc.fill - Math.PI / 4) < 0.05, JSON.stringify(disc));
    let times = [Infinity];
    // What else the machine does is not the page's fault: the best of four.
    for (let i = 0; i < 4 && times[Math.floor(0.9 * times.length)] > 100; i += 1) times = await turn(page);
    t.diagnostic(`loaded in ${loaded} ms; ${times.length} frames, median ${times[times.length >> 1].toFixed(0)} ms, longest ${times.at(-1).toFixed(0)} ms`);
    assert.ok(loaded < loads, `${loaded} ms`);
    assert.ok(times[times.length >> 1] < (process.env.CI_SLOW ? 1000 : 400), 'it moves');
    assert.deepEqual(page.complaints, []);
    await page.context().close();
  });
}
