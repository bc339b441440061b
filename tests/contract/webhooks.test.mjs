// SPDX-License-Identifier: GPL-3.0-or-later
// Webhooks: signed, told until somebody listens, never to private addresses unless the operator says so.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { createHmac } from 'node:crypto';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import https from 'node:https';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { Client, sphere } from './client.mjs';

const folder = mkdtempSync(path.join(tmpdir(), 'surfaced-webhooks-'));
const file = (name) => path.join(folder, name);
const secret = 'a secret of more than sixteen characters';
let receiver;
let answers = [];
const calls = [];

before(async () => {
  writeFileSync(file('secret'), `${secret}\n`);
  execFileSync('openssl', ['req', '-x509', '-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:prime256v1', '-nodes', '-days', '1',
    '-subj', '/CN=localhost', '-addext', 'subjectAltName=IP:127.0.0.1', '-keyout', file('key.pem'), '-out', file('cert.pem')], { stdio: 'ignore' });
  receiver = https.createServer({ key: readFileSync(file('key.pem')), cert: readFileSync(file('cert.pem')) }, (request, response) => {
    let body = '';
    request.on('data', (bytes) => { body += bytes; });
    request.on('end', () => {
      calls.push({ headers: request.headers, body });
      response.writeHead(answers.shift() ?? 200);
      response.end();
    });
  });
  await new Promise((resolve) => receiver.listen(0, '127.0.0.1', resolve));
});
after(() => {
  receiver?.close();
  rmSync(folder, { recursive: true, force: true });
});

const url = () => `https://127.0.0.1:${receiver.address().port}/hook`;
const withServer = async (flags, work) => {
  const client = await Client.start(['--webhook-secret', file('secret'), '--webhook-certificates', file('cert.pem'), ...flags]);
  try {
    await work(client);
  } finally {
    await client.stop();
  }
};
const delivery = (client, id, enough) => client.until(
  async () => ({ body: (await client.call('GET', `/v1/jobs/${id}/deliveries`)).body.deliveries[0] ?? {} }), enough);

test('the end of a job is told, signed, and told again when nobody took it', () => withServer(['--webhook-private', 'yes'], async (client) => {
  answers = [503];
  const { body } = await client.post(`/v1/jobs?method=advancing-front&webhook=${encodeURIComponent(url())}`, sphere(60));
  const told = await delivery(client, body.id, (each) => each.status === 'delivered');
  assert.equal(told.attempts, 2);
  assert.equal(told.http_status, 200);
  assert.equal(calls.length, 2);
  for (const { headers, body: text } of calls) {
    const signed = `${headers['webhook-id']}.${headers['webhook-timestamp']}.${text}`;
    assert.equal(headers['webhook-signature'], `v1,${createHmac('sha256', secret).update(signed).digest('base64')}`);
    assert.equal(headers['webhook-id'], told.id, 'the same id, so that the receiver can tell a repetition');
    const event = JSON.parse(text);
    assert.equal(event.type, 'job.successful');
    assert.equal(event.data.id, body.id);
  }
}));

test('a slow receiver keeps back its own deliveries, one at a time, and nobody else\'s', { timeout: 120_000 }, () => withServer(['--webhook-private', 'yes'], async (client) => {
  const open = new Set();
  let most = 0;
  const slow = https.createServer({ key: readFileSync(file('key.pem')), cert: readFileSync(file('cert.pem')) }, (request, response) => {
    open.add(response);
    most = Math.max(most, open.size);
    response.on('close', () => open.delete(response));
  });
  await new Promise((resolve) => slow.listen(0, '127.0.0.1', resolve));
  try {
    const submit = (to) => client.post(`/v1/jobs?method=advancing-front&webhook=${encodeURIComponent(to)}`, sphere(60));
    for (let i = 0; i < 4; ++i) await submit(`https://127.0.0.1:${slow.address().port}/hook`);
    await client.until(async () => ({ body: open.size }), (size) => size === 1);
    const { body } = await submit(url());
    const told = await delivery(client, body.id, (each) => each.status === 'delivered');
    assert.equal(told.status, 'delivered');
    assert.equal(open.size, 1, 'the first one has not ended yet');
    assert.equal(most, 1, 'at most one at a time');
  } finally {
    slow.closeAllConnections();
    slow.close();
  }
}));

test('a private address is not told', () => withServer([], async (client) => {
  const before_ = calls.length;
  const { body } = await client.post(`/v1/jobs?method=advancing-front&webhook=${encodeURIComponent(url())}`, sphere(60));
  const refused = await delivery(client, body.id, (each) => each.attempts > 0);
  assert.equal(refused.status, 'pending');
  assert.match(refused.detail, /not public/);
  const named = await client.post(`/v1/jobs?method=advancing-front&webhook=${encodeURIComponent('https://localhost/hook')}`, sphere(60));
  const { detail } = await delivery(client, named.body.id, (each) => each.attempts > 0);
  assert.match(detail, /localhost/);
  assert.doesNotMatch(detail, /127\.0|::1/, 'what a name of this network leads to is nobody\'s business');
  assert.equal(calls.length, before_);
}));
