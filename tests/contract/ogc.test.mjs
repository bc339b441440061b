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

test('executed synchronously a process answers with the mesh, the report, or links', async () => {
  const cloud = (await client.post('/v1/clouds', knot)).body.id;
  const raw = await client.json(execution, { inputs: { cloud: { href: `${client.base}/v1/clouds/${cloud}` }, beta: 0.5 } });
  assert.equal(raw.status, 200, JSON.stringify(raw.body));
  assert.equal(raw.headers.get('content-type'), 'model/gltf-binary');
  const json = await client.json(execution, { inputs: { cloud }, outputs: { mesh: { format: { mediaType: 'model/gltf+json' } } } });
  assert.equal(json.headers.get('content-type'), 'model/gltf+json');
  const report = await client.json(execution, { inputs: { cloud: inline(knot) }, outputs: { report: {} } });
  assert.equal(report.body.mesh.genus, 1);
  const document = await client.json(execution, { inputs: { cloud }, response: 'document' });
  assert.equal((await client.call('GET', document.body.report.href)).body.mesh.genus, 1);
});

test('executed asynchronously it is a job that both doors show', async () => {
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
  assert.ok((await client.call('GET', `${target}/results`)).body.mesh.href.endsWith('/outputs/mesh.glb'));
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
  await expect(406, 'not_acceptable', { inputs: { cloud: 'x' }, outputs: { mesh: { format: { mediaType: 'image/png' } } } });
  await expect(422, 'unknown_format', { inputs: { cloud: inline(Buffer.from('this is no cloud, and never was one\n')) } });
});
