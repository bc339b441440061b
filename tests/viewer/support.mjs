// SPDX-License-Identifier: GPL-3.0-or-later
// A running server, a real browser, and eyes for what the canvas shows.
import {spawn} from 'node:child_process';
import {mkdtempSync, readFileSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import path from 'node:path';
import {createInterface} from 'node:readline';
import {after, before} from 'node:test';
import {chromium} from 'playwright-core';

export const source = process.env.SURFACED_SOURCE;
export const sampleFile = (name) => path.join(source, 'client-examples/samples', name);
export const knot = readFileSync(sampleFile('knot.ply'));

/** Starts the daemon; `data` and `listen` let it come back as it was. */
export async function startServer(
    flags = [], data = mkdtempSync(path.join(tmpdir(), 'surfaced-viewer-')), listen = '127.0.0.1:0') {
  const child = spawn(
      process.env.SURFACED_BIN, ['serve', '--listen', listen, '--data', data, '--log-level', 'warning', ...flags],
      {stdio: ['ignore', 'pipe', 'inherit']});
  const base = await new Promise((resolve, reject) => {
    child.once('exit', (code) => reject(new Error(`the server ended with ${code}`)));
    createInterface({input: child.stdout}).on('line', (line) => {
      const found = /http:\/\/\S+/.exec(line);
      if (found) resolve(found[0].replace(/\/$/, ''));
    });
  });
  const end = async (signal) => {
    const ended = new Promise((resolve) => child.once('exit', resolve));
    child.kill(signal);
    await ended;
  };
  const stop = async () => {
    await end('SIGTERM');
    rmSync(data, {recursive: true, force: true});
  };
  return {base, data, stop, kill: () => end('SIGKILL')};
}

/** A wait ends with what it waits for; so long it takes only where that never comes. */
export const patience = 120_000;

/** Debian's Chromium, drawing in software. */
export function startBrowser(flags = ['--use-angle=swiftshader', '--enable-unsafe-swiftshader']) {
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    timeout: patience,
    args: [
      '--no-sandbox', '--disable-background-networking', '--disable-component-update', '--disable-sync',
      '--disable-quic', '--no-first-run', ...flags
    ],
  });
}

export let server;
export let browser;
let shared = false;
/** One server and one browser for all tests of a process, whatever their files. */
export function serveAndBrowse() {
  if (shared) return;
  shared = true;
  before(async () => {
    [server, browser] = await Promise.all([startServer(), startBrowser()]);
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });
}

/** A page that fails the test by whatever it says on its console. */
export async function openPage(browser, url, options = {}) {
  const context = await browser.newContext(
      {viewport: {width: 1280, height: 800}, acceptDownloads: true, reducedMotion: 'reduce', ...options});
  context.setDefaultTimeout(patience);
  const page = await context.newPage();
  page.complaints = [];
  page.on('pageerror', (error) => page.complaints.push(error.message));
  page.on('console', (message) => {
    // What the network refuses is told by the page itself.
    if (['error', 'warning'].includes(message.type()) &&
        !/Failed to load resource|GPU stall|GL Driver/.test(message.text()))
      page.complaints.push(message.text());
  });
  page.requests = [];
  page.on('request', (request) => page.requests.push(request.url()));
  await page.goto(url);
  await page.waitForSelector('#method option', {state: 'attached'});
  return page;
}

/** Drops a file on the page, as from a desktop. */
export async function dropFile(page, name, bytes) {
  const transfer = await page.evaluateHandle(({name, base64}) => {
    const data = new DataTransfer();
    data.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name));
    return data;
  }, {name, base64: Buffer.from(bytes).toString('base64')});
  await page.dispatchEvent('body', 'drop', {dataTransfer: transfer});
  await page.waitForFunction((name) => document.querySelector('#setup .name')?.textContent === name, name);
}

/** Waits until the points are there. */
export const pointsShown = (page) => page.waitForFunction(() => document.querySelectorAll('.facts dd').length === 4);

/** Waits for the mesh, and not for one that is there already. */
export async function reconstruct(page, method) {
  if (method) await page.selectOption('#method', method);
  await page.evaluate(() => document.querySelector('.headline')?.classList.replace('headline', 'earlier'));
  await page.click('#run');
  await page.waitForSelector('.headline');
}

export const facts = (page) => page.$$eval('.facts dd', (items) => items.map((item) => item.textContent));

/** Waits until everything is drawn: what moved has come to rest, and large meshes are whole again. */
export const settled = (page) => page.evaluate(() => new Promise((resolve) => {
                                                 const stage = window.surfacedStage;
                                                 let still = 0;
                                                 const next = () => {
                                                   still = stage.busy ? 0 : still + 1;
                                                   if (still > 2)
                                                     resolve();
                                                   else
                                                     requestAnimationFrame(next);
                                                 };
                                                 stage.draw();
                                                 next();
                                               }));

/**
 * What of the picture is not background: its share, its box, and the share of its box that it fills, its mean colour.
 */
export async function silhouette(page, clip) {
  await settled(page);
  // What lies over the canvas is no part of the picture, nor is the frame of what has the focus.
  await page.evaluate(() => {
    document.querySelector('#canvas').style.outline = 'none';
    for (const part of document.querySelectorAll('#overlay, #message, .toolbar, .tools, .compass'))
      part.style.visibility = 'hidden';
  });
  await page.locator('#canvas').scrollIntoViewIfNeeded();
  const box = await page.locator('#canvas').boundingBox();
  const png = await page.screenshot({clip: clip ? clip(box) : box});
  await page.evaluate(() => {
    for (const part of document.querySelectorAll('#overlay, #message, .toolbar, .tools, .compass'))
      part.style.visibility = '';
  });
  return page.evaluate(async (base64) => {
    const image = new Image();
    image.src = `data:image/png;base64,${base64}`;
    await image.decode();
    const canvas = document.createElement('canvas');
    canvas.width = image.width;
    canvas.height = image.height;
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const {data, width, height} = context.getImageData(0, 0, image.width, image.height);
    let [count, left, right, top, bottom] = [0, width, 0, height, 0];
    const colours = new Set();
    const sums = [0, 0, 0];
    for (let y = 2; y < height - 2; y += 1) {
      for (let x = 2; x < width - 2; x += 1) {
        const at = 4 * (y * width + x);
        if ([0, 1, 2].every((k) => Math.abs(data[at + k] - data[4 * (2 * width + 2) + k]) < 10)) continue;
        count += 1;
        for (let k = 0; k < 3; k += 1) sums[k] += data[at + k];
        left = Math.min(left, x);
        right = Math.max(right, x);
        top = Math.min(top, y);
        bottom = Math.max(bottom, y);
        colours.add((data[at] >> 4 << 8) | (data[at + 1] >> 4 << 4) | (data[at + 2] >> 4));
      }
    }
    const [w, h] = [right - left + 1, bottom - top + 1];
    return {
      share: count / (width * height),
      width: w,
      height: h,
      fill: count / (w * h),
      colours: colours.size,
      mean: sums.map((sum) => Math.round(sum / Math.max(1, count))),
      picture: [width, height]
    };
  }, png.toString('base64'));
}

/** Points on a sphere. */
export function spherePoints(count, radius = 1) {
  return Array.from({length: count}, (_, i) => {
    const z = 1 - (2 * i + 1) / count;
    const angle = i * Math.PI * (3 - Math.sqrt(5));
    const r = Math.sqrt(1 - z * z);
    return [radius * r * Math.cos(angle), radius * r * Math.sin(angle), radius * z].map((value) => Math.fround(value));
  });
}

export function ply(points) {
  return Buffer.from(`ply\nformat ascii 1.0\nelement vertex ${
      points.length}\nproperty float x\nproperty float y\nproperty float z\nend_header\n${
      points.map((p) => p.join(' ')).join('\n')}\n`);
}
