// SPDX-License-Identifier: GPL-3.0-or-later
// Random sequences of calls, valid and not, against a model of what jobs may do. No answer is ever a 500, and every
// answer is one that the contract knows. The same calls
// each time, so that a change is judged by what it does; SURFACED_SEED makes others, SURFACED_STEPS more.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { after, before, test } from 'node:test';
import { Client, sphere } from './client.mjs';

const seed = Number(process.env.SURFACED_SEED ?? 7);
const steps = Number(process.env.SURFACED_STEPS ?? 300);
let client;
before(async () => {
  client = await Client.start(['--workers', '2', '--queue-limit', '8']);
});
after(() => client?.stop());

function randomOf(start) {
  let state = start;
  return (bound) => {
    state = (Math.imul(state, 1103515245) + 12345) & 0x7fffffff;
    return (state >> 8) % bound;
  };
}

/** What may follow a state; a job that waits or runs goes on by itself. */
const after_ = {
  accepted: ['accepted', 'running', 'successful', 'failed', 'dismissed'],
  running: ['accepted', 'running', 'successful', 'failed', 'dismissed'],
  successful: ['successful'],
  failed: ['failed'],
  dismissed: ['dismissed'],
};

test(`jobs keep to their states whatever is asked of them (seed ${seed})`, { timeout: 600000 + steps * 1000 }, async () => {
  const random = randomOf(seed);
  const pick = (list) => list[random(list.length)];
  const jobs = new Map();
  const clouds = new Set();
  const check = (id, job) => {
    assert.ok(after_[jobs.get(id)]?.includes(job.status), `seed ${seed}: ${id} went from ${jobs.get(id)} to ${job.status}`);
    jobs.set(id, job.status);
  };
  const someJob = () => pick([...jobs.keys(), '0'.repeat(32), 'x', '..', '%00', 'a'.repeat(300)]);
  const bodies = [() => sphere(40 + random(200)), () => sphere(3000), () => Buffer.from('nonsense\n'), () => Buffer.alloc(0)];
  const actions = {
    async submit() {
      const query = pick(['', 'method=advancing-front', 'method=magic', 'beta=9', 'method=advancing-front&outputs=mesh.ply,mesh.drc', 'ttl_seconds=1', 'labels=a,b', 'wait=1']);
      const { status, body } = await client.post(`/v1/jobs?${query}`, pick(bodies)());
      if (status === 201) jobs.set(body.id, 'accepted');
      else assert.ok([400, 411, 422, 503].includes(status), `${status} ${body.code}`);
    },
    async look() {
      const id = someJob();
      const { status, body } = await client.call('GET', `/v1/jobs/${id}`);
      if (jobs.get(id) === 'removed') assert.equal(status, 410);
      else if (jobs.has(id)) check(id, body);
      else assert.ok(status >= 400 && status < 500);
    },
    async dismiss() {
      const id = someJob();
      const before_ = jobs.get(id);
      const { status, body } = await client.call('DELETE', pick([`/v1/jobs/${id}`, `/jobs/${id}`]));
      if (before_ === 'removed') assert.equal(status, 410);
      else if (!before_) assert.ok(status >= 400 && status < 500);
      else {
        assert.ok([200, 202].includes(status), `${status} ${body.code}`);
        const now = await client.call('GET', `/v1/jobs/${id}`);
        jobs.set(id, now.status === 410 ? 'removed' : now.body.status);
        assert.ok(['removed', 'dismissed'].includes(jobs.get(id)), jobs.get(id));
      }
    },
    async retry() {
      const id = someJob();
      const { status, body } = await client.call('POST', `/v1/jobs/${id}/retry`);
      if (status === 202) {
        assert.ok(['failed', 'dismissed', 'accepted', 'running'].includes(jobs.get(id)), jobs.get(id));
        jobs.set(id, 'accepted');
      } else assert.ok([404, 409, 410, 400, 503].includes(status), `${status} ${body.code}`);
    },
    async output() {
      const name = pick(['mesh', 'mesh.glb', 'mesh.gltf', 'mesh.drc', 'mesh.ply', 'report.json', 'log.txt', 'x', '..']);
      const headers = pick([{}, { range: 'bytes=0-9' }, { range: 'bytes=-5' }, { range: 'bytes=99999999-' }, { range: 'lines=1' }, { accept: 'image/png' }, { accept: 'model/ply' }, { 'if-none-match': '*' }]);
      const { status } = await client.call(pick(['GET', 'HEAD']), `/v1/jobs/${someJob()}/outputs/${name}`, { headers });
      assert.ok(status < 500 || status === 503, `${status}`);
    },
    async cloud() {
      const { status, body } = await client.post('/v1/clouds', pick(bodies)());
      if (status < 300) clouds.add(body.id);
      else assert.equal(status, 422);
    },
    async useCloud() {
      const { status, body } = await client.json('/v1/jobs', { cloud_id: pick([...clouds, 'x', '']), method: pick(['advancing-front', 'x']) });
      if (status === 201) jobs.set(body.id, 'accepted');
      else assert.ok([400, 404, 503].includes(status), `${status} ${body.code}`);
    },
    async dropCloud() {
      const id = pick([...clouds, 'x']);
      const { status } = await client.call('DELETE', `/v1/clouds/${id}`);
      if (status === 204) clouds.delete(id);
      else assert.ok([404, 409].includes(status), `${status}`);
    },
    async repeat() {
      const headers = { 'content-type': 'application/octet-stream', 'idempotency-key': `key-${random(20)}` };
      const target = `/v1/jobs?method=advancing-front${pick(['', '&labels=x'])}`;
      const body = sphere(40 + random(3));
      const first = await client.post(target, body, headers);
      if (first.status === 201) jobs.set(first.body.id, 'accepted');
      else if (first.status !== 200) return assert.ok([410, 422, 503].includes(first.status), `${first.status} ${first.body.code}`);
      const second = await client.post(target, body, headers);
      return assert.equal(`${second.status} ${second.body.id}`, `200 ${first.body.id}`);
    },
    async upload() {
      const bytes = Buffer.from(Array.from({ length: 1 + random(400) }, () => random(256)));
      const tus = { 'tus-resumable': '1.0.0' };
      const created = await client.call('POST', '/v1/uploads', { headers: { ...tus, 'upload-length': String(bytes.length) } });
      assert.equal(created.status, 201);
      const target = created.headers.get('location');
      let offset = 0;
      for (let i = 0; i < 12 && offset < bytes.length; ++i) {
        const [from, size] = [pick([offset, offset, offset, offset + 1, 0]), 1 + random(200)];
        const part = bytes.subarray(from, from + size);
        const algorithm = pick(['sha1', 'md5']);
        const honest = random(4) > 0;
        const headers = { ...tus, 'content-type': 'application/offset+octet-stream', 'upload-offset': String(from) };
        if (random(2)) headers['upload-checksum'] = `${algorithm} ${createHash(algorithm).update(honest ? part : 'x').digest('base64')}`;
        const { status, headers: told } = await client.call('PATCH', target, { body: part, headers });
        if (from !== offset) assert.equal(status, 409);
        else if (headers['upload-checksum'] && !honest) assert.equal(status, 460);
        else {
          assert.equal(status, 204);
          offset += part.length;
          assert.equal(told.get('upload-offset'), String(offset));
        }
        const head = await client.call('HEAD', target, { headers: tus });
        assert.equal(head.headers.get('upload-offset'), String(offset), 'what counts is what was told');
      }
      const { body } = await client.call('GET', target);
      const sum = createHash('sha256').update(bytes).digest('hex');
      assert.equal(body.cloud_id, offset === bytes.length ? sum : null);
      if (body.cloud_id) clouds.add(body.cloud_id);
      assert.equal((await client.call('DELETE', target, { headers: tus })).status, 204);
      assert.equal((await client.call('HEAD', target, { headers: tus })).status, 410);
    },
    async execute() {
      const cloud = pick([pick([...clouds, 'x']), { value: pick(bodies)().toString('base64') }, { href: '/v1/clouds/x' }, 7, null]);
      const outputs = pick([{}, undefined, { mesh: {} }, { report: { transmissionMode: 'reference' } }, { mesh: { transmissionMode: 'x' } }, [], 'mesh']);
      const wish = { inputs: pick([{ cloud }, { cloud, beta: 0.5 }, { cloud, beta: {} }, {}, 'x']), outputs, response: pick(['raw', 'document', undefined, 1]) };
      const prefer = pick(['respond-async', 'wait=0', 'wait=1', 'respond-async, wait=1', '']);
      const { status, body } = await client.json(`/processes/${pick(['advancing-front', 'advancing-front', 'magic'])}/execution`, wish, { prefer });
      if (status === 201) jobs.set(body.jobID, 'accepted');
      else assert.ok([200, 204, 400, 404, 422, 503].includes(status), `${status} ${body.code}`);
    },
    async results() {
      const id = someJob();
      const { status, body } = await client.call('GET', `/jobs/${id}/results`);
      if (jobs.get(id) === 'removed') assert.equal(status, 410);
      else if (['failed', 'dismissed'].includes(jobs.get(id))) assert.ok(status >= 400 && status < 500, `${status}`);
      else assert.ok([200, 204, 400, 404, 409, 422].includes(status), `${status} ${body.code}`);
    },
    async follow() {
      const ended = [...jobs].filter(([, status]) => ['successful', 'failed', 'dismissed'].includes(status)).map(([id]) => id);
      const headers = pick([{}, { 'last-event-id': '1.0.running' }, { 'last-event-id': 'nonsense' }, { 'last-event-id': '99.99.done' }]);
      const { status, body } = await client.call('GET', `/v1/jobs/${pick([...ended, 'x'])}/events`, { headers });
      assert.ok([200, 204, 404].includes(status), `${status}`);
      if (status === 200) assert.match(body.toString(), /event: done\n.*\ndata: .*\n\n$/);
    },
    async deliveries() {
      const id = someJob();
      const { status, body } = await client.call('GET', `/v1/jobs/${id}/deliveries`);
      if (status === 200) assert.deepEqual(body.deliveries, []);
      else assert.ok([400, 404, 410].includes(status), `${status}`);
    },
    async nonsense() {
      const junk = [null, true, -1, 1e308, '', 'x', '\u0000', [], [[]], {}, { cloud_id: 'x' }, 'a'.repeat(3000), '\ud800'];
      const names = ['method', 'cloud_id', 'parameters', 'outputs', 'webhook', 'ttl_seconds', 'labels', 'inputs', 'x'];
      const body = Object.fromEntries(Array.from({ length: random(4) }, () => [pick(names), pick(junk)]));
      const target = pick(['/v1/jobs', '/v1/reconstruct', '/v1/clouds', '/processes/advancing-front/execution']);
      const { status } = await client.json(target, pick([body, pick(junk)]));
      assert.ok(status >= 400 && status < 500, `${status}`);
    },
    async list() {
      const { status } = await client.call('GET', `/v1/jobs?${pick(['', 'limit=3', 'status=failed', 'status=failed,running', 'cursor=5', 'limit=-1', 'labels=a', 'x=1'])}`);
      assert.ok([200, 400].includes(status));
    },
  };
  for (let i = 0; i < steps; ++i) await actions[pick(Object.keys(actions))]();
});

test('every path and method answers as the contract says', async () => {
  const { document } = client.contract;
  const methods = ['GET', 'HEAD', 'POST', 'PUT', 'PATCH', 'DELETE', 'OPTIONS'];
  for (const template of Object.keys(document.paths)) {
    for (const method of methods) {
      const known = document.paths[template][method.toLowerCase()] ?? (method === 'HEAD' && document.paths[template].get);
      for (const id of ['0'.repeat(32), 'x%20y', '%F0%9F%98%80']) {
        const target = template.replace('{id}', id).replace('{name}', 'mesh.glb');
        const body = ['POST', 'PUT', 'PATCH'].includes(method) ? 'x' : undefined;
        const { status } = await client.call(method, target, { body });
        assert.ok(status < 500, `${method} ${target}: ${status}`);
        assert.equal(status === 405, !known, `${method} ${target}: ${status}`);
        if (!template.includes('{id}')) break;
      }
    }
  }
});
