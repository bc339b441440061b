// SPDX-License-Identifier: GPL-3.0-or-later
// Ten states of the viewer, in three widths, light and dark: what to look at after a change of the page.
//
// usage: viewer_states.mjs BINARY FOLDER [WIDTH...]       needs `npm ci` in tests/viewer, which ./dev test does, and Chromium
import {mkdirSync, readFileSync} from 'node:fs';
import path from 'node:path';
import {fileURLToPath} from 'node:url';

const [binary, folder, ...widths] = process.argv.slice(2);
const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
process.env.SURFACED_SOURCE = root;
process.env.SURFACED_BIN = path.resolve(binary);
const {dropFile, openPage, pointsShown, reconstruct, sampleFile, settled, startBrowser, startServer} =
    await import('../../tests/viewer/support.mjs');

const sample = async (page, name) => {
  await dropFile(page, name, readFileSync(sampleFile(name)));
  await pointsShown(page);
};
const meshOf = async (page, name, method) => {
  await sample(page, name);
  await reconstruct(page, method);
};
/** Each leads from the one before to its own. */
const states = {
  first: async () => undefined,
  points: (page) => sample(page, 'knot.ply'),
  mesh: (page) => reconstruct(page, 'minimum-boundary'),
  quality: (page) => page.selectOption('#colour', 'lR'),
  comparison: async (page) => {
    await page.selectOption('#method', 'local-delaunay');
    await page.click('#beside');
    await page.waitForSelector('.comparison');
  },
  coloured: (page) => meshOf(page, 'hills.ply', 'local-delaunay'),
  pick: async (page) => {
    await page.click('[data-tool="pick"]');
    const {width, height} = await page.locator('#canvas').boundingBox();
    await page.click('#canvas', {position: {x: width / 2, y: height / 2}});
  },
  crop: async (page) => {
    await sample(page, 'hills.ply');
    await page.click('[data-tool="crop"]');
  },
  jobs: async (page) => {
    await page.click('#setup details:has(.history) > summary');
    await page.locator('.history').scrollIntoViewIfNeeded();
  },
  error: async (page) => {
    await page.goto(new URL(`?job=${'0'.repeat(32)}`, page.url()).href);
    await page.waitForSelector('.card.error');
  },
};

mkdirSync(folder, {recursive: true});
const [server, browser] = await Promise.all([startServer(), startBrowser()]);
try {
  for (const width of widths.length > 0 ? widths.map(Number) : [390, 1280, 2560]) {
    for (const colorScheme of ['light', 'dark']) {
      const viewport = {width, height: width < 600 ? 844 : Math.round(width * 0.625)};
      const page = await openPage(browser, server.base, {viewport, colorScheme});
      for (const [name, reach] of Object.entries(states)) {
        await reach(page);
        await settled(page);
        await page.screenshot({path: path.join(folder, `${name}-${width}-${colorScheme}.png`)});
      }
      await page.context().close();
    }
  }
} finally {
  await browser.close();
  await server.stop();
}
