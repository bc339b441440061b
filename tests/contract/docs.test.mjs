// SPDX-License-Identifier: GPL-3.0-or-later
// The contract lints clean, and the commands of docs/service.md do what the page says.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { Client, knot } from './client.mjs';
import { source } from './support.mjs';

let client;
const folder = mkdtempSync(path.join(tmpdir(), 'surfaced-docs-'));
before(async () => {
  client = await Client.start();
});
after(async () => {
  await client?.stop();
  rmSync(folder, { recursive: true, force: true });
});

test('openapi.yaml lints clean', () => {
  const lint = spawnSync(path.join(import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname), 'node_modules/.bin/redocly'),
    ['lint', '--config', path.join(source, 'tests/contract/redocly.yaml'), path.join(source, 'proto/openapi.yaml')],
    { encoding: 'utf8', env: { ...process.env, REDOCLY_TELEMETRY: 'off' } });
  assert.equal(lint.status, 0, lint.stdout + lint.stderr);
  assert.doesNotMatch(lint.stdout + lint.stderr, /warning/i);
});

test('the story of docs/service.md runs as it is written', { timeout: 600000 }, () => {
  const page = readFileSync(path.join(source, 'docs/service.md'), 'utf8');
  const blocks = [...page.matchAll(/```sh\n([\s\S]*?)```/g)].map((found) => found[1]);
  assert.ok(blocks.length >= 5, 'the page has its commands');
  const script = `set -euo pipefail\nserver=${client.base}\ncp ${path.join(source, 'client-examples/samples/knot.ply')} .\n${blocks.join('\n')}`;
  const run = spawnSync('bash', ['-c', script], { cwd: folder, encoding: 'utf8' });
  assert.equal(run.status, 0, `${run.stdout}\n${run.stderr}`);
  assert.equal(readFileSync(path.join(folder, 'knot.glb')).subarray(0, 4).toString('latin1'), 'glTF');
});

test('the examples of the contract are of this version: methods, parameters and sections as the server has them', async () => {
  const read = (name) => JSON.parse(readFileSync(path.join(source, 'proto/examples', name), 'utf8'));
  const { body: method } = await client.call('GET', '/v1/methods/advancing-front');
  assert.deepEqual(read('method-advancing-front.json'), method);
  const { body: job } = await client.post('/v1/jobs?method=advancing-front', knot);
  await client.finished(job.id);
  const { body: report } = await client.call('GET', `/v1/jobs/${job.id}/outputs/report.json`);
  assert.deepEqual(Object.keys(read('report-advancing-front.json')).sort(), Object.keys(report).sort());
  for (const name of ['job-successful.json', 'job-failed.json', 'report-advancing-front.json']) {
    assert.deepEqual(read(name).parameters, report.parameters, name);
  }
});

test('the reference for people is served without anything from elsewhere', async () => {
  const { status, headers } = await client.call('GET', '/docs');
  assert.equal(status, 200);
  const policy = headers.get('content-security-policy');
  assert.match(policy, /default-src 'none'/);
  assert.match(policy, /frame-ancestors 'none'/);
  assert.doesNotMatch(policy, /unsafe/);
  assert.equal(headers.get('x-frame-options'), 'DENY');
  const page = await (await fetch(`${client.base}/docs`)).text();
  assert.doesNotMatch(page, /https?:\/\//);
  assert.doesNotMatch(page, /<style|<script>|\son\w+=|\sstyle=/, 'nothing inline');
  for (const [, target] of page.matchAll(/(?:href|src)="(\/docs\.[^"]+)"/g)) {
    assert.equal((await client.call('GET', target)).status, 200, target);
  }
});
