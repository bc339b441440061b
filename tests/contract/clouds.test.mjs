// SPDX-License-Identifier: GPL-3.0-or-later
// Clouds, the forms of a submission, repeated submissions, pages, formats.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import http from 'node:http';
import { after, before, test } from 'node:test';
import { Client, knot, sphere } from './client.mjs';

let client;
before(async () => {
  client = await Client.start();
});
after(() => client?.stop());

const expect = async (status, code, answer) => {
  const { status: got, body } = await answer;
  assert.equal(`${got} ${body.code}`, `${status} ${code}`, body.detail);
};

test('a cloud is stored once, read by a process, used by jobs and removed after them', async () => {
  const first = await client.post('/v1/clouds', knot);
  assert.equal(first.status, 201);
  assert.equal(first.body.id, createHash('sha256').update(knot).digest('hex'));
  assert.equal(first.headers.get('location'), `/v1/clouds/${first.body.id}`);
  await new Promise((resolve) => setTimeout(resolve, 20)); // times have milliseconds
  const again = await client.post('/v1/clouds', knot);
  assert.equal(again.status, 200);
  assert.ok(Date.parse(again.body.expires_at) > Date.parse(first.body.expires_at), 'to send it again keeps it longer');
  assert.equal(Date.parse(first.body.expires_at) - Date.parse(first.body.created_at), 30 * 24 * 3600e3);
  const cloud = await client.until(() => client.call('GET', `/v1/clouds/${first.body.id}`), (body) => body.status !== 'inspecting');
  assert.equal(cloud.status, 'ready', JSON.stringify(cloud.error));
  assert.equal(cloud.points, 6000);
  assert.ok(cloud.bounds.min.every((low, i) => low < cloud.bounds.max[i]));
  assert.ok(cloud.attributes.includes('position'));
  const job = await client.json('/v1/jobs', { cloud_id: cloud.id, method: 'advancing-front', parameters: { beta: 0.5 }, labels: ['a:1', 'b'] });
  assert.equal(job.status, 201);
  assert.equal(job.body.cloud_id, cloud.id);
  assert.deepEqual(job.body.labels, ['a:1', 'b']);
  await expect(409, 'cloud_in_use', client.call('DELETE', `/v1/clouds/${cloud.id}`));
  assert.equal((await client.finished(job.body.id)).status, 'successful');
  assert.equal((await client.call('DELETE', `/v1/jobs/${job.body.id}`)).status, 200);
  assert.equal((await client.call('DELETE', `/v1/clouds/${cloud.id}`)).status, 204);
  await expect(404, 'cloud_not_found', client.call('GET', `/v1/clouds/${cloud.id}`));
  await expect(404, 'cloud_not_found', client.json('/v1/jobs', { cloud_id: cloud.id }));
});

test('a cloud that no reader takes is refused by the process that reads it', async () => {
  const { body } = await client.post('/v1/clouds', Buffer.from('this is no cloud, and never was one\n'));
  const cloud = await client.until(() => client.call('GET', `/v1/clouds/${body.id}`), (now) => now.status !== 'inspecting');
  assert.equal(cloud.status, 'refused');
  assert.equal(cloud.error.code, 'unknown_format');
  assert.equal(cloud.points, null);
});

test('a form brings the cloud, or names a stored one, and the fields of the query', async () => {
  const form = new FormData();
  form.append('method', 'advancing-front');
  form.append('beta', '0.5');
  form.append('cloud', new Blob([knot]), 'knot.ply');
  const job = await client.call('POST', '/v1/jobs?labels=x', { body: form });
  assert.equal(job.status, 201, JSON.stringify(job.body));
  assert.equal(job.body.parameters.beta, 0.5);
  assert.deepEqual(job.body.labels, ['x']);
  assert.equal((await client.finished(job.body.id)).status, 'successful');
  const both = new FormData();
  both.append('cloud_id', '0'.repeat(64));
  both.append('cloud', new Blob([knot]), 'knot.ply');
  await expect(400, 'conflicting_input', client.call('POST', '/v1/jobs', { body: both }));
  const none = new FormData();
  none.append('method', 'advancing-front');
  await expect(400, 'invalid_request', client.call('POST', '/v1/jobs', { body: none }));
  await expect(400, 'invalid_request', client.call('POST', '/v1/jobs', { body: 'x', headers: { 'content-type': 'multipart/form-data' } }));
});

test('wrong submissions have their codes', async () => {
  const json = (body) => client.json('/v1/jobs', body);
  await expect(400, 'invalid_request', json({}));
  await expect(400, 'invalid_request', json({ cloud_id: 7 }));
  await expect(400, 'invalid_request', json({ cloud: 'x' }));
  await expect(400, 'invalid_request', json([]));
  await expect(400, 'unknown_method', json({ cloud_id: 'x', method: 'magic' }));
  await expect(400, 'unknown_parameter', json({ cloud_id: 'x', method: 'advancing-front', parameters: { gamma: 1 } }));
  await expect(400, 'invalid_parameter', json({ cloud_id: 'x', method: 'advancing-front', parameters: { beta: '1' } }));
  await expect(400, 'invalid_parameter', json({ cloud_id: 'x', ttl_seconds: 1 }));
  await expect(400, 'invalid_parameter', json({ cloud_id: 'x', webhook: 'https://example.org' }));
  await expect(400, 'unknown_output', json({ cloud_id: 'x', outputs: ['mesh.exe'] }));
  await expect(404, 'cloud_not_found', json({ cloud_id: '\u0000../../etc/passwd' }));
  const raw = (text) => client.call('POST', '/v1/jobs', { body: text, headers: { 'content-type': 'application/json' } });
  await expect(400, 'invalid_request', raw('{"cloud_id": '));
  await expect(400, 'invalid_request', raw('['.repeat(100000)));
  await expect(422, 'empty_input', raw(''));
  await expect(400, 'conflicting_input', client.post('/v1/jobs?cloud_id=x', knot));
  await expect(415, 'unsupported_media_type', client.json('/v1/reconstruct', { cloud_id: 'x' }));
  await expect(415, 'unsupported_media_type', client.json('/v1/clouds', {}));
  await expect(400, 'unknown_parameter', client.post('/v1/clouds?method=x', knot));
});

test('an Idempotency-Key makes one job of a repeated submission', async () => {
  const headers = { 'content-type': 'application/octet-stream', 'idempotency-key': 'order-7' };
  const first = await client.post('/v1/jobs?method=advancing-front', knot, headers);
  assert.equal(first.status, 201);
  const again = await client.post('/v1/jobs?method=advancing-front', knot, headers);
  assert.equal(again.status, 200);
  assert.equal(again.body.id, first.body.id);
  await expect(422, 'idempotency_mismatch', client.post('/v1/jobs?method=advancing-front&beta=0.4', knot, headers));
  await expect(422, 'idempotency_mismatch', client.post('/v1/jobs?method=advancing-front', sphere(50), headers));
  await expect(400, 'invalid_request', client.post('/v1/jobs', knot, { ...headers, 'idempotency-key': 'x'.repeat(300) }));
  assert.equal((await client.post('/v1/jobs?method=advancing-front', knot)).status, 201);
});

test('a key whose request is still being read is in flight', async () => {
  const headers = { 'content-type': 'application/octet-stream', 'idempotency-key': 'slow' };
  const slow = http.request(`${client.base}/v1/jobs?method=advancing-front`, {
    method: 'POST', headers: { ...headers, expect: '100-continue', 'content-length': knot.length },
  });
  const answered = new Promise((resolve, reject) => slow.on('response', resolve).on('error', reject));
  const wanted = new Promise((resolve) => slow.on('continue', resolve));
  slow.flushHeaders();
  await wanted; // the server has begun to read
  await expect(409, 'request_in_flight', client.post('/v1/jobs?method=advancing-front', knot, headers));
  slow.end(knot);
  const first = await answered;
  first.resume();
  assert.equal(first.statusCode, 201);
});

test('jobs are listed in pages, newest first, by status, method and labels', async () => {
  const ids = [];
  for (let i = 0; i < 5; ++i) {
    const { body } = await client.post(`/v1/jobs?method=advancing-front&labels=page,n:${i}`, sphere(100));
    ids.unshift(body.id);
  }
  let target = '/v1/jobs?labels=page&limit=2';
  const seen = [];
  while (target) {
    const { status, headers, body } = await client.call('GET', target);
    assert.equal(status, 200);
    assert.ok(body.jobs.length <= 2);
    seen.push(...body.jobs.map((job) => job.id));
    target = /<([^>]+)>; rel="next"/.exec(headers.get('link') ?? '')?.[1];
  }
  assert.deepEqual(seen, ids);
  assert.equal((await client.call('GET', '/v1/jobs?labels=page,n:3')).body.jobs.length, 1);
  assert.equal((await client.call('GET', '/v1/jobs?method=poisson')).body.jobs.length, 0);
  await client.finished(ids[0]);
  const { body } = await client.call('GET', '/v1/jobs?status=successful&limit=200');
  assert.ok(body.jobs.some((job) => job.id === ids[0]));
  for (const query of ['limit=0', 'limit=x', 'status=done', 'cursor=zz', 'cursor=-1', 'labels=a%20b']) {
    await expect(400, 'invalid_parameter', client.call('GET', `/v1/jobs?${query}`));
  }
  await expect(400, 'unknown_parameter', client.call('GET', '/v1/jobs?page=2'));
});

test('a long poll with the ETag waits for news and says 304 without any', async () => {
  const { body } = await client.post('/v1/jobs?method=advancing-front', sphere(100));
  const job = await client.finished(body.id);
  const now = await client.call('GET', `/v1/jobs/${job.id}`);
  const headers = { 'if-none-match': now.headers.get('etag') };
  assert.equal((await client.call('GET', `/v1/jobs/${job.id}?wait=1`, { headers })).status, 304);
  assert.equal((await client.call('GET', `/v1/jobs/${job.id}`, { headers: { 'if-none-match': '"other"' } })).status, 200);
});

test('outputs come in every format, made once, with their digest', async () => {
  const direct = await client.post('/v1/reconstruct?method=advancing-front&output=gltf', knot);
  const { body } = await client.post('/v1/jobs?method=advancing-front&outputs=mesh.glb,mesh.drc', knot);
  const job = await client.finished(body.id);
  assert.ok(job.links.some((link) => link.title === 'mesh.drc'), 'what was asked for is there at the end');
  const output = (name, options) => client.call('GET', `/v1/jobs/${job.id}/outputs/${name}`, options);
  for (const name of ['mesh.glb', 'mesh.gltf', 'mesh.drc', 'mesh.ply']) {
    const { status, headers } = await output(name);
    assert.equal(status, 200, name);
    const bytes = Buffer.from(await (await fetch(`${client.base}/v1/jobs/${job.id}/outputs/${name}`)).arrayBuffer());
    assert.equal(headers.get('repr-digest'), `sha-256=:${createHash('sha256').update(bytes).digest('base64')}:`, name);
    if (name === 'mesh.gltf') assert.deepEqual(JSON.parse(bytes), direct.body, 'made later or at once: the same file');
  }
  const any = async (accept) => {
    const { status, headers } = await output('mesh', { headers: { accept } });
    return `${status} ${(headers.get('content-location') ?? '').split('/').pop()}`;
  };
  assert.equal(await any('*/*'), '200 mesh.glb');
  assert.equal(await any('model/gltf+json, model/gltf-binary;q=0.5'), '200 mesh.gltf');
  assert.equal(await any('application/x-draco'), '200 mesh.drc');
  assert.equal(await any('image/png, model/ply;q=0.1'), '200 mesh.ply');
  await expect(406, 'not_acceptable', output('mesh', { headers: { accept: 'image/png' } }));
  await expect(404, 'output_not_found', output('mesh.exe'));
  await client.call('DELETE', `/v1/jobs/${job.id}`);
  await expect(410, 'job_gone', output('mesh'));
});

test('cancel, retry and removal follow the states of a job', async () => {
  const { body } = await client.post('/v1/jobs?method=advancing-front', Buffer.from('this is no cloud, and never was one\n'));
  assert.equal((await client.finished(body.id)).status, 'failed');
  const retried = await client.call('POST', `/v1/jobs/${body.id}/retry`);
  assert.equal(retried.status, 202);
  assert.equal((await client.finished(body.id)).attempt, 2);
  await client.call('DELETE', `/v1/jobs/${body.id}`);
  await expect(410, 'job_gone', client.call('POST', `/v1/jobs/${body.id}/retry`));
  const done = await client.post('/v1/jobs?method=advancing-front', sphere(60));
  await client.finished(done.body.id);
  await expect(409, 'not_retryable', client.call('POST', `/v1/jobs/${done.body.id}/retry`));
});
