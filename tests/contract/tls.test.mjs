// SPDX-License-Identifier: GPL-3.0-or-later
// TLS as clients meet it: curl and openssl against the running server.
import assert from 'node:assert/strict';
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import net from 'node:net';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { source, startServer } from './support.mjs';

const folder = mkdtempSync(path.join(tmpdir(), 'surfaced-tls-'));
const file = (name) => path.join(folder, name);
const knot = path.join(source, 'client-examples/samples/knot.ply');

function makeCertificate(name) {
  execFileSync('openssl', ['req', '-x509', '-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:prime256v1', '-nodes', '-days', '1',
    '-subj', `/CN=${name}`, '-addext', 'subjectAltName=IP:127.0.0.1', '-keyout', file('key.pem'), '-out', file('cert.pem')], { stdio: 'ignore' });
}

let server;
let port;
before(async () => {
  makeCertificate('first');
  server = await startServer(['--tls-certificate', file('cert.pem'), '--tls-key', file('key.pem'), '--header-time', '3']);
  port = Number(new URL(server.base).port);
});
after(async () => {
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

const curl = (...words) => spawnSync('curl', ['-sS', '--cacert', file('cert.pem'), ...words], { maxBuffer: 1 << 28 });
const subject = () => spawnSync('sh', ['-c', `openssl s_client -connect 127.0.0.1:${port} </dev/null 2>/dev/null | openssl x509 -noout -subject`], { encoding: 'utf8' }).stdout;

test('the server says that it speaks https', () => {
  assert.match(server.base, /^https:/);
});

test('a job goes its way over https, its events end properly, and its outputs are whole', () => {
  const submitted = curl('--fail', '--data-binary', `@${knot}`, `${server.base}/v1/jobs?method=advancing-front`);
  assert.equal(submitted.status, 0, submitted.stderr.toString());
  const { id } = JSON.parse(submitted.stdout);
  const events = curl('--fail', '-N', `${server.base}/v1/jobs/${id}/events`);
  // curl ends with 56 if the server goes without a goodbye: then something may be missing.
  assert.equal(events.status, 0, events.stderr.toString());
  assert.match(events.stdout.toString(), /event: done/);
  const mesh = curl('--fail', '-D', file('head'), `${server.base}/v1/jobs/${id}/outputs/mesh.glb`);
  assert.equal(mesh.status, 0);
  assert.equal(mesh.stdout.readUInt32LE(8), mesh.stdout.length);
  const digest = execFileSync('openssl', ['dgst', '-sha256', '-binary'], { input: mesh.stdout }).toString('base64');
  assert.match(readFileSync(file('head'), 'utf8').toLowerCase(), new RegExp(`repr-digest: sha-256=:${digest.toLowerCase().replace(/[+/]/g, '.')}:`));
  const direct = curl('--fail', '--http1.1', '--tlsv1.2', '--tls-max', '1.2', '--data-binary', `@${knot}`, `${server.base}/v1/reconstruct?method=advancing-front`);
  assert.deepEqual(direct.stdout, mesh.stdout, 'the same over TLS 1.2');
});

test('older versions are refused, and a certificate that the client does not know', () => {
  const old = spawnSync('openssl', ['s_client', '-connect', `127.0.0.1:${port}`, '-tls1_1', '-cipher', 'ALL:@SECLEVEL=0'], { input: '', encoding: 'utf8' });
  assert.notEqual(old.status, 0);
  assert.equal(spawnSync('curl', ['-sS', `${server.base}/healthz`]).status, 60);
});

test('plain HTTP is answered in plain HTTP that this is the wrong port', () => {
  const { status, stdout } = spawnSync('curl', ['-sS', `http://127.0.0.1:${port}/healthz`], { encoding: 'utf8' });
  assert.equal(status, 0);
  assert.equal(JSON.parse(stdout).code, 'invalid_request');
});

test('garbage is cut off at once, half a handshake after its time, and others are served meanwhile', async () => {
  const order = [];
  /** Sends bytes, and notes when the server has ended the connection. */
  const keeps = (name, bytes) => new Promise((resolve) => {
    const socket = net.connect(port, '127.0.0.1', () => socket.write(bytes));
    socket.on('error', () => {});
    socket.on('data', () => {});
    socket.on('close', () => resolve(order.push(name)));
  });
  const began = performance.now();
  const halves = Array.from({ length: 200 }, () => keeps('half', Buffer.from('16030102000100', 'hex')));
  await Promise.all([
    keeps('garbage', Buffer.from('this is no hello\r\n\r\n')),
    new Promise((resolve) => spawn('curl', ['-sS', '--fail', '--cacert', file('cert.pem'), `${server.base}/healthz`], { stdio: 'ignore' })
      .on('close', (code) => resolve(order.push(`curl ${code}`)))),
  ]);
  // A machine that stops for three seconds has ended the halves, too.
  if (performance.now() - began < 2500) assert.deepEqual([...order].sort(), ['curl 0', 'garbage']);
  await Promise.all(halves);
  assert.ok(performance.now() - began > 2500);
  assert.ok(order.includes('curl 0'));
});

test('SIGHUP takes a new certificate, and keeps the old one when the new one is broken', async () => {
  assert.match(subject(), /first/);
  makeCertificate('second');
  server.signal('SIGHUP');
  for (let i = 0; i < 600 && !/second/.test(subject()); ++i) await new Promise((resolve) => setTimeout(resolve, 100));
  assert.match(subject(), /second/);
  writeFileSync(file('cert.pem'), 'broken');
  server.signal('SIGHUP');
  await new Promise((resolve) => setTimeout(resolve, 300));
  assert.match(subject(), /second/);
});

test('half of the settings, and files that cannot be used, are told before anything starts', () => {
  const check = (...flags) => spawnSync(process.env.SURFACED_BIN, ['check-config', '--data', folder, ...flags], { encoding: 'utf8' });
  const half = check('--tls-certificate', file('cert.pem'));
  assert.equal(half.status, 2);
  assert.match(half.stderr, /tls-key is not/);
  const broken = check('--tls-certificate', file('cert.pem'), '--tls-key', file('key.pem'));
  assert.equal(broken.status, 2);
  assert.match(broken.stderr, /cert\.pem cannot be used/);
});
