// SPDX-License-Identifier: GPL-3.0-or-later
// Keys: who may do what, whose is what, how often; and pages of other origins.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { Client, knot, sphere } from './client.mjs';

const folder = mkdtempSync(path.join(tmpdir(), 'surfaced-keys-'));
const file = path.join(folder, 'keys.json');
const surfaced = (...words) => execFileSync(process.env.SURFACED_BIN, words, { encoding: 'utf8' }).trim();
const makeKey = (name, ...flags) => surfaced('keys', 'add', file, '--name', name, ...flags);
const reader = makeKey('reader', '--scopes', 'read');
const alice = makeKey('alice');
const bob = makeKey('bob');
const admin = makeKey('admin', '--scopes', 'admin');
const scraper = makeKey('scraper', '--scopes', 'metrics');
const hasty = makeKey('hasty', '--requests-per-minute', '3');
const small = makeKey('small', '--stored-bytes', '1000');
const single = makeKey('single', '--active-jobs', '1');

let server;
before(async () => {
  server = await Client.start(['--keys', file, '--cors-origins', 'https://app.example']);
});
after(async () => {
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

const expect = async (status, code, answer) => {
  const { status: got, body } = await answer;
  assert.equal(`${got} ${body.code}`, `${status} ${code}`, body.detail);
};

test('without a known key only probes, methods and the contract are open', async () => {
  for (const target of ['/', '/healthz', '/readyz', '/openapi.json', '/docs', '/v1/methods', '/processes', '/conformance', '/samples', '/samples/knot.ply', '/licenses']) {
    assert.equal((await server.call('GET', target)).status, 200, target);
  }
  const refused = await server.call('GET', '/v1/jobs');
  assert.equal(refused.status, 401);
  assert.match(refused.headers.get('www-authenticate'), /^Bearer/);
  await expect(401, 'unauthorized', server.as(`${alice}0`).call('GET', '/v1/jobs'));
  await expect(401, 'unauthorized', server.post('/v1/jobs', knot));
});

test('a key is held to its scopes', async () => {
  assert.equal((await server.as(reader).call('GET', '/v1/jobs')).status, 200);
  await expect(403, 'forbidden', server.as(reader).post('/v1/jobs', knot));
  assert.equal((await server.as(scraper).call('GET', '/metrics')).status, 200);
  assert.equal((await server.as(admin).call('GET', '/metrics')).status, 200);
  for (const key of [reader, alice]) await expect(403, 'forbidden', server.as(key).call('GET', '/metrics'));
  await expect(401, 'unauthorized', server.call('GET', '/metrics'));
  for (const target of ['/v1/jobs', '/jobs']) await expect(403, 'forbidden', server.as(scraper).call('GET', target));
  await expect(403, 'forbidden', server.as(scraper).post('/v1/jobs', knot));
});

test('what belongs to another key does not exist', async () => {
  const created = await server.as(alice).post('/v1/jobs?method=advancing-front', knot);
  const target = `/v1/jobs/${created.body.id}`;
  assert.equal((await server.as(alice).call('GET', target)).status, 200);
  assert.equal((await server.as(admin).call('GET', target)).status, 200);
  for (const [method, path_] of [['GET', target], ['DELETE', target], ['POST', `${target}/retry`], ['GET', `${target}/events`],
    ['GET', `${target}/outputs/mesh.glb`], ['GET', `/jobs/${created.body.id}`], ['GET', `/jobs/${created.body.id}/results`]]) {
    await expect(404, 'job_not_found', server.as(bob).call(method, path_));
  }
  const cloud = await server.as(alice).post('/v1/clouds', knot);
  await expect(404, 'cloud_not_found', server.as(bob).call('GET', `/v1/clouds/${cloud.body.id}`));
  await expect(404, 'cloud_not_found', server.as(bob).json('/v1/jobs', { cloud_id: cloud.body.id }));
  assert.equal((await server.as(bob).post('/v1/clouds', knot)).status, 201, 'until he sends it himself');
  const tus = { 'tus-resumable': '1.0.0', 'upload-length': '10' };
  const upload = await server.as(alice).call('POST', '/v1/uploads', { headers: tus });
  await expect(404, 'upload_not_found', server.as(bob).call('GET', upload.headers.get('location')));
  const mine = (list) => list.body.jobs.some((job) => job.id === created.body.id);
  assert.ok(!mine(await server.as(bob).call('GET', '/v1/jobs')));
  assert.ok(mine(await server.as(alice).call('GET', '/v1/jobs')));
  assert.ok(mine(await server.as(admin).call('GET', '/v1/jobs')));
});

test('requests, jobs and bytes have their limits', async () => {
  const client = server.as(hasty);
  for (let i = 0; i < 3; ++i) assert.equal((await client.call('GET', '/v1/jobs')).status, 200);
  const slower = await client.call('GET', '/v1/jobs');
  assert.equal(`${slower.status} ${slower.body.code}`, '429 too_many_requests');
  assert.ok(Number(slower.headers.get('retry-after')) >= 1);
  await expect(429, 'quota_exceeded', server.as(small).post('/v1/clouds', knot));
  const first = await server.as(single).post('/v1/jobs?method=advancing-front', sphere(150000));
  assert.equal(first.status, 201);
  await server.freeze(first.body.id, single);
  await expect(429, 'quota_exceeded', server.as(single).post('/v1/jobs?method=advancing-front', sphere(50)));
  await server.as(single).call('DELETE', `/v1/jobs/${first.body.id}`);
});

test('a key that is taken away ends to work while the server runs', async () => {
  const key = makeKey('short');
  const works = async () => (await server.as(key).call('GET', '/v1/jobs')).status;
  await server.until(async () => ({ body: await works() }), (status) => status === 200);
  surfaced('keys', 'remove', file, key.split('_')[1]);
  await server.until(async () => ({ body: await works() }), (status) => status === 401);
});

test('pages of listed origins may call, others not', async () => {
  const ask = (origin) => fetch(`${server.base}/v1/jobs`, {
    method: 'OPTIONS',
    headers: { origin, 'access-control-request-method': 'POST', 'access-control-request-headers': 'authorization' },
  });
  const allowed = await ask('https://app.example');
  assert.equal(allowed.status, 204);
  assert.equal(allowed.headers.get('access-control-allow-origin'), 'https://app.example');
  assert.match(allowed.headers.get('access-control-allow-headers'), /Authorization/);
  assert.equal((await ask('https://evil.example')).headers.get('access-control-allow-origin'), null);
  const answer = await fetch(`${server.base}/healthz`, { headers: { origin: 'https://app.example' } });
  assert.match(answer.headers.get('access-control-expose-headers'), /Location.*ETag/);
  assert.match(answer.headers.get('vary'), /Origin/);
});

test('only a proxy that is trusted says who the client is', async () => {
  const ask = (client, forwarded) => client.call('GET', '/v1/jobs', { headers: { 'x-forwarded-for': forwarded } });
  const statuses = async (client, forwarded) => {
    const seen = [];
    for (let i = 0; i < 5; ++i) seen.push((await ask(client, forwarded)).status);
    return seen.join(' ');
  };
  const behind = await Client.start(['--rate-limit', '3', '--trusted-proxies', '127.0.0.1,10.0.0.1']);
  const open = await Client.start(['--rate-limit', '3', '--trusted-proxies', '10.0.0.1']);
  try {
    assert.equal(await statuses(behind, '203.0.113.5'), '200 200 200 429 429', 'the client behind the proxy is counted');
    assert.equal(await statuses(behind, '198.51.100.1, 203.0.113.5, 10.0.0.1'), '429 429 429 429 429', 'the last that is not trusted is the client');
    assert.equal(await statuses(behind, '203.0.113.6'), '200 200 200 429 429', 'another one has its own count');
    assert.equal(await statuses(open, '203.0.113.5'), '200 200 200 200 200', 'whoever is no proxy of ours is believed nothing');
  } finally {
    await behind.stop();
    await open.stop();
  }
});

test('a public address without keys is refused, unless the operator says so', () => {
  const data = path.join(folder, 'data');
  const refused = spawnSync(process.env.SURFACED_BIN, ['serve', '--listen', '0.0.0.0:0', '--data', data], { encoding: 'utf8' });
  assert.equal(refused.status, 2);
  assert.match(refused.stderr, /--keys/);
});
