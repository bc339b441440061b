// Random sequences of calls, valid and not, against a model of what jobs may do. No answer is ever a 500, and every
// answer is one that the contract knows. The seed is printed; SURFACED_SEED repeats a run.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { Client, sphere } from './client.mjs';

const seed = Number(process.env.SURFACED_SEED ?? Date.now() % 2 ** 31);
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

test(`jobs keep to their states whatever is asked of them (seed ${seed})`, { timeout: 120000 }, async () => {
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
    async list() {
      const { status } = await client.call('GET', `/v1/jobs?${pick(['', 'limit=3', 'status=failed', 'cursor=5', 'limit=-1', 'labels=a', 'x=1'])}`);
      assert.ok([200, 400].includes(status));
    },
  };
  for (let i = 0; i < 250; ++i) await actions[pick(Object.keys(actions))]();
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
