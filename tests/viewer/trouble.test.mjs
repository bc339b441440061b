// SPDX-License-Identifier: GPL-3.0-or-later
// Bad input and bad luck: each shows what happened, in the words of the server, and what to do.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {mkdtempSync, rmSync} from 'node:fs';
import net from 'node:net';
import {tmpdir} from 'node:os';
import path from 'node:path';
import {after, before, test} from 'node:test';

import {dropFile, knot, openPage, ply, reconstruct, spherePoints, startBrowser, startServer} from './support.mjs';

let browser;
const servers = [];
const start = async (...words) => {
  const server = await startServer(...words);
  servers.push(server);
  return server;
};
before(async () => {
  browser = await startBrowser();
});
after(async () => {
  await browser?.close();
  await Promise.all(servers.map((server) => server.stop()));
});

async function errorOf(page) {
  await page.waitForSelector('.card.error');
  return {code: await page.getAttribute('.card.error', 'data-code'), text: await page.textContent('.card.error')};
}

test(
    'a file that is no cloud, one that has no surface and one that is too big are refused in the words of the API',
    async () => {
      const server = await start(['--body-limit', '200000']);
      const page = await openPage(browser, server.base);
      await dropFile(page, 'letter.txt', Buffer.from('Dear all,\nthis is no cloud.\n'));
      await page.waitForSelector('#setup .panel:first-child .note');
      await page.click('#run');
      const none = await errorOf(page);
      assert.equal(none.code, 'unknown_format');
      assert.match(none.text, /told by their content/, 'the hint');
      await dropFile(page, 'line.ply', ply([[0, 0, 0], [1, 1, 1], [2, 2, 2], [3, 3, 3], [4, 4, 4]]));
      assert.equal(await page.locator('.card.error').count(), 0, 'a new file clears the old error');
      await page.click('#run');
      assert.equal((await errorOf(page)).code, 'collinear');
      await dropFile(page, 'big.ply', ply(spherePoints(9000)));
      await page.click('#run');
      const big = await errorOf(page);
      assert.equal(big.code, 'payload_too_large');
      assert.match(big.text, /200000/, 'the limit');
      assert.ok(await page.isEnabled('#run'));
      await page.context().close();
    });

/** Passes bytes through, but cuts the first connection that sends much. */
function cuttingProxy(target, bytes) {
  let cut = false;
  const proxy = net.createServer((client) => {
    const upstream = net.connect(Number(target.port), target.hostname);
    let sent = 0;
    client.on('data', (part) => {
      if (!cut && sent + part.length > bytes) {
        cut = true;
        client.pause();
        upstream.write(
            part.subarray(0, bytes - sent),
            () => setTimeout(() => [client, upstream].forEach((socket) => socket.destroy()), 100));
        return;
      }
      sent += part.length;
      upstream.write(part);
    });
    upstream.on('data', (part) => client.write(part));
    for (const [one, other] of [[client, upstream], [upstream, client]])
      one.on('close', () => other.destroy()).on('error', () => other.destroy());
  });
  return new Promise(
      (resolve) => proxy.listen(
          0, '127.0.0.1', () => resolve({proxy, url: `http://127.0.0.1:${proxy.address().port}`, wasCut: () => cut})));
}

test('an upload whose connection is lost goes on where it broke off', async () => {
  const server = await start();
  const {proxy, url, wasCut} = await cuttingProxy(new URL(server.base), 60_000);
  const page = await openPage(browser, url);
  const offsets = [];
  page.on('response', (response) => {
    if (response.request().method() === 'HEAD') offsets.push(Number(response.headers()['upload-offset']));
  });
  await dropFile(page, 'knot.ply', knot);
  await reconstruct(page, 'advancing-front');
  assert.ok(wasCut());
  assert.ok(offsets.some((offset) => offset > 0 && offset < knot.length), `taken up at ${offsets} of ${knot.length}`);
  await page.context().close();
  proxy.close();
});

test('a server that is killed and comes back finishes the job under the same page', async () => {
  const first = await startServer();
  const listen = new URL(first.base).host;
  const page = await openPage(browser, first.base);
  await dropFile(page, 'sphere.ply', ply(spherePoints(20000)));
  // However fast the job is, the page hears nothing of its end before the server is gone.
  let killed;
  const gone = new Promise((resolve) => {
    killed = resolve;
  });
  await page.route('**/events', async (route) => {
    await gone;
    await route.continue();
  });
  await page.click('#run');
  await page.waitForSelector('.card.work[data-what="run"], .card.work[data-what="queue"]');
  await first.kill();
  killed();
  await page.waitForFunction(
      () => /connection to the server was lost/.test(document.querySelector('#work').textContent));
  // Somebody else may have taken its port meanwhile, and give it back.
  let again;
  for (let i = 0; i < 30 && !again; i += 1) {
    again = await startServer([], first.data, listen).catch(() => undefined);
    if (!again) await page.waitForTimeout(1000);
  }
  servers.push(again);
  await page.waitForSelector('.headline');
  await page.context().close();
});

test('a server that is gone is said to be gone', async () => {
  const server = await startServer();
  const page = await openPage(browser, server.base);
  await dropFile(page, 'knot.ply', knot);
  await server.stop();
  await page.route('**/v1/uploads', (route) => route.abort('connectionrefused'));
  await page.evaluate(() => {
    window.setTimeout =
        ((real) => (task, wait, ...words) => real(task, Math.min(wait ?? 0, 30), ...words))(window.setTimeout);
  });
  await page.click('#run');
  const {code, text} = await errorOf(page);
  assert.equal(code, 'unreachable');
  assert.match(text, /go on where it broke off/);
  await page.context().close();
});

test('running work is cancelled by its button, and a failed job is tried again from the list', async () => {
  const server = await start(['--workers', '1']);
  const page = await openPage(browser, server.base);
  await dropFile(page, 'sphere.ply', ply(spherePoints(150000)));
  await page.click('#run');
  await page.waitForSelector('.card.work[data-what="run"]');
  await page.click('#cancel');
  await page.waitForFunction(() => document.querySelector('.history')?.textContent.includes('cancelled'));
  assert.ok(await page.isEnabled('#run'));
  const {jobs} = await (await fetch(`${server.base}/v1/jobs`)).json();
  assert.equal(jobs[0].status, 'dismissed');
  await page.click('summary:has-text("Jobs on this server")');
  await page.click('.history button:has-text("Try again")');
  await page.waitForSelector('.card.work');
  await page.click('#cancel');
  await page.context().close();
});

test('a parked job says that its attempts are used up; one that is gone says so', async () => {
  const server = await start();
  const page = await openPage(browser, server.base);
  await page.route('**/v1/jobs/parked0', (route) => route.fulfill({
    json: {
      id: 'parked0',
      method: 'minimum-boundary',
      parameters: {},
      status: 'failed',
      progress: 0,
      phase: null,
      queue_position: null,
      attempt: 2,
      attempts: [],
      parked: true,
      labels: [],
      cloud_id: null,
      created_at: '2026-01-01T00:00:00Z',
      started_at: null,
      finished_at: null,
      expires_at: null,
      links: [],
      error: {
        type: 'x',
        title: 'The process that did the work crashed',
        status: 422,
        detail: 'signal 11',
        code: 'crashed',
        hint: 'Please report it.',
        request_id: 'r'
      },
    }
  }));
  await page.goto(`${server.base}/?job=parked0`);
  const parked = await errorOf(page);
  assert.equal(parked.code, 'crashed');
  assert.match(parked.text, /Please report it\. Its attempts are used up/);
  await page.goto(`${server.base}/?job=00000000000000000000000000000000`);
  assert.equal((await errorOf(page)).code, 'job_not_found');
  await page.context().close();
});

test('a server with keys asks for one, and takes it', async () => {
  const folder = mkdtempSync(path.join(tmpdir(), 'surfaced-viewer-keys-'));
  const file = path.join(folder, 'keys.json');
  const key = execFileSync(process.env.SURFACED_BIN, ['keys', 'add', file, '--name', 'me'], {encoding: 'utf8'}).trim();
  const server = await start(['--keys', file]);
  const page = await openPage(browser, server.base);
  assert.equal((await errorOf(page)).code, 'unauthorized');
  await page.waitForSelector('dialog[open]');
  await page.fill('#key', key);
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => /key is accepted/.test(document.querySelector('#work').textContent));
  await dropFile(page, 'knot.ply', knot);
  await reconstruct(page, 'advancing-front');
  const link = page.url();
  await page.context().close();
  const guest = await openPage(browser, link);
  assert.equal((await errorOf(guest)).code, 'unauthorized');
  await guest.waitForSelector('dialog[open]');
  await guest.fill('#key', key);
  await guest.keyboard.press('Enter');
  await guest.waitForSelector('.headline');
  assert.equal(guest.url(), link);
  await guest.context().close();
  rmSync(folder, {recursive: true, force: true});
});

test('without WebGL everything works but the picture', async () => {
  const server = await start();
  const blind = await startBrowser(['--disable-3d-apis']);
  try {
    const page = await openPage(blind, server.base);
    const {code, text} = await errorOf(page);
    assert.equal(code, 'no_webgl');
    assert.match(text, /switch on WebGL/);
    await dropFile(page, 'knot.ply', knot);
    await reconstruct(page, 'advancing-front');
    assert.match(await page.textContent('.words'), /Watertight/);
  } finally {
    await blind.close();
  }
});
