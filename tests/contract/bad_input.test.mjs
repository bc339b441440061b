// SPDX-License-Identifier: GPL-3.0-or-later
// Every kind of wrong request: its status, its code, and in pieces the field, the value and what is allowed.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { after, before, test } from 'node:test';
import { Client, knot, sphere } from './client.mjs';

let client;
let hasty;
before(async () => {
  client = await Client.start();
  hasty = await Client.start(['--upload-time', '1']);
});
after(async () => {
  await client?.stop();
  await hasty?.stop();
});

/** The answer is this problem, about this field with this value, and says what is allowed. */
async function refused(answer, status, code, field, value, allowed) {
  const { status: got, headers, body } = await answer;
  assert.equal(`${got} ${body.code}`, `${status} ${code}`, body.detail);
  assert.equal(headers.get('content-type'), 'application/problem+json');
  assert.equal(body.status, status);
  // OGC API - Processes has exceptions of its own for a few of them.
  if (!body.type.startsWith('http://www.opengis.net/def/exceptions/')) assert.equal(body.type, `urn:surfaced:error:${code}`);
  assert.equal(body.request_id, headers.get('x-request-id'));
  assert.equal(body.field, field, body.detail);
  assert.equal(body.value, value);
  assert.match(body.allowed, allowed);
  assert.ok(body.hint.length > 5 && body.title.length > 5);
}
const submit = (query, body = knot, headers) => client.post(`/v1/jobs?${query}`, body, headers);
const json = (body) => client.json('/v1/jobs', body);
const raw = { 'content-type': 'application/octet-stream' };
const tus = { 'tus-resumable': '1.0.0' };
const upload = async (length = 100, server = client) => (await server.call('POST', '/v1/uploads', { headers: { ...tus, 'upload-length': String(length) } })).headers.get('location');
const patch = (target, offset, body, headers = {}, server = client) => server.call('PATCH', target, {
  body, headers: { ...tus, 'content-type': 'application/offset+octet-stream', 'upload-offset': String(offset), ...headers } });

test('unknown method', async () => {
  await refused(submit('method=magic'), 400, 'unknown_method', 'method', 'magic', /advancing-front/);
  await refused(json({ cloud_id: 'x', method: 'magic' }), 400, 'unknown_method', 'method', 'magic', /minimum-boundary/);
  await refused(client.call('GET', '/v1/methods/magic'), 404, 'method_not_found', 'method', 'magic', /minimum-boundary/);
  await refused(client.call('GET', '/processes/magic'), 404, 'method_not_found', 'method', 'magic', /minimum-boundary/);
});

test('unknown parameter', async () => {
  await refused(submit('method=advancing-front&gamma=1'), 400, 'unknown_parameter', 'gamma', null, /beta/);
  await refused(submit('wait=3'), 400, 'unknown_parameter', 'wait', '3', /ttl_seconds/);
  await refused(client.call('GET', '/v1/jobs?page=2'), 400, 'unknown_parameter', 'page', '2', /cursor/);
  await refused(client.post('/v1/clouds?method=x', knot), 400, 'unknown_parameter', 'method', 'x', /no query/);
  await refused(json({ cloud_id: 'x', color: 'red' }), 400, 'invalid_request', 'color', '"red"', /cloud_id/);
});

test('what is wrong is echoed to a bounded length, however long it is', async () => {
  const long = 'x'.repeat(900_000);
  for (const body of [{ parameters: { [long]: 1 } }, { method: long }, { [long]: 1 }, { parameters: { beta: long } }, { labels: [long] }]) {
    const { status, body: problem } = await json({ cloud_id: 'x', method: 'advancing-front', ...body });
    assert.equal(status, 400);
    assert.ok(JSON.stringify(problem).length < 8000, `${problem.code} has ${JSON.stringify(problem).length} characters`);
    assert.match(problem.detail, /xxx/);
  }
});

test('value out of range', async () => {
  await refused(submit('method=advancing-front&beta=99'), 400, 'invalid_parameter', 'beta', '99', /number/);
  await refused(submit('ttl_seconds=1'), 400, 'invalid_parameter', 'ttl_seconds', '1', /60/);
  await refused(json({ cloud_id: 'x', ttl_seconds: 1 }), 400, 'invalid_parameter', 'ttl_seconds', '1', /60/);
  await refused(submit('outputs=mesh.exe'), 400, 'unknown_output', 'outputs', 'mesh.exe', /mesh\.glb/);
  await refused(client.post('/v1/reconstruct?output=exe', knot), 400, 'unknown_output', 'output', 'exe', /glb/);
  await refused(submit('labels=a%20b'), 400, 'invalid_parameter', 'labels', 'a b', /letters/);
  await refused(submit('webhook=https://example.org'), 400, 'invalid_parameter', 'webhook', 'https://example.org', /none/);
  await refused(client.call('GET', '/v1/jobs?limit=0'), 400, 'invalid_parameter', 'limit', '0', /1/);
  await refused(client.call('GET', '/v1/jobs?status=done'), 400, 'invalid_parameter', 'status', 'done', /successful/);
  await refused(client.call('GET', '/v1/jobs?cursor=zz'), 400, 'invalid_parameter', 'cursor', 'zz', /Link/);
  const { body } = await submit('method=advancing-front', sphere(60));
  await refused(client.call('GET', `/v1/jobs/${body.id}?wait=1000`), 400, 'invalid_parameter', 'wait', '1000', /60/);
});

test('wrong type', async () => {
  await refused(submit('method=advancing-front&beta=much'), 400, 'invalid_parameter', 'beta', '"much"', /number/);
  await refused(json({ cloud_id: 'x', method: 'advancing-front', parameters: { beta: '1' } }), 400, 'invalid_parameter', 'beta', '"1"', /number/);
  await refused(json({ cloud_id: 7 }), 400, 'invalid_request', 'cloud_id', '7', /string/);
  await refused(json({ cloud_id: 'x', outputs: 'mesh.glb' }), 400, 'invalid_request', 'outputs', '"mesh.glb"', /array/);
  await refused(json({ cloud_id: 'x', parameters: [] }), 400, 'invalid_request', 'parameters', '[]', /object/);
  await refused(json([]), 400, 'invalid_request', 'body', '[]', /object/);
  await refused(client.json('/v1/reconstruct', {}), 415, 'unsupported_media_type', 'Content-Type', 'application/json', /octet-stream/);
  await refused(client.post('/v1/jobs', knot, { ...raw, 'content-encoding': 'br' }), 415, 'unsupported_content_encoding', 'Content-Encoding', 'br', /identity/);
});

test('JSON that cannot be read', async () => {
  for (const body of ['{"cloud_id": ', '{"cloud_id":"x","ttl_seconds":1e999}', '['.repeat(100000), '"\\ud800"', '{"a":1}x', '\u0000']) {
    const answer = await client.call('POST', '/v1/jobs', { body, headers: { 'content-type': 'application/json' } });
    assert.equal(`${answer.status} ${answer.body.code}`, '400 invalid_request', body.slice(0, 40));
  }
});

test('body missing', async () => {
  await refused(json({ method: 'advancing-front' }), 400, 'invalid_request', 'cloud_id', null, /POST \/v1\/clouds/);
  const form = new FormData();
  form.append('method', 'advancing-front');
  await refused(client.call('POST', '/v1/jobs', { body: form }), 400, 'invalid_request', 'cloud', null, /cloud_id/);
  const empty = await submit('method=advancing-front', Buffer.alloc(0));
  assert.ok(['empty_input', 'length_required'].includes(empty.body.code));
});

test('both body and cloud_id', async () => {
  await refused(submit('cloud_id=x'), 400, 'conflicting_input', 'cloud_id', 'x', /JSON/);
  const both = new FormData();
  both.append('cloud_id', 'abc');
  both.append('cloud', new Blob([knot]), 'knot.ply');
  await refused(client.call('POST', '/v1/jobs', { body: both }), 400, 'conflicting_input', 'cloud_id', 'abc', /either/);
});

test('expired upload', async () => {
  const target = await upload(100, hasty);
  const id = target.split('/').pop();
  await hasty.until(() => hasty.call('GET', target), (body) => body.status === 410);
  await refused(hasty.call('GET', target), 410, 'upload_gone', 'id', id, /going on/);
  await refused(patch(target, 0, 'x', {}, hasty), 410, 'upload_gone', 'id', id, /going on/);
});

test('wrong checksum or offset', async () => {
  const target = await upload();
  const wrong = `sha1 ${createHash('sha1').update('something else').digest('base64')}`;
  await refused(patch(target, 0, 'x', { 'upload-checksum': wrong }), 460, 'checksum_mismatch', 'Upload-Checksum', wrong, /sha1/);
  await refused(patch(target, 0, 'x', { 'upload-checksum': 'crc9 AA' }), 400, 'invalid_request', 'Upload-Checksum', 'crc9 AA', /sha256/);
  await refused(patch(target, 7, 'x'), 409, 'upload_offset_mismatch', 'Upload-Offset', '7', /^0,/);
  await refused(patch(target, 'x', 'x'), 400, 'invalid_request', 'Upload-Offset', 'x', /number/);
  await refused(client.call('POST', '/v1/uploads', { headers: tus }), 400, 'invalid_request', 'Upload-Length', null, /number/);
  await refused(client.call('POST', '/v1/uploads'), 412, 'unsupported_tus_version', 'Tus-Resumable', null, /1\.0\.0/);
});

test('unknown id', async () => {
  const id = '0'.repeat(32);
  await refused(client.call('GET', `/v1/jobs/${id}`), 404, 'job_not_found', 'id', id, /POST \/v1\/jobs/);
  await refused(client.call('GET', `/v1/jobs/${id}/events`), 404, 'job_not_found', 'id', id, /job/);
  await refused(client.call('GET', `/jobs/${id}`), 404, 'job_not_found', 'id', id, /job/);
  await refused(client.call('GET', `/v1/clouds/${id}`), 404, 'cloud_not_found', 'cloud_id', id, /SHA-256/);
  await refused(json({ cloud_id: id }), 404, 'cloud_not_found', 'cloud_id', id, /SHA-256/);
  await refused(client.call('GET', '/v1/uploads/nothing'), 404, 'upload_not_found', 'id', 'nothing', /upload/);
});

test('conflicting key', async () => {
  const headers = { ...raw, 'idempotency-key': 'one' };
  assert.equal((await submit('method=advancing-front', sphere(60), headers)).status, 201);
  await refused(submit('method=advancing-front', sphere(61), headers), 422, 'idempotency_mismatch', 'Idempotency-Key', 'one', /again/);
  await refused(submit('method=advancing-front', sphere(60), { ...raw, 'idempotency-key': '' }), 400, 'invalid_request', 'Idempotency-Key', '', /255/);
});

test('malformed Range', async () => {
  const { body } = await submit('method=advancing-front', sphere(60));
  await client.finished(body.id);
  const target = `/v1/jobs/${body.id}/outputs/mesh.glb`;
  for (const range of ['bytes=', 'bytes=5-2', 'bytes=a-b', 'bytes=99999999-']) {
    await refused(client.call('GET', target, { headers: { range } }), 416, 'range_not_satisfiable', 'Range', range, /bytes/);
  }
  const { headers } = await client.call('GET', target, { headers: { range: 'bytes=a-b' } });
  assert.match(headers.get('content-range'), /^bytes \*\/\d+$/);
  assert.equal((await client.call('GET', target, { headers: { range: 'lines=1-2' } })).status, 200, 'other units are ignored');
});

test('Accept that cannot be met', async () => {
  const { body } = await submit('method=advancing-front', sphere(60));
  await client.finished(body.id);
  const headers = { accept: 'image/png' };
  await refused(client.call('GET', `/v1/jobs/${body.id}/outputs/mesh`, { headers }), 406, 'not_acceptable', 'Accept', 'image/png', /gltf-binary/);
  await refused(client.call('GET', `/v1/jobs/${body.id}/outputs/mesh.exe`), 404, 'output_not_found', 'name', 'mesh.exe', /report\.json/);
  const execution = { inputs: { cloud: 'x' }, outputs: { mesh: { format: { mediaType: 'image/png' } } } };
  await refused(client.json('/processes/advancing-front/execution', execution), 406, 'not_acceptable',
    'outputs.mesh.format.mediaType', 'image/png', /gltf-binary/);
});
