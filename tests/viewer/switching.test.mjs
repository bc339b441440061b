// SPDX-License-Identifier: GPL-3.0-or-later
// Who cancels, or turns to something else, is heard at once; what was begun before does not come after it.
import assert from 'node:assert/strict';
import {test} from 'node:test';

import {browser, dropFile, knot, openPage, patience, ply, reconstruct, serveAndBrowse, server, spherePoints} from './support.mjs';

serveAndBrowse();

function signal() {
  const made = {};
  made.promise = new Promise((resolve) => {
    made.resolve = resolve;
  });
  return made;
}

/**
 * Holds the first request of a kind, before it is sent or with its answer in hand; says when it came, and lets it go
 * on.
 */
async function hold(page, url, method, answered) {
  const [came, gate, gone] = [signal(), signal(), signal()];
  let held = false;
  await page.route(url, async (route) => {
    if (held || route.request().method() !== method) return route.continue();
    held = true;
    const response = answered ? await route.fetch() : undefined;
    came.resolve();
    await gate.promise;
    // What the page has given up takes no answer.
    await (response ? route.fulfill({response}) : route.continue()).catch(() => undefined);
    gone.resolve();
  });
  return {came: came.promise, release: () => (gate.resolve(), gone.promise)};
}

const spheres = ply(spherePoints(60000));
const jobs = async () => (await (await fetch(`${server.base}/v1/jobs`)).json()).jobs;
const text = (page) => page.textContent('#work');

/** Nothing more comes, and nothing is wrong. */
async function quiet(page) {
  await page.waitForTimeout(200);
  await page.waitForSelector('.card.work', {state: 'detached'});
  assert.equal(await page.locator('.card').count(), 0, await text(page));
}

test('an upload that is cancelled, or left for another file, is no error', async () => {
  const page = await openPage(browser, server.base);
  for (const leave of [() => page.click('#cancel'), () => dropFile(page, 'other.ply', ply(spherePoints(500)))]) {
    await dropFile(page, 'sphere.ply', spheres);
    const upload = await hold(page, '**/v1/uploads/**', 'PATCH', false);
    await page.click('#run');
    await upload.came;
    await page.waitForSelector('.card.work[data-what="upload"]');
    await leave();
    await quiet(page);
    await upload.release();
    await quiet(page);
    await page.unrouteAll();
  }
  assert.equal(await page.textContent('#setup .name'), 'other.ply');
  await reconstruct(page, 'advancing-front');
  assert.deepEqual(page.complaints, []);
  await page.context().close();
});

test('a job that is cancelled while it is handed over is not left to run', async () => {
  const page = await openPage(browser, server.base);
  await dropFile(page, 'sphere.ply', spheres);
  const submission = await hold(page, '**/v1/jobs', 'POST', true);
  await page.click('#run');
  await submission.came;
  await page.waitForSelector('.card.work[data-what="submit"]');
  await page.click('#cancel');
  await submission.release();
  for (let i = 0; i < 600 && (await jobs())[0].status !== 'dismissed'; i += 1) await page.waitForTimeout(100);
  assert.equal((await jobs())[0].status, 'dismissed');
  await quiet(page);
  assert.match(await text(page), /Cancelled/);

  let tries = 0;
  await page.unrouteAll();
  await page.route('**/v1/jobs', (route) => {
    if (route.request().method() !== 'POST') return route.continue();
    tries += 1;
    return route.abort('connectionrefused');
  });
  await Promise.all([page.waitForEvent('requestfailed'), page.click('#run')]);
  await page.click('#cancel');
  await page.waitForTimeout(1200);
  assert.equal(tries, 1, 'it is not tried again');
  await quiet(page);
  await page.context().close();
});

test('a mesh that comes late does not appear, nor does a sample', async () => {
  const page = await openPage(browser, server.base);
  await dropFile(page, 'knot.ply', knot);
  await page.selectOption('#method', 'advancing-front');
  for (const leave of [() => page.click('#cancel'), () => dropFile(page, 'other.ply', ply(spherePoints(500)))]) {
    const mesh = await hold(page, '**/outputs/mesh.glb', 'GET', true);
    await page.click('#run');
    await mesh.came;
    await page.waitForSelector('.card.work[data-what="load"]');
    await leave();
    await mesh.release();
    await quiet(page);
    assert.equal(await page.locator('.headline').count(), 0);
    await page.unrouteAll();
  }
  const sample = await hold(page, '**/samples/knot.ply', 'GET', true);
  await page.click('.chip:has-text("knot")');
  await sample.came;
  await dropFile(page, 'later.ply', ply(spherePoints(600)));
  await sample.release();
  await quiet(page);
  assert.equal(await page.textContent('#setup .name'), 'later.ply');
  assert.deepEqual(page.complaints, []);
  await page.context().close();
});

test('of two jobs that are opened one after the other, the last one is shown', async () => {
  const page = await openPage(browser, server.base);
  await dropFile(page, 'knot.ply', knot);
  await reconstruct(page, 'advancing-front');
  const first = new URL(page.url()).searchParams.get('job');
  await dropFile(page, 'sphere.ply', ply(spherePoints(800)));
  await reconstruct(page, 'advancing-front');
  const second = new URL(page.url()).searchParams.get('job');
  const headline = () => page.textContent('.headline .number');
  const expected = await headline();
  await page.click('summary:has-text("Jobs on this server")');
  const open = (id) => page.click(`.history button[aria-label^="Open"][aria-label$="${id.slice(0, 6)}"]`);
  const slow = await hold(page, `**/v1/jobs/${first}`, 'GET', true);
  await open(first);
  await slow.came;
  await open(second);
  await slow.release();
  await quiet(page);
  assert.equal(await headline(), expected);
  assert.equal(new URL(page.url()).searchParams.get('job'), second);
  await page.context().close();
});

test('what is no longer shown is let go of', async () => {
  const context = await browser.newContext();
  context.setDefaultTimeout(patience);
  await context.addInitScript(() => {
    window.asked = {};
    const post = Worker.prototype.postMessage;
    Worker.prototype.postMessage = function count(question, ...more) {
      window.asked[question.call] = (window.asked[question.call] ?? 0) + 1;
      return post.call(this, question, ...more);
    };
  });
  const page = await context.newPage();
  await page.goto(server.base);
  await page.waitForSelector('#method option', {state: 'attached'});
  for (let i = 1; i <= 4; i += 1) await dropFile(page, `${i}.ply`, ply(spherePoints(1000 * i)));
  await page.waitForFunction(() => document.querySelectorAll('.facts dd')[2]?.textContent === '4,000');
  const held = () =>
      page.evaluate(() => (window.asked.loadCloud ?? 0) + (window.asked.loadMesh ?? 0) - (window.asked.forget ?? 0));
  assert.equal(await held(), 1, 'one cloud');
  // Its points are on the server alone: another page has sent them.
  const [{id}] = (await jobs()).filter((job) => job.status === 'successful');
  await page.click('summary:has-text("Jobs on this server")');
  await page.click(`.history button[aria-label^="Open"][aria-label$="${id.slice(0, 6)}"]`);
  await page.waitForSelector('.headline');
  assert.equal(await held(), 1, 'one mesh');
  await context.close();
});
