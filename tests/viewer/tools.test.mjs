// SPDX-License-Identifier: GPL-3.0-or-later
// Work on the cloud: measure, pick, cut, crop; axes and scale; all of the toolbar in one row.
import assert from 'node:assert/strict';
import {test} from 'node:test';

import {browser, dropFile, openPage, ply, pointsShown, reconstruct, serveAndBrowse, server, settled, silhouette} from './support.mjs';

serveAndBrowse();

/** A box of 4 by 2 by 1, its sides covered with points. */
function boxPoints() {
  const points = new Map();
  const steps = [40, 20, 10];
  for (let i = 0; i <= steps[0]; i += 1) {
    for (let j = 0; j <= steps[1]; j += 1) {
      for (let k = 0; k <= steps[2]; k += 1) {
        const at = [i, j, k];
        if (at.some((step, axis) => step === 0 || step === steps[axis]))
          points.set(at.join(), at.map((step) => Math.fround(step / 10)));
      }
    }
  }
  return [...points.values()];
}

const said = (page) => page.textContent('.tool-said');

test('axes, scale and measuring agree with the file', async () => {
  const page = await openPage(browser, server.base);
  await dropFile(page, 'box.ply', ply(boxPoints()));
  await pointsShown(page);
  await page.click('[aria-label="Look along z"]');
  const front = await silhouette(page);
  assert.ok(Math.abs(front.width / front.height - 2) < 0.15, `4 by 2 from z: ${JSON.stringify(front)}`);
  const [text, pixels] = [await page.textContent('.bar-scale'), (await page.locator('.bar-line').boundingBox()).width];
  const width = front.width * (Number.parseFloat(text) / pixels);
  assert.ok(Math.abs(width - 4) < 0.6, `${text} are ${pixels} pixels, so that the box is ${width} wide`);
  await page.click('[aria-label="Look along x"]');
  const side = await silhouette(page);
  assert.ok(Math.abs(side.width / side.height - 0.5) < 0.1, `1 by 2 from x: ${JSON.stringify(side)}`);
  const bar = await page.locator('.toolbar').boundingBox();
  assert.ok(bar.height < 50, 'one row at 1280 pixels');
  await page.click('[aria-label="Look along z"]');
  await settled(page);
  await page.click('[data-tool="measure"]');
  const canvas = await page.locator('#canvas').boundingBox();
  const scale = front.width / 4;
  const at = (x) => ({position: {x: canvas.width / 2 + x * scale, y: canvas.height / 2}});
  await page.click('#canvas', at(-1));
  await page.click('#canvas', at(1));
  const measured = Number((await said(page)).replace('Distance ', ''));
  assert.ok(Math.abs(measured - 2) < 0.35, await said(page));
  await page.click('[data-tool="pick"]');
  await page.click('#canvas', at(0.5));
  assert.match(await said(page), /Point [\d,]+at 2\.[3-7]\d*, 1(\.\d+)?, 1$/);
  assert.deepEqual(page.complaints, []);
  await page.context().close();
});

test('a box is cropped out, reconstructed, cut open and pointed at; Undo brings the whole back', async () => {
  const page = await openPage(browser, server.base);
  const points = boxPoints();
  await dropFile(page, 'box.ply', ply(points));
  await pointsShown(page);
  await page.click('[data-tool="crop"]');
  await page.$eval('#crop-x-high', (slider) => {
    slider.value = '501';
    slider.dispatchEvent(new Event('input'));
  });
  const kept = points.filter(([x]) => x <= 2.004).length;
  assert.equal(
      await page.textContent('.crop .number'),
      `${kept.toLocaleString('en')} of ${points.length.toLocaleString('en')} points`);
  await page.click('#crop-apply');
  await page.waitForFunction(() => document.querySelector('#setup .name').textContent === 'box-crop.ply');
  await pointsShown(page);
  assert.deepEqual(
      await page.$$eval('.facts dd', (items) => items.slice(2).map((item) => item.textContent)),
      [kept.toLocaleString('en'), '2 × 2 × 1']);
  await reconstruct(page, 'advancing-front');
  await page.click('[aria-label="Look along z"]');
  const whole = await silhouette(page);
  await page.selectOption('#clip', 'x');
  const half = await silhouette(page);
  assert.ok(Math.abs(half.width / whole.width - 0.5) < 0.1, JSON.stringify([whole, half]));
  await page.click('[data-tool="pick"]');
  const canvas = await page.locator('#canvas').boundingBox();
  await page.click('#canvas', {position: {x: canvas.width / 2 - 30, y: canvas.height / 2}});
  assert.match(await said(page), /Triangle [\d,]+at 0?\.\d+.*, 1l\/R 1\.\d+ · r\/L 0\.2\d*/);
  await page.click('#uncrop');
  await page.waitForFunction(
      (n) => document.querySelectorAll('.facts dd')[2]?.textContent === n, points.length.toLocaleString('en'));
  assert.equal(await page.textContent('#setup .name'), 'box.ply');
  assert.deepEqual(page.complaints, []);
  await page.context().close();
});
