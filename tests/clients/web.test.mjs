// SPDX-License-Identifier: GPL-3.0-or-later
// The web example in a real browser: a page of another origin uploads a cloud and shows the mesh.
import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { chromium } from 'playwright-core';
import { source, startServer } from '../contract/support.mjs';

const browser_path = process.env.CHROMIUM ?? '/usr/bin/chromium';
const skip = existsSync(browser_path) ? false : `${browser_path} is not installed`;
const types = { html: 'text/html', js: 'text/javascript' };
let pages, server, browser;

before(async () => {
  if (skip) return;
  pages = http.createServer((request, response) => {
    const file = path.join(source, 'client-examples/web', path.normalize(new URL(request.url, 'http://x').pathname));
    if (!existsSync(file)) return response.writeHead(404).end();
    const bytes = readFileSync(file, 'utf8').replace('name="surfaced-server" content=""', `name="surfaced-server" content="${server.base}"`);
    response.writeHead(200, { 'content-type': types[path.extname(file).slice(1)] }).end(bytes);
  });
  await new Promise((resolve) => pages.listen(0, '127.0.0.1', resolve));
  pages.url = `http://127.0.0.1:${pages.address().port}`;
  server = await startServer(['--cors-origins', pages.url]);
  browser = await chromium.launch({
    timeout: 120000,
    executablePath: browser_path,
    args: ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update',
      '--disable-sync', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });
});
after(async () => {
  await browser?.close();
  await server?.stop();
  pages?.closeAllConnections();
  pages?.close();
});

/** Opens the page; the share of pixels of its view that are not background. */
async function open(target) {
  const page = await browser.newPage({ viewport: { width: 640, height: 480 } });
  page.setDefaultTimeout(120000);
  const wrong = [];
  page.on('pageerror', (error) => wrong.push(error.message));
  await page.goto(`${pages.url}/index.html${target}`);
  return { page, wrong };
}

test('a page of another origin uploads a cloud, follows the job and shows the mesh; its address embeds the result', { skip, timeout: 600000 }, async () => {
  const { page, wrong } = await open('');
  await page.setInputFiles('#cloud', path.join(source, 'client-examples/samples/knot.ply'));
  await page.getByText('12000 triangles, genus 1, closed').waitFor({ timeout: 120000 });
  const job = new URL(page.url()).hash;
  assert.match(job, /^#[0-9a-f]{32}$/);
  assert.deepEqual(wrong, []);

  const again = await open(job);
  await again.page.getByText('12000 triangles').waitFor({ timeout: 120000 });
  const shown = await again.page.locator('canvas').screenshot();
  assert.ok(shown.length > 8000, `a mesh is on the canvas; its picture has ${shown.length} bytes`);
  assert.deepEqual(again.wrong, []);
});

test('the page says what is wrong with a cloud', { skip, timeout: 600000 }, async () => {
  const { page } = await open('');
  await page.setInputFiles('#cloud', path.join(source, 'LICENSE'));
  await page.getByText('no table of points').waitFor({ timeout: 120000 });
});
