// SPDX-License-Identifier: GPL-3.0-or-later
// The picture of the viewer in the README: a sample, reconstructed, in a headless browser.
//
// usage: viewer.mjs BINARY OUTPUT.png       needs `npm ci` in tests/viewer, which ./dev test does, and Chromium
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const [binary, output] = process.argv.slice(2);
process.env.SURFACED_SOURCE = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
process.env.SURFACED_BIN = path.resolve(binary);
const { openPage, reconstruct, settled, startBrowser, startServer } = await import('../../tests/viewer/support.mjs');

const [server, browser] = await Promise.all([startServer(), startBrowser()]);
try {
  const page = await openPage(browser, server.base, { viewport: { width: 1120, height: 640 }, colorScheme: 'light' });
  await page.click('[data-sample="wheel.ply"]');
  await reconstruct(page);
  await settled(page);
  await page.screenshot({ path: output });
} finally {
  await browser.close();
  await server.stop();
}
