// SPDX-License-Identifier: GPL-3.0-or-later
// Every client example does its whole work against a real server, behind a proxy that is busy at first, loses an answer
// and breaks off event streams.
import assert from 'node:assert/strict';
import { spawn, spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { source, startServer } from '../contract/support.mjs';
import { startFlakyProxy } from './flaky_proxy.mjs';

const examples = path.join(source, 'client-examples');
const knot = path.join(examples, 'samples/knot.ply');
const clients = {
  curl: ['bash', path.join(examples, 'curl/reconstruct.sh')],
  python: ['python3', path.join(examples, 'python/reconstruct.py')],
  typescript: ['node', path.join(examples, 'typescript/dist/reconstruct.js')],
  cpp: [process.env.SURFACED_CPP_CLIENT],
};
const folder = mkdtempSync(path.join(tmpdir(), 'surfaced-clients-'));
let server;

before(async () => {
  const built = spawnSync('npm', ['run', '--silent', 'build'], { cwd: path.join(examples, 'typescript'), encoding: 'utf8' });
  assert.equal(built.status, 0, built.stdout + built.stderr);
  server = await startServer();
});
after(async () => {
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

function run(name, args, url = server.base) {
  const [command, ...first] = clients[name];
  const child = spawn(command, [...first, ...args], { cwd: folder, env: { ...process.env, SURFACED_URL: url } });
  const said = { out: '', err: '' };
  child.stdout.on('data', (bytes) => (said.out += bytes));
  child.stderr.on('data', (bytes) => (said.err += bytes));
  return new Promise((resolve) => child.on('close', (status) => resolve({ ...said, status })));
}

test('every example is shorter than 150 lines', () => {
  for (const each of readdirSync(examples, { recursive: true }).map(String)) {
    if (each.includes('node_modules') || each.includes('dist') || each.startsWith('samples') || !/\.(sh|py|ts|cpp|html|m?js)$/.test(each) || each.endsWith('.d.ts')) continue;
    const lines = readFileSync(path.join(examples, each), 'utf8').split('\n').length - 1;
    assert.ok(lines < 150, `${each} has ${lines} lines`);
  }
});

for (const name of Object.keys(clients)) {
  test(`${name}: gets its mesh in spite of 503, a lost answer and a broken stream, and makes one job`, async () => {
    const proxy = await startFlakyProxy(server.base);
    try {
      const mesh = path.join(folder, `${name}.glb`);
      const ran = await run(name, [knot, mesh, 'method=advancing-front', `labels=${name}`], proxy.base);
      assert.equal(ran.status, 0, ran.err);
      assert.match(ran.out, /6000 vertices, 12000 triangles, genus 1/);
      assert.match(ran.out, /closed/);
      assert.match(ran.out, /shortest edge \/ circumradius: min 0\.79\d*, mean 1\.38/);
      assert.match(ran.out, /unused points: 0/);
      assert.equal(readFileSync(mesh).subarray(0, 4).toString('latin1'), 'glTF');
      assert.deepEqual(proxy.done(), { busy: 1, lost: 1, cut: 1, resumed: true });
      const { jobs } = await (await fetch(`${server.base}/v1/jobs?labels=${name}`)).json();
      assert.equal(jobs.length, 1, 'the repeated submission made no second job');
    } finally {
      await proxy.stop();
    }
  });

  test(`${name}: says how it is used, what was wrong, and leaves nothing half written`, async () => {
    const help = await run(name, ['--help']);
    assert.equal(help.status, 0, help.err);
    assert.match(help.out, /usage/i);
    assert.equal((await run(name, [])).status, 2);
    const mesh = `${name}-bad.glb`;
    const unknown = await run(name, [knot, mesh, 'method=nope']);
    assert.equal(unknown.status, 1);
    assert.match(unknown.err, /nope.*minimum-boundary/s);
    writeFileSync(path.join(folder, 'no-cloud.txt'), 'this is no cloud\n');
    const refused = await run(name, ['no-cloud.txt', mesh, 'method=advancing-front']);
    assert.equal(refused.status, 1);
    assert.match(refused.err, /begins with/);
    assert.deepEqual(readdirSync(folder).filter((each) => each.startsWith(mesh)), []);
  });
}
