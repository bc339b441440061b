// SPDX-License-Identifier: GPL-3.0-or-later
// Fast enough without a graphics card: large meshes load and turn. Frames are timed, so nothing else may run.
import assert from 'node:assert/strict';
import {test} from 'node:test';

import {bumpySphere, glb} from './big_mesh.mjs';
import {browser, dropFile, knot, openPage, reconstruct, serveAndBrowse, server, silhouette} from './support.mjs';

serveAndBrowse();

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
  test(`a mesh of ${4 * rows * rows} triangles loads and turns, drawn in software`, {timeout: 600_000}, async (t) => {
    const body = glb(bumpySphere(rows));
    const page = await openPage(browser, server.base);
    await page.route('**/outputs/mesh.glb', (route) => route.fulfill({body, contentType: 'model/gltf-binary'}));
    await dropFile(page, 'knot.ply', knot);
    const began = Date.now();
    await reconstruct(page, 'advancing-front');
    const loaded = Date.now() - began;
    const disc = await silhouette(page);
    assert.ok(Math.abs(disc.fill - Math.PI / 4) < 0.05, JSON.stringify(disc));
    let times = [Infinity];
    // What else the machine does is not the page's fault: the best of four.
    for (let i = 0; i < 4 && times[Math.floor(0.9 * times.length)] > 100; i += 1) times = await turn(page);
    t.diagnostic(`loaded in ${loaded} ms; ${times.length} frames, median ${
        times[times.length >> 1].toFixed(0)} ms, longest ${times.at(-1).toFixed(0)} ms`);
    assert.ok(loaded < loads, `${loaded} ms`);
    assert.ok(times[times.length >> 1] < (process.env.CI_SLOW ? 1000 : 400), 'it moves');
    assert.deepEqual(page.complaints, []);
    await page.context().close();
  });
}
