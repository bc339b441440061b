// SPDX-License-Identifier: GPL-3.0-or-later
// How the daemon serves the page: no browser needed.
import assert from 'node:assert/strict';
import http from 'node:http';
import {test} from 'node:test';
import {gunzipSync} from 'node:zlib';

import {knot, serveAndBrowse, server} from './support.mjs';

serveAndBrowse();

/** As it comes over the wire. */
function get(target, headers = {}) {
  return new Promise((resolve, reject) => {
    http.get(server.base + target, {headers}, (response) => {
          const parts = [];
          response.on('data', (part) => parts.push(part))
              .on('end',
                  () => resolve({status: response.statusCode, headers: response.headers, body: Buffer.concat(parts)}));
        }).on('error', reject);
  });
}

const asBrowser = {
  accept: 'text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8',
  'accept-encoding': 'gzip, deflate, br'
};

test('a browser gets the page at the root, curl and clients of JSON the links', async () => {
  const page = await get('/', asBrowser);
  assert.equal(page.headers['content-type'], 'text/html; charset=utf-8');
  assert.match(page.headers.vary, /Accept, Accept-Encoding/);
  assert.match(page.headers['content-security-policy'], /default-src 'none'.*frame-ancestors 'none'/);
  assert.equal(page.headers['cache-control'], 'no-cache');
  assert.equal((await get('/', {...asBrowser, 'if-none-match': page.headers.etag})).status, 304);
  for (const headers
           of [{}, {accept: '*/*'}, {accept: 'application/json'}, {accept: 'text/html;q=0.5, application/json'}]) {
    const links = await get('/', headers);
    assert.equal(links.headers['content-type'], 'application/json');
    assert.equal(JSON.parse(links.body.toString()).name, 'surfaced');
  }
});

test('what the page needs is served compressed, and for ever; its sizes are bounded', async () => {
  const html = gunzipSync((await get('/', asBrowser)).body).toString();
  const names = [...html.matchAll(/(?:src|href)="\.\/(assets\/[^"]+)"/g)].map((found) => `/${found[1]}`);
  assert.ok(names.length >= 3, html);
  let bundle = 0;
  for (const name of names) {
    const packed = await get(name, asBrowser);
    const plain = await get(name);
    assert.equal(packed.status, 200);
    assert.match(packed.headers['cache-control'], /immutable/);
    assert.match(packed.headers['content-type'], /^(text\/javascript|text\/css|image\/svg\+xml)/);
    const unpacked = packed.headers['content-encoding'] === 'gzip' ? gunzipSync(packed.body) : packed.body;
    assert.ok(unpacked.equals(plain.body), `${name}: both forms are the same`);
    assert.notEqual(
        packed.headers['content-encoding'] && packed.headers.etag, plain.headers.etag, 'but not under the same tag');
    assert.equal((await get(name, {...asBrowser, 'if-none-match': packed.headers.etag})).status, 304);
    assert.equal((await get(name, {'accept-encoding': 'gzip;q=0'})).headers['content-encoding'], undefined);
    bundle += packed.body.length;
    const worker = /assets\/geometry_worker-[\w-]+\.js|geometry_worker-[\w-]+\.js/.exec(unpacked.toString());
    if (worker) bundle += (await get(`/assets/${worker[0].split('/').at(-1)}`, asBrowser)).body.length;
  }
  assert.ok(bundle > 100e3 && bundle < 350 * 1024, `${bundle} bytes gzipped`);
});

test('samples, licences, and nothing beside them', async () => {
  const {samples} = JSON.parse((await get('/samples')).body.toString());
  for (const sample of samples) {
    const {body, headers} = await get(`/samples/${sample.name}`);
    assert.equal(headers['content-type'], 'application/octet-stream');
    assert.match(body.toString('latin1', 0, 400), new RegExp(`^ply\\n[^]*element vertex ${sample.points}\\n`));
    if (sample.name === 'knot.ply') assert.ok(body.equals(knot));
  }
  const licenses = (await get('/licenses')).body.toString();
  for (const text
           of ['three.js', 'Draco', 'tus-js-client', 'CGAL', 'GNU GENERAL PUBLIC LICENSE', 'Apache License',
               'id="source"'])
    assert.ok(licenses.includes(text), text);
  for (const target
           of ['/samples/none.ply', '/assets/none.js', '/samples/..%2Fassets', '/assets/..%2Findex.html',
               '/index.html'])
    assert.equal((await get(target)).status, 404, target);
});
