// SPDX-License-Identifier: GPL-3.0-or-later
// A server of one's own with a client that checks every answer against the contract.
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { Contract, source, startServer } from './support.mjs';

export const knot = readFileSync(path.join(source, 'client-examples/samples/knot.ply'));

/** Points on a sphere, as ASCII PLY. */
export function sphere(count, radius = 1) {
  const lines = [];
  for (let i = 0; i < count; ++i) {
    const z = 1 - (2 * i + 1) / count;
    const angle = i * Math.PI * (3 - Math.sqrt(5));
    const r = Math.sqrt(1 - z * z);
    lines.push(`${radius * r * Math.cos(angle)} ${radius * r * Math.sin(angle)} ${radius * z}`);
  }
  return Buffer.from(`ply\nformat ascii 1.0\nelement vertex ${count}\nproperty float x\nproperty float y\nproperty float z\nend_header\n${lines.join('\n')}\n`);
}

export class Client {
  static async start(flags = []) {
    const client = new Client();
    client.server = await startServer(flags);
    client.base = client.server.base;
    client.contract = new Contract(await (await fetch(`${client.base}/openapi.json`)).json());
    client.headers = {};
    return client;
  }

  stop() {
    return this.server.stop();
  }

  /** The same server with another key. */
  as(key) {
    const other = Object.assign(new Client(), this);
    other.headers = key ? { authorization: `Bearer ${key}` } : {};
    return other;
  }

  async call(method, target, options = {}) {
    const url = this.base + target;
    const response = await fetch(url, { method, redirect: 'manual', ...options, headers: { ...this.headers, ...options.headers } });
    const body = await this.contract.check(method, url, response);
    return { status: response.status, headers: response.headers, body };
  }

  post(target, body, headers = { 'content-type': 'application/octet-stream' }) {
    return this.call('POST', target, { body, headers });
  }

  json(target, body, headers = {}) {
    return this.call('POST', target, { body: JSON.stringify(body), headers: { 'content-type': 'application/json', ...headers } });
  }

  async until(look, enough) {
    const deadline = performance.now() + 90_000;
    while (performance.now() < deadline) {
      const { body } = await look();
      if (enough(body)) return body;
      await new Promise((resolve) => setTimeout(resolve, 50));
    }
    throw new Error('it did not happen in 90 s');
  }

  /** Stops the process of a job in the middle of its work, so that the job goes on until it is dismissed. */
  async freeze(id, key) {
    const work = ({ status, phase }) => status === 'running' && phase && phase !== 'read';
    const client = key ? this.as(key) : this;
    await client.until(() => client.call('GET', `/v1/jobs/${id}`), work);
    const [child] = this.server.children().filter((each) => readFileSync(`/proc/${each}/cmdline`, 'utf8').includes(id));
    process.kill(-child, 'SIGSTOP');
  }

  async finished(id) {
    for (let i = 0; i < 20; ++i) {
      const { body } = await this.call('GET', `/v1/jobs/${id}?wait=10`);
      if (!['accepted', 'running'].includes(body.status)) return body;
    }
    throw new Error('the job did not end');
  }
}
