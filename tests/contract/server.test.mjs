// SPDX-License-Identifier: GPL-3.0-or-later
// Every answer of a running server against the contract that it serves.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { Contract, readJson, source, startServer } from './support.mjs';

const knot = readFileSync(path.join(source, 'client-examples/samples/knot.ply'));
let server;
let contract;

before(async () => {
  server = await startServer();
  const answer = await fetch(`${server.base}/openapi.json`);
  contract = new Contract(await answer.json());
});
after(async () => {
  await server?.stop();
});

/** One call, checked; returns the status and the decoded body. */
async function call(method, target, options = {}) {
  const url = server.base + target;
  const send = () => fetch(url, { method, redirect: 'manual', ...options });
  // A connection kept from a call before may end while this one is on its way: a GET is sent once more.
  const response = await (method === 'GET' ? send().catch(send) : send());
  const body = await contract.check(method, url, response);
  return { status: response.status, headers: response.headers, body };
}

const post = (target, body, headers = { 'content-type': 'application/octet-stream' }) => call('POST', target, { body, headers });

/** GLB: the JSON chunk. */
function gltfJson(glb) {
  assert.equal(glb.subarray(0, 4).toString('latin1'), 'glTF');
  return JSON.parse(glb.subarray(20, 20 + glb.readUInt32LE(12)).toString('utf8'));
}

async function finished(id) {
  for (let i = 0; i < 20; ++i) {
    const { body } = await call('GET', `/v1/jobs/${id}?wait=10`);
    if (!['accepted', 'running'].includes(body.status)) return body;
  }
  throw new Error('the job did not end');
}

test('one call gives a mesh whose extras are a report', async () => {
  const began = Date.now();
  const { status, headers, body } = await post('/v1/reconstruct?method=advancing-front&output=glb', knot);
  assert.equal(status, 200);
  assert.equal(headers.get('content-type'), 'model/gltf-binary');
  const date = Date.parse(headers.get('date'));
  assert.ok(date > began - 2000 && date < Date.now() + 2000, 'answers have their date, to the second');
  const report = gltfJson(body).asset.extras;
  contract.validate({ $ref: '#/components/schemas/report' }, report, 'asset.extras');
  assert.equal(report.mesh.genus, 1);
  assert.equal(report.stages, undefined);
  assert.equal(report.resources, undefined);
  assert.equal(report.provenance.input_sha256, undefined);
  const link = /<([^>]+)>;\s*rel="?describedby/.exec(headers.get('link'));
  assert.ok(link, `Link: ${headers.get('link')}`);
  const full = await call('GET', new URL(link[1], server.base).pathname);
  assert.equal(full.body.mesh.triangles, report.mesh.triangles);
  assert.ok(full.body.stages.length > 3);
});

test('a job goes from accepted to its outputs and away', async () => {
  const created = await post('/v1/jobs?method=advancing-front&beta=0.5', knot);
  assert.equal(created.status, 201);
  assert.equal(created.body.parameters.beta, 0.5);
  assert.equal(created.headers.get('location'), `/v1/jobs/${created.body.id}`);
  const job = await finished(created.body.id);
  assert.equal(job.status, 'successful', JSON.stringify(job.error));
  assert.equal(job.progress, 1);
  for (const name of ['mesh.glb', 'report.json', 'log.txt']) {
    const target = `/v1/jobs/${job.id}/outputs/${name}`;
    const whole = await call('GET', target);
    assert.equal(whole.status, 200);
    const etag = whole.headers.get('etag');
    assert.match(etag, /^"[^"]+"$/);
    assert.equal((await call('GET', target, { headers: { 'if-none-match': etag } })).status, 304);
    assert.equal((await call('HEAD', target)).headers.get('etag'), etag);
  }
  const mesh = `/v1/jobs/${job.id}/outputs/mesh.glb`;
  const part = await call('GET', mesh, { headers: { range: 'bytes=0-3' } });
  assert.equal(part.status, 206);
  assert.equal(part.body.toString('latin1'), 'glTF');
  assert.equal((await call('GET', mesh, { headers: { range: 'bytes=999999999-' } })).status, 416);
  assert.equal((await call('DELETE', `/v1/jobs/${job.id}`)).status, 200);
  assert.equal((await call('GET', `/v1/jobs/${job.id}`)).status, 410);
});

test('a method that makes a cloud gives its points as PLY when they are asked for, others refuse', async () => {
  const created = await post('/v1/jobs?method=intrinsic-delaunay&outputs=mesh.ply,cloud.ply', knot);
  assert.equal(created.status, 201);
  const job = await finished(created.body.id);
  assert.equal(job.status, 'successful', JSON.stringify(job.error));
  const points = await call('GET', `/v1/jobs/${job.id}/outputs/cloud.ply`);
  assert.equal(points.status, 200);
  assert.equal(points.headers.get('content-type'), 'application/octet-stream');
  assert.match(points.body.toString('latin1', 0, 200), /^ply\nformat binary_little_endian 1\.0\nelement vertex 6000\n/);
  const refused = await post('/v1/jobs?method=advancing-front&outputs=cloud.ply', knot);
  assert.equal(refused.status, 400);
  assert.equal(refused.body.code, 'unknown_output');
});

test('a failed job is tried again when its client says so, and lists both attempts', async () => {
  const created = await post('/v1/jobs?method=advancing-front', Buffer.from('this is no cloud\n'), {
    traceparent: '00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01',
  });
  assert.equal((await finished(created.body.id)).attempts.length, 1);
  const again = await call('POST', `/v1/jobs/${created.body.id}/retry`);
  assert.equal(again.status, 202);
  assert.equal(again.headers.get('location'), `/v1/jobs/${created.body.id}`);
  const job = await finished(created.body.id);
  assert.deepEqual(job.attempts.map((attempt) => attempt.outcome), ['input_invalid', 'input_invalid']);
  assert.equal(job.parked, false);
  const log = (await call('GET', `/v1/jobs/${job.id}/outputs/log.txt`)).body.toString();
  assert.match(log, /traceparent 00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01/);
  const good = await post('/v1/jobs?method=advancing-front', knot);
  await finished(good.body.id);
  assert.equal((await call('POST', `/v1/jobs/${good.body.id}/retry`)).body.code, 'not_retryable');
  assert.equal((await call('POST', '/v1/jobs/00000000000000000000000000000000/retry')).status, 404);
});

const malformed = [
  ['an empty body', Buffer.alloc(0), ['empty_input', 'length_required']],
  ['text', Buffer.from('hello, this is no cloud\n'), ['unknown_format']],
  ['a PNG', Buffer.from('89504e470d0a1a0a0000000d49484452', 'hex'), ['unknown_format']],
  ['a PLY that ends early', knot.subarray(0, 2000), ['truncated_input']],
  ['a count of 2^40', Buffer.from('ply\nformat binary_little_endian 1.0\nelement vertex 1099511627776\nproperty float x\nproperty float y\nproperty float z\nend_header\n'), ['truncated_input']],
  ['a NaN', Buffer.from('ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 nan\nnan 0 0\n'), ['coordinate_not_finite']],
  ['1e299', Buffer.from('ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\nproperty double z\nend_header\n1e299 0 0\n'), ['coordinate_out_of_range']],
  ['equal points', Buffer.from(`ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nend_header\n${'1 1 1\n'.repeat(4)}`), ['too_few_points']],
  ['collinear points', Buffer.from('ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n1 1 1\n2 2 2\n3 3 3\n'), ['collinear']],
  ['a Draco file that ends early', Buffer.from('445241434f02020000', 'hex'), ['truncated_input', 'malformed_input']],
];
for (const [what, bytes, codes] of malformed) {
  test(`${what} is refused in one call, and fails a job, with its code`, async () => {
    const direct = await post('/v1/reconstruct?method=advancing-front', bytes);
    assert.ok(direct.status >= 400 && direct.status < 500, `${direct.status}`);
    assert.ok(codes.includes(direct.body.code), `${direct.body.code}: ${direct.body.detail}`);
    const queued = await post('/v1/jobs?method=advancing-front', bytes);
    if (queued.status !== 201) {
      assert.ok(codes.includes(queued.body.code));
      return;
    }
    const job = await finished(queued.body.id);
    assert.equal(job.status, 'failed');
    assert.ok(codes.includes(job.error.code), job.error.code);
    const missing = await call('GET', `/v1/jobs/${job.id}/outputs/mesh.glb`);
    assert.equal(missing.status, 409);
  });
}

test('wrong requests have their codes', async () => {
  const expect = async (status, code, answer) => {
    const { status: got, body } = await answer;
    assert.equal(`${got} ${body.code}`, `${status} ${code}`, body.detail);
  };
  await expect(400, 'unknown_method', post('/v1/jobs?method=magic', knot));
  await expect(400, 'unknown_parameter', post('/v1/jobs?method=advancing-front&gamma=1', knot));
  await expect(400, 'invalid_parameter', post('/v1/jobs?method=advancing-front&beta=99', knot));
  await expect(400, 'unknown_output', post('/v1/jobs?method=advancing-front&outputs=mesh.xyz', knot));
  await expect(404, 'job_not_found', call('GET', '/v1/jobs/00000000000000000000000000000000'));
  await expect(404, 'not_found', call('GET', '/v2/everything'));
  await expect(405, 'method_not_allowed', call('PUT', '/v1/jobs', { body: 'x' }));
  await expect(415, 'unsupported_content_encoding', post('/v1/jobs?method=advancing-front', knot, { 'content-encoding': 'br' }));
  await expect(404, 'method_not_found', call('GET', '/v1/methods/magic'));
});

test('the line of the README gives a mesh of the shipped sample', async () => {
  const { status, body } = await post('/v1/reconstruct?output=glb', knot);
  assert.equal(status, 200);
  const report = gltfJson(body).asset.extras;
  assert.equal(report.method, (await call('GET', '/v1/methods')).body.methods[0].id);
  assert.ok(report.mesh.closed && report.mesh.vertex_manifold);
  assert.equal(report.mesh.vertices, 6000);
});

test('the curl example waits, downloads and prints the report, and shows a problem', () => {
  const folder = mkdtempSync(path.join(tmpdir(), 'surfaced-curl-'));
  const run = (...words) =>
    spawnSync(path.join(source, 'client-examples/curl/reconstruct.sh'), words, {
      encoding: 'utf8',
      env: { ...process.env, SURFACED_URL: server.base },
    });
  try {
    const good = run(path.join(source, 'client-examples/samples/knot.ply'), path.join(folder, 'knot.glb'), 'method=advancing-front', 'beta=0.5');
    assert.equal(good.status, 0, good.stderr);
    assert.match(good.stdout, /^6000 vertices, \d+ triangles, genus 1, closed: /);
    gltfJson(readFileSync(path.join(folder, 'knot.glb')));
    const bad = run(path.join(source, 'README.md'), path.join(folder, 'none.glb'), 'method=advancing-front');
    assert.notEqual(bad.status, 0);
    assert.match(bad.stderr, /failed: the cloud is text, but no table of points/);
    assert.equal(run('--help').status, 0);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
});

test('probes, index, methods and the contract answer as declared', async () => {
  for (const target of ['/healthz', '/readyz', '/metrics', '/', '/v1/methods', '/v1/methods/advancing-front', '/openapi.json']) {
    assert.equal((await call('GET', target)).status, 200, target);
  }
});

test('every code that the server used stands in errors.json', async () => {
  const codes = new Set(readJson('proto/errors.json').errors.map((error) => error.code));
  const { body } = await call('GET', '/nowhere');
  assert.ok(codes.has(body.code));
});
