// SPDX-License-Identifier: GPL-3.0-or-later
// Server-Sent Events: complete, and resumed without loss or repetition.
import assert from 'node:assert/strict';
import net from 'node:net';
import { after, before, test } from 'node:test';
import { Client, knot, sphere } from './client.mjs';

let client;
before(async () => {
  client = await Client.start(['--workers', '1']);
});
after(() => client?.stop());

/** Reads events until the end of the stream, or until `enough` says so. */
async function events(target, { headers = {}, enough = () => false } = {}) {
  const answer = await fetch(client.base + target, { headers });
  assert.equal(answer.status, 200);
  assert.equal(answer.headers.get('content-type'), 'text/event-stream');
  const seen = Object.assign([], { comments: 0 });
  let text = '';
  const decoder = new TextDecoder();
  for await (const bytes of answer.body) {
    text += decoder.decode(bytes, { stream: true });
    for (let end = text.indexOf('\n\n'); end >= 0; end = text.indexOf('\n\n')) {
      const fields = Object.fromEntries(text.slice(0, end).split('\n').map((line) => [line.slice(0, line.indexOf(':')), line.slice(line.indexOf(':') + 2)]));
      text = text.slice(end + 2);
      if (!fields.event) {
        seen.comments += 1;
        continue;
      }
      seen.push({ event: fields.event, id: fields.id, data: JSON.parse(fields.data) });
      if (enough(seen.at(-1))) return seen;
    }
  }
  return seen;
}
const lines = (seen) => seen.filter((each) => each.event === 'log').flatMap((each) => each.data.lines);

test('a stream tells of states, progress and log, ends with done, and resumes where it broke off', async () => {
  const { body } = await client.post('/v1/jobs?method=advancing-front', sphere(60000));
  const target = `/v1/jobs/${body.id}/events`;
  const began = performance.now();
  const first = await events(target, { enough: (event) => event.event === 'log' });
  const rest = await events(target, { headers: { 'last-event-id': first.at(-1).id } });
  const states = [...first, ...rest].filter((each) => each.event === 'state').map((each) => each.data.status);
  assert.equal(states.at(-1), 'successful');
  assert.equal(new Set(states).size, states.length, `no state twice: ${states}`);
  assert.equal(rest.at(-1).event, 'done');
  assert.equal(rest.at(-1).data.status, 'successful');
  const silences = (performance.now() - began) / 10_000;
  assert.ok(first.comments + rest.comments < 3 + silences, `${first.comments + rest.comments} comments where there is always something to tell`);
  const progress = rest.filter((each) => each.event === 'progress').map((each) => each.data.progress);
  assert.deepEqual(progress, [...progress].sort((a, b) => a - b), 'progress never falls');
  const log = await (await fetch(`${client.base}/v1/jobs/${body.id}/outputs/log.txt`)).text();
  assert.deepEqual([...lines(first), ...lines(rest)], log.trimEnd().split('\n'), 'every line of the log once');
  const again = await client.call('GET', target, { headers: { 'last-event-id': rest.at(-1).id } });
  assert.equal(again.status, 204, 'nothing more to tell');
});

test('the stream of an ended job is complete at once, and one of no job is a problem', async () => {
  const { body } = await client.post('/v1/jobs?method=advancing-front', knot);
  await client.finished(body.id);
  const seen = await events(`/v1/jobs/${body.id}/events`);
  assert.deepEqual(seen.map((each) => each.event).filter((each) => each !== 'log'), ['state', 'done']);
  assert.equal((await client.call('GET', '/v1/jobs/0123/events')).body.code, 'job_not_found');
});

test('a thousand streams are open while submissions keep their pace', { timeout: 600000 }, async () => {
  const pace = async () => {
    const began = performance.now();
    for (let i = 0; i < 20; ++i) assert.equal((await client.post('/v1/jobs?method=advancing-front', sphere(50))).status, 201);
    return performance.now() - began;
  };
  const { body } = await client.post('/v1/jobs?method=advancing-front', sphere(150000));
  await client.freeze(body.id);
  const alone = await pace();
  const { hostname, port } = new URL(client.base);
  const follow = () => new Promise((resolve, reject) => {
    let text = '';
    const socket = net.connect(Number(port), hostname, () => socket.write(`GET /v1/jobs/${body.id}/events HTTP/1.1\r\nHost: x\r\n\r\n`));
    socket.on('data', (bytes) => { text += bytes; });
    socket.on('error', reject);
    socket.on('close', () => resolve(text));
  });
  const streams = Array.from({ length: 1000 }, follow);
  await new Promise((resolve) => setTimeout(resolve, 1000));
  let crowded = Infinity;
  // What else the machine does makes a try longer, and never shorter.
  for (let i = 0; i < 4 && crowded >= 3 * alone + 1000; i += 1) crowded = Math.min(crowded, await pace());
  await client.call('DELETE', `/v1/jobs/${body.id}`);
  const ends = await Promise.all(streams);
  assert.ok(ends.every((seen) => /event: done\n.*\n.*"status":"dismissed"/.test(seen)));
  assert.ok(ends.every((seen) => seen.includes('event: state')));
  console.log(`20 submissions: ${alone.toFixed(0)} ms alone, ${crowded.toFixed(0)} ms beside 1000 streams`);
  assert.ok(crowded < 3 * alone + 1000, `${alone} ms alone, ${crowded} ms beside 1000 streams`);
});
