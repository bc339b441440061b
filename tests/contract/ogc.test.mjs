// SPDX-License-Identifier: GPL-3.0-or-later
// OGC API - Processes: the same jobs through the second door.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { Client, knot, sphere } from './client.mjs';

let client;
before(async () => {
  client = await Client.start();
});
after(() => client?.stop());

const execution = '/processes/advancing-front/execution';
const exception = (name) => `http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/${name}`;
const inline = (bytes) => ({ value: bytes.toString('base64'), mediaType: 'application/octet-stream' });

test('the landing page leads to conformance, processes, jobs and the contract', async () => {
  const { body } = await client.call('GET', '/');
  for (const rel of ['conformance', 'processes', 'job-list']) {
    const link = body.links.find((each) => each.rel === `http://www.opengis.net/def/rel/ogc/1.0/${rel}`);
    assert.equal((await client.call('GET', link.href)).status, 200, rel);
  }
  assert.ok((await client.call('GET', '/conformance')).body.conformsTo.some((each) => each.endsWith('/conf/core')));
  assert.equal((await client.call('GET', '/openapi-3.0.json')).body.openapi, '3.0.3');
});

test('every method is a process with its parameters as inputs', async () => {
  const { body: methods } = await client.call('GET', '/v1/methods');
  const { body: list } = await client.call('GET', '/processes');
  assert.deepEqual(list.processes.map((each) => each.id), methods.methods.map((each) => each.id));
  for (const method of methods.methods) {
    const { body } = await client.call('GET', `/processes/${method.id}`);
    assert.deepEqual(Object.keys(body.inputs), ['cloud', ...Object.keys(method.parameters.properties)]);
    assert.ok(body.outputs.mesh && body.outputs.report);
  }
  const { status, body } = await client.call('GET', '/processes/magic');
  assert.equal(`${status} ${body.type}`, `404 ${exception('no-such-process')}`);
});

/** The parts of a multipart/related, by their Content-ID. */
function partsOf({ headers, body }) {
  const boundary = /^multipart\/related; type="[^"]+"; boundary=(\S+)$/.exec(headers.get('content-type'))?.[1];
  assert.ok(boundary, headers.get('content-type'));
  const pieces = body.toString('latin1').split(`--${boundary}`);
  assert.equal(pieces[0], '');
  assert.equal(pieces.at(-1), '--\r\n');
  return Object.fromEntries(pieces.slice(1, -1).map((piece) => {
    const end = piece.indexOf('\r\n\r\n');
    const fields = Object.fromEntries(piece.slice(2, end).split('\r\n').map((line) => [line.slice(0, line.indexOf(':')).toLowerCase(), line.slice(line.indexOf(':') + 2)]));
    return [fields['content-id'], { ...fields, body: Buffer.from(piece.slice(end + 4, -2), 'latin1') }];
  }));
}
const value = { transmissionMode: 'value' };
const reference = { transmissionMode: 'reference' };

test('one output is answered as such, in the format that was asked for', async () => {
  const cloud = (await client.post('/v1/clouds', knot)).body.id;
  const raw = await client.json(execution, { inputs: { cloud: { href: `${client.base}/v1/clouds/${cloud}` }, beta: 0.5 }, outputs: { mesh: value } });
  assert.equal(raw.status, 200, JSON.stringify(raw.body));
  assert.equal(raw.headers.get('content-type'), 'model/gltf-binary');
  const json = await client.json(execution, { inputs: { cloud }, outputs: { mesh: { format: { mediaType: 'model/gltf+json' } } } });
  assert.equal(json.headers.get('content-type'), 'model/gltf+json');
  const report = await client.json(execution, { inputs: { cloud: inline(knot) }, outputs: { report: {} } });
  assert.equal(report.body.mesh.genus, 1);
});

test('several outputs are answered as multipart, of which some may be links', async () => {
  const both = await client.json(execution, { inputs: { cloud: inline(knot) } });
  assert.equal(both.status, 200);
  const parts = partsOf(both);
  assert.deepEqual(Object.keys(parts), ['mesh', 'report'], 'whoever names no outputs gets all');
  assert.equal(parts.mesh['content-type'], 'model/gltf-binary');
  assert.equal(parts.mesh.body.readUInt32LE(8), parts.mesh.body.length);
  assert.equal(JSON.parse(parts.report.body).mesh.genus, 1);
  const mixed = partsOf(await client.json(execution, { inputs: { cloud: inline(knot) }, outputs: { mesh: reference, report: value } }));
  assert.equal(mixed.mesh.body.length, 0);
  const linked = await fetch(client.base + mixed.mesh['content-location']);
  assert.deepEqual(Buffer.from(await linked.arrayBuffer()), parts.mesh.body);
  const links = await client.json(execution, { inputs: { cloud: inline(knot) }, outputs: { mesh: reference, report: reference } });
  assert.equal(links.status, 204);
  assert.match(links.headers.get('link'), /mesh\.glb>.*report\.json>/);
});

test('a document holds the outputs, or refers to them', async () => {
  const held = await client.json(execution, { inputs: { cloud: inline(knot) }, response: 'document' });
  assert.equal(held.headers.get('content-type'), 'application/json');
  assert.equal(held.body.report.value.mesh.genus, 1);
  const mesh = Buffer.from(held.body.mesh.value, 'base64');
  assert.equal(mesh.readUInt32LE(8), mesh.length);
  assert.equal(mesh.subarray(0, 4).toString(), 'glTF');
  const referred = await client.json(execution, { inputs: { cloud: inline(knot) }, response: 'document', outputs: { mesh: reference, report: reference } });
  assert.equal((await client.call('GET', referred.body.report.href)).body.mesh.genus, 1);
  const linked = await fetch(client.base + referred.body.mesh.href);
  assert.deepEqual(Buffer.from(await linked.arrayBuffer()), mesh);
});

test('the results of an asynchronous job come as its request wanted them', async () => {
  const later = async (body) => {
    const started = await client.json(execution, { inputs: { cloud: inline(knot) }, ...body }, { prefer: 'respond-async' });
    assert.equal(started.status, 201);
    await client.finished(started.body.jobID);
    return client.call('GET', `/jobs/${started.body.jobID}/results`);
  };
  assert.deepEqual(Object.keys(partsOf(await later({}))), ['mesh', 'report']);
  assert.equal((await later({ outputs: { report: value } })).body.mesh.genus, 1);
  assert.equal((await later({ outputs: { mesh: reference } })).status, 204);
  assert.equal((await later({ response: 'document', outputs: { report: value } })).body.report.value.mesh.genus, 1);
});

test('Prefer chooses between waiting and not, in any case and order', async () => {
  const body = { inputs: { cloud: inline(sphere(60)) }, outputs: { report: value } };
  for (const prefer of ['Respond-Async', 'handling=strict, respond-async', 'respond-async; x=y']) {
    const { status, headers } = await client.json(execution, body, { prefer });
    assert.equal(`${status} ${headers.get('preference-applied')}`, '201 respond-async', prefer);
  }
  for (const prefer of ['wait=20', 'respond-async, wait=20', 'Wait=20', 'wait=nonsense']) {
    assert.equal((await client.json(execution, body, { prefer })).status, 200, prefer);
  }
  assert.equal((await client.json(execution, { inputs: { cloud: inline(sphere(60000)) } }, { prefer: 'wait=0' })).status, 201);
});

test('processes and jobs are listed as the standard filters them', async () => {
  const page = (await client.call('GET', '/processes?limit=2')).body;
  assert.equal(page.processes.length, 2);
  const next = page.links.find((link) => link.rel === 'next').href;
  assert.notEqual((await client.call('GET', next)).body.processes[0].id, page.processes[0].id);
  const start = new Date().toISOString();
  const { body: { jobID } } = await client.json(execution, { inputs: { cloud: inline(sphere(60)) } }, { prefer: 'respond-async' });
  await client.finished(jobID);
  const has = async (query) => {
    const { status, body } = await client.call('GET', `/jobs?${query}`);
    assert.equal(status, 200, JSON.stringify(body));
    return body.jobs.some((job) => job.jobID === jobID);
  };
  const past = '2001-01-01T00:00:00Z';
  for (const [query, wanted] of [['processID=poisson,advancing-front', true], ['processID=poisson', false], ['status=failed,successful', true],
    ['status=failed', false], [`datetime=${start}/..`, true], [`datetime=../${past}`, false], [`datetime=${past}/2001-01-02T00:00:00%2B01:00`, false],
    [`datetime=${past}`, false], ['minDuration=0&maxDuration=1000', true], ['minDuration=900', false], ['maxDuration=0', false], ['type=process&limit=1000', true]]) {
    assert.equal(await has(query), wanted, query);
  }
  for (const query of ['type=other', 'status=done', 'datetime=yesterday', 'datetime=../..', 'datetime=2001-13-01T00:00:00Z', 'minDuration=-1', 'limit=0', 'limit=10001', 'page=2']) {
    const { status, body } = await client.call('GET', `/jobs?${query}`);
    assert.equal(status, 400, query);
    assert.equal(body.field, query.split('=')[0]);
  }
});

test('executed asynchronously it is a job that both APIs show', async () => {
  const started = await client.json(execution, { inputs: { cloud: inline(sphere(20000)) } }, { prefer: 'respond-async' });
  assert.equal(started.status, 201);
  assert.equal(started.headers.get('preference-applied'), 'respond-async');
  const target = started.headers.get('location');
  assert.equal(target, `/jobs/${started.body.jobID}`);
  const early = await client.call('GET', `${target}/results`);
  if (early.status !== 200) assert.equal(`${early.status} ${early.body.type}`, `404 ${exception('result-not-ready')}`);
  const job = await client.finished(started.body.jobID);
  const status = await client.call('GET', target);
  assert.equal(status.body.status, job.status);
  assert.equal(status.body.progress, 100);
  const direct = await client.post('/v1/jobs?method=advancing-front', sphere(60));
  await client.finished(direct.body.id);
  assert.ok((await client.call('GET', `/jobs/${direct.body.id}/results`)).body.mesh.href.endsWith('/outputs/mesh.glb'));
  assert.ok((await client.call('GET', '/jobs?type=process')).body.jobs.some((each) => each.jobID === job.id));
  assert.equal((await client.call('DELETE', target)).body.status, 'dismissed');
  const gone = await client.call('GET', target);
  assert.equal(gone.status, 410);
  assert.equal(gone.body.type, exception('no-such-job'));
  const { body } = await client.call('GET', '/jobs/00000000000000000000000000000000');
  assert.equal(body.type, exception('no-such-job'));
});

test('wrong executions have their codes', async () => {
  const expect = async (status, code, body) => {
    const answer = await client.json(execution, body);
    assert.equal(`${answer.status} ${answer.body.code}`, `${status} ${code}`, answer.body.detail);
  };
  await expect(400, 'invalid_request', {});
  await expect(400, 'invalid_request', { inputs: {} });
  await expect(400, 'invalid_request', { inputs: { cloud: 7 } });
  await expect(400, 'invalid_request', { inputs: { cloud: { href: 'https://elsewhere.example/cloud.ply' } } });
  await expect(400, 'invalid_request', { inputs: { cloud: { value: '***' } } });
  await expect(400, 'conflicting_input', { inputs: { cloud: { href: '/v1/clouds/x', ...inline(knot) } } });
  await expect(404, 'cloud_not_found', { inputs: { cloud: 'x' } });
  await expect(400, 'unknown_parameter', { inputs: { cloud: 'x', gamma: 1 } });
  await expect(400, 'unknown_output', { inputs: { cloud: 'x' }, outputs: { picture: {} } });
  await expect(400, 'invalid_request', { inputs: { cloud: 'x' }, outputs: { mesh: { transmissionMode: 'pigeon' } } });
  await expect(400, 'invalid_request', { inputs: { cloud: 'x' }, outputs: { mesh: 7 } });
  await expect(400, 'invalid_request', { inputs: { cloud: 'x' }, response: 'cooked' });
  await expect(400, 'invalid_request', { inputs: { cloud: 'x' }, subscriber: 7 });
  await expect(406, 'not_acceptable', { inputs: { cloud: 'x' }, outputs: { report: { format: { mediaType: 'text/html' } } } });
  await expect(406, 'not_acceptable', { inputs: { cloud: 'x' }, outputs: { mesh: { format: { mediaType: 'image/png' } } } });
  await expect(422, 'unknown_format', { inputs: { cloud: inline(Buffer.from('this is no cloud, and never was one\n')) } });
});
