// SPDX-License-Identifier: GPL-3.0-or-later
// tus 1.0: by the letter, and with tus-js-client through a connection that breaks.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import net from 'node:net';
import { after, before, test } from 'node:test';
import { Upload } from 'tus-js-client';
import { Client, knot } from './client.mjs';

let client;
before(async () => {
  client = await Client.start();
});
after(() => client?.stop());

const tus = { 'tus-resumable': '1.0.0' };
const sha256 = createHash('sha256').update(knot).digest('hex');
const create = (length = knot.length, headers = {}) =>
  client.call('POST', '/v1/uploads', { headers: { ...tus, 'upload-length': String(length), ...headers } });
const patch = (target, offset, body, headers = {}) =>
  client.call('PATCH', target, { body, headers: { ...tus, 'content-type': 'application/offset+octet-stream', 'upload-offset': String(offset), ...headers } });
const expect = async (status, code, answer) => {
  const { status: got, body } = await answer;
  assert.equal(`${got} ${body.code}`, `${status} ${code}`, body.detail);
};

test('the server says what of tus it speaks', async () => {
  const { status, headers } = await client.call('OPTIONS', '/v1/uploads');
  assert.equal(status, 204);
  assert.equal(headers.get('tus-version'), '1.0.0');
  assert.deepEqual(headers.get('tus-extension').split(','), ['creation', 'checksum', 'termination', 'expiration']);
  assert.ok(headers.get('tus-checksum-algorithm').includes('sha1'));
  assert.ok(Number(headers.get('tus-max-size')) > 0);
});

test('what of tus is not spoken is refused, not ignored', async () => {
  await expect(400, 'invalid_request', create(10, { 'upload-concat': 'partial' }));
  await expect(400, 'invalid_request', create(10, { 'upload-concat': 'final;/v1/uploads/a /v1/uploads/b' }));
  await expect(400, 'invalid_request', create(10, { 'upload-defer-length': '1' }));
});

test('an upload in parts becomes a stored cloud', async () => {
  const created = await create(knot.length, { 'upload-metadata': `filename ${Buffer.from('knot.ply').toString('base64')}` });
  assert.equal(created.status, 201);
  const target = created.headers.get('location');
  const first = await patch(target, 0, knot.subarray(0, 1000));
  assert.equal(first.status, 204);
  assert.equal(first.headers.get('upload-offset'), '1000');
  const head = await client.call('HEAD', target, { headers: tus });
  assert.equal(head.headers.get('upload-offset'), '1000');
  assert.equal(head.headers.get('upload-length'), String(knot.length));
  assert.match(head.headers.get('upload-metadata'), /^filename /);
  assert.ok(new Date(head.headers.get('upload-expires')) > new Date());
  await expect(409, 'upload_offset_mismatch', patch(target, 999, knot.subarray(999)));
  const last = await patch(target, 1000, knot.subarray(1000));
  assert.equal(last.headers.get('surfaced-cloud-id'), sha256);
  assert.equal((await client.call('GET', target)).body.cloud_id, sha256);
  const job = await client.json('/v1/jobs', { cloud_id: sha256, method: 'advancing-front' });
  assert.equal((await client.finished(job.body.id)).status, 'successful');
});

test('a part counts only with the right checksum', async () => {
  const target = (await create()).headers.get('location');
  const part = knot.subarray(0, 500);
  const sum = (algorithm, bytes) => `${algorithm} ${createHash(algorithm).update(bytes).digest('base64')}`;
  await expect(460, 'checksum_mismatch', patch(target, 0, part, { 'upload-checksum': sum('sha1', knot) }));
  assert.equal((await client.call('HEAD', target, { headers: tus })).headers.get('upload-offset'), '0');
  assert.equal((await patch(target, 0, part, { 'upload-checksum': sum('sha1', part) })).headers.get('upload-offset'), '500');
  await expect(400, 'invalid_request', patch(target, 500, part, { 'upload-checksum': 'crc9 AAAA' }));
});

test('wrong requests have their codes', async () => {
  const target = (await create(100)).headers.get('location');
  await expect(412, 'unsupported_tus_version', client.call('POST', '/v1/uploads', { headers: { 'upload-length': '1' } }));
  await expect(412, 'unsupported_tus_version', client.call('DELETE', target, { headers: { 'tus-resumable': '0.2.2' } }));
  await expect(400, 'invalid_request', client.call('POST', '/v1/uploads', { headers: tus }));
  await expect(400, 'invalid_request', create('x'));
  await expect(422, 'empty_input', create(0));
  await expect(413, 'payload_too_large', create(2 ** 50));
  await expect(415, 'unsupported_media_type', patch(target, 0, 'x', { 'content-type': 'text/plain' }));
  await expect(413, 'payload_too_large', patch(target, 0, Buffer.alloc(101)));
  await expect(404, 'upload_not_found', client.call('GET', '/v1/uploads/nothing'));
  assert.equal((await client.call('DELETE', target, { headers: tus })).status, 204);
  await expect(410, 'upload_gone', patch(target, 0, 'x'));
  await expect(410, 'upload_gone', client.call('GET', target));
});

/** Forwards connections, and cuts the first that has carried so many bytes; further ones wait until `settled`. */
function breakingProxy(port, bytes, settled) {
  let cuts = 0;
  const server = net.createServer(async (incoming) => {
    incoming.on('error', () => {});
    // What the server makes of a cut takes its time.
    if (cuts > 0) await settled();
    const outgoing = net.connect(port, '127.0.0.1');
    let carried = 0;
    incoming.on('data', (data) => {
      carried += data.length;
      if (cuts === 0 && carried > bytes) {
        ++cuts;
        outgoing.write(data.subarray(0, data.length / 2), () => {
          incoming.destroy();
          outgoing.destroy();
        });
      } else {
        outgoing.write(data);
      }
    });
    outgoing.pipe(incoming);
    for (const socket of [incoming, outgoing]) socket.on('error', () => {});
    incoming.on('close', () => outgoing.destroy());
    outgoing.on('close', () => incoming.destroy());
  });
  return new Promise((resolve) => server.listen(0, '127.0.0.1', () => resolve({ server, cuts: () => cuts })));
}

test('tus-js-client goes on where the connection was cut', async () => {
  const offsets = [];
  let target;
  const offset = async () => Number((await client.call('HEAD', new URL(target).pathname, { headers: tus })).headers.get('upload-offset'));
  const proxy = await breakingProxy(Number(new URL(client.base).port), 20000,
    () => client.until(async () => ({ body: await offset() }), (received) => received > 0));
  try {
    const upload = await new Promise((resolve, reject) => {
      const started = new Upload(knot, {
        endpoint: `http://127.0.0.1:${proxy.server.address().port}/v1/uploads`,
        chunkSize: 50000,
        retryDelays: [100, 100, 100, 100, 1000, 5000],
        metadata: { filename: 'knot.ply' },
        onUploadUrlAvailable: () => { target = started.url; },
        onAfterResponse: (request, response) => {
          if (request.getMethod() === 'HEAD') offsets.push(Number(response.getHeader('upload-offset')));
        },
        onError: reject,
        onSuccess: () => resolve(started),
      });
      started.start();
    });
    assert.equal(proxy.cuts(), 1, 'the connection was cut');
    assert.ok(offsets.length >= 1 && offsets[0] > 0, `it went on from ${offsets}, not from the beginning`);
    const id = new URL(upload.url).pathname;
    assert.equal((await client.call('GET', id)).body.cloud_id, sha256);
  } finally {
    proxy.server.close();
  }
});
