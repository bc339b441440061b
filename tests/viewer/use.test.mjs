// SPDX-License-Identifier: GPL-3.0-or-later
// What a user expects of a page: links and Back, own colours, errors where one looks, several files, another language.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {test} from 'node:test';

import {browser, dropFile, knot, openPage, ply, pointsShown, reconstruct, sampleFile, serveAndBrowse, server, silhouette, spherePoints} from './support.mjs';

serveAndBrowse();

const words = async (page) =>
    (await page.$$eval('.words li', (items) => items.map((item) => item.textContent))).join('\n');
const transfer = (page, files) => page.evaluateHandle((given) => {
  const data = new DataTransfer();
  for (const [name, text] of given) data.items.add(new File([text], name));
  return data;
}, files);

test(
    'a link tells one story: the form says what the job did, on every device, and Back leads to the result before',
    async () => {
      const page = await openPage(browser, server.base);
      await dropFile(page, 'knot.ply', knot);
      await reconstruct(page, 'advancing-front');
      await page.selectOption('#method', 'local-delaunay');
      await page.$eval('#parameter-neighbours', (input) => {
        input.value = '14';
        input.dispatchEvent(new Event('change', {bubbles: true}));
      });
      await reconstruct(page);
      assert.match(await page.title(), /knot\.ply · Local Delaunay.* · surfaced/);
      const form = async (tab) =>
          [await tab.$eval('#method', (select) => select.value),
           await tab.$eval('#parameter-neighbours', (input) => input.value)];
      const link = page.url();
      const guest = await openPage(browser, link);
      await guest.waitForSelector('.headline');
      assert.deepEqual(await form(guest), ['local-delaunay', '14']);
      assert.equal(await guest.textContent('#setup .name'), 'knot.ply', 'its name goes with the job');
      assert.match(await guest.textContent('.facts'), /6,000/, 'what the server knows of its points');
      assert.doesNotMatch(await guest.textContent('#setup .note'), /may know it/);
      await guest.context().close();
      await page.goBack();
      await page.waitForFunction(() => document.querySelector('.headline h2')?.textContent.includes('Advancing'));
      assert.equal(await page.$eval('#method', (select) => select.value), 'advancing-front');
      await page.goForward();
      await page.waitForFunction(() => document.querySelector('.headline h2')?.textContent.includes('Local'));
      assert.deepEqual(await form(page), ['local-delaunay', '14']);
      assert.deepEqual(page.complaints, []);
      await page.context().close();
    });

test('a coloured scan has its own colours, as points and as a mesh', async () => {
  const page = await openPage(browser, server.base);
  const rows = spherePoints(1500).map((p) => `${p.join(' ')} 190 40 30`).join('\n');
  const properties = ['float x', 'float y', 'float z', 'uchar red', 'uchar green', 'uchar blue']
                         .map((each) => `property ${each}\n`)
                         .join('');
  await dropFile(
      page, 'red.ply', Buffer.from(`ply\nformat ascii 1.0\nelement vertex 1500\n${properties}end_header\n${rows}\n`));
  await pointsShown(page);
  assert.match(await page.textContent('.attributes'), /colours/);
  const red = ({mean: [r, g, b]}) => r > 1.8 * g && r > 1.8 * b;
  assert.ok(red(await silhouette(page)), JSON.stringify(await silhouette(page)));
  await reconstruct(page, 'minimum-boundary');
  assert.ok(red(await silhouette(page)), JSON.stringify(await silhouette(page)));
  await page.selectOption('#colour', 'none');
  assert.ok(!red(await silhouette(page)));
  await page.selectOption('#colour', 'height');
  await page.waitForSelector('.legend');
  assert.deepEqual(page.complaints, []);
  await page.context().close();
});

test('a method that makes points of its own marks none, and says so; points alone are shaded by depth', async () => {
  const page = await openPage(browser, server.base);
  await dropFile(page, 'sphere.ply', ply(spherePoints(3000)));
  await pointsShown(page);
  const shade = async (on) => {
    if ((await page.getAttribute('[data-look="shade"]', 'aria-pressed')) !== String(on))
      await page.click('[data-look="shade"]');
    return silhouette(page);
  };
  const [plain, shaded] = [await shade(false), await shade(true)];
  assert.ok(shaded.mean[2] < plain.mean[2] - 3, `${shaded.mean} is darker than ${plain.mean}`);
  await reconstruct(page, 'poisson');
  const {mean: [r, , b]} = await silhouette(page);
  assert.ok(r < b + 12, `no orange over the mesh: ${r} ${b}`);
  assert.match(await words(page), /vertices are new points/);
  assert.doesNotMatch(await words(page), /no vertex|1\.0e/);
  await page.context().close();
});

test('a terrain starts with z up, and there is one up: of the picture, of the form, of the job', async () => {
  const page = await openPage(browser, server.base);
  await page.focus('[data-sample="hills.ply"]');
  await page.keyboard.press('Enter');
  await pointsShown(page);
  assert.equal(
      await page.evaluate(() => document.activeElement?.id), 'run',
      'the invitation is gone, the next step has the focus');
  const ups = async () => [await page.textContent('#up'), await page.$eval('#parameter-up', (select) => select.value)];
  await page.waitForFunction(() => document.querySelector('#up').textContent === 'z up');
  assert.deepEqual(await ups(), ['z up', 'z']);
  assert.equal(await page.$eval('#method', (select) => select.value), 'local-delaunay', 'a sample brings its method');
  await reconstruct(page);
  const job = await (await fetch(`${server.base}/v1/jobs/${new URL(page.url()).searchParams.get('job')}`)).json();
  assert.equal(job.parameters.up, 'z');
  await page.click('#up');
  assert.deepEqual(await ups(), ['y up', 'y']);
  await dropFile(page, 'knot.ply', knot);
  assert.deepEqual(await ups(), ['y up', 'y']);
  await page.context().close();
});

test('an error stands in the middle of the picture, and the field that is wrong is marked and in view', async () => {
  const page = await openPage(browser, server.base);
  await dropFile(page, 'empty.ply', Buffer.alloc(0));
  assert.match(await page.textContent('#setup .note'), /file is empty/);
  await page.click('#run');
  await page.waitForSelector('.card.error[data-code="empty_input"]');
  await dropFile(page, 'knot.ply', knot);
  await page.selectOption('#method', 'local-delaunay');
  await page.route('**/v1/jobs', (route) => (route.request().method() !== 'POST' ? route.continue() : route.fulfill({
                                   status: 400,
                                   contentType: 'application/problem+json',
                                   body: JSON.stringify({
                                     type: 'urn:surfaced:error:invalid_parameter',
                                     title: 'A parameter has a value that is not allowed',
                                     status: 400,
                                     code: 'invalid_parameter',
                                     detail: 'neighbours is 3',
                                     hint: 'GET /v1/methods/{id} gives the ranges',
                                     field: 'neighbours',
                                     request_id: 'r'
                                   })
                                 })));
  await page.click('#run');
  const card = await (await page.waitForSelector('.card.error')).boundingBox();
  const view = await page.locator('#view').boundingBox();
  assert.ok(
      Math.abs(card.x + card.width / 2 - view.x - view.width / 2) < 4 && card.y > view.y + view.height / 4 &&
          card.y + card.height < view.y + 0.75 * view.height,
      JSON.stringify([card, view]));
  assert.doesNotMatch(await page.textContent('.card.error'), /GET \/v1/, 'no words for machines');
  assert.equal(await page.getAttribute('#parameter-neighbours', 'aria-invalid'), 'true');
  const field = await page.locator('#parameter-neighbours').boundingBox();
  assert.ok(field.y > 0 && field.y + field.height < 800, JSON.stringify(field));
  await page.context().close();
});

test('several files that are dropped become a job each; the list shows, finds and deletes them', async () => {
  const page = await openPage(browser, server.base);
  const spheres = ['one.ply', 'two.ply'].map((name, i) => [name, ply(spherePoints(300 + i)).toString()]);
  const corner = async () => (await page.screenshot({clip: {x: 330, y: 60, width: 4, height: 4}})).toString('base64');
  const before = await corner();
  const data = await transfer(page, spheres);
  await page.dispatchEvent('body', 'dragover', {dataTransfer: data});
  assert.notEqual(await corner(), before, 'where it may be dropped is seen');
  await page.dispatchEvent('body', 'drop', {dataTransfer: data});
  await page.selectOption('#method', 'advancing-front');
  await page.click('#run-all');
  await page.waitForFunction(() => /2 jobs queued/.test(document.querySelector('#work').textContent));
  await page.click('summary:has-text("Jobs on this server")');
  const card = (name) => page.locator('.history li', {hasText: name}).first();
  await card('two.ply').getByRole('button', {name: /^Open/}).click();
  await page.waitForSelector('.headline');
  assert.equal(await page.textContent('#setup .name'), 'two.ply');
  await page.waitForFunction(() => (document.querySelector('.history li.shown img')?.naturalWidth ?? 0) > 60);
  await page.fill('.search', 'one.ply advancing').catch(() => undefined);
  const remove = card('one.ply').getByRole('button', {name: /Delete|delete/});
  await card('one.ply').locator('.dot.successful').waitFor();
  await remove.click();
  await remove.click();
  await card('one.ply').waitFor({state: 'detached'});
  assert.deepEqual(page.complaints, []);
  await page.context().close();
});

test('the page speaks German where the browser does, and English where it is asked to', async () => {
  const page = await openPage(browser, server.base, {locale: 'de-AT'});
  assert.equal(await page.getAttribute('html', 'lang'), 'de');
  assert.equal(await page.textContent('#run'), 'Rekonstruieren');
  await page.click('[data-sample="knot.ply"]');
  await pointsShown(page);
  assert.equal(await page.$eval('.facts', (list) => list.querySelectorAll('dd')[2].textContent), '6.000');
  await reconstruct(page);
  assert.match(await words(page), /Wasserdicht[^]*Jeder der 6\.000 verschiedenen Punkte/);
  await Promise.all([page.waitForNavigation(), page.selectOption('#language', 'en')]);
  await page.waitForSelector('.headline');
  assert.equal(await page.getAttribute('html', 'lang'), 'en');
  assert.match(await words(page), /Watertight/);
  await page.context().close();
});

test('a comparison brings the files and the reports of both', async () => {
  const page = await openPage(browser, server.base);
  await dropFile(page, 'hills.ply', readFileSync(sampleFile('hills.ply')));
  await reconstruct(page, 'advancing-front');
  await page.selectOption('#method', 'local-delaunay');
  await page.click('#beside');
  await page.waitForSelector('.comparison');
  assert.equal(
      new Set(await page.$$eval('[data-output="mesh.glb"]', (buttons) => buttons.map((button) => button.dataset.job)))
          .size,
      2);
  assert.equal(await page.locator('#results .words').count(), 2);
  const [second] =
      await Promise.all([page.waitForEvent('download'), page.locator('[data-output="report.json"]').nth(1).click()]);
  assert.equal(JSON.parse(readFileSync(await second.path())).method, 'local-delaunay');
  await page.context().close();
});
