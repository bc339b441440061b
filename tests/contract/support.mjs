// SPDX-License-Identifier: GPL-3.0-or-later
// A running server, and the contract to hold it to.
import { spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { createInterface } from 'node:readline';
import Ajv2020 from 'ajv/dist/2020.js';
import addFormats from 'ajv-formats';

export const source = process.env.SURFACED_SOURCE;
export const readJson = (file) => JSON.parse(readFileSync(path.join(source, file), 'utf8'));

export function newAjv() {
  const ajv = new Ajv2020({ strict: true, allowUnionTypes: true, allErrors: true, strictTypes: false, strictRequired: false });
  addFormats(ajv);
  ajv.addVocabulary(['x-unit', 'x-allowed', 'components']);
  return ajv;
}

/** Starts the daemon on a free port with a data folder of its own. */
export async function startServer(flags = []) {
  const data = mkdtempSync(path.join(tmpdir(), 'surfaced-contract-'));
  const child = spawn(process.env.SURFACED_BIN, ['serve', '--listen', '127.0.0.1:0', '--data', data, ...flags], {
    stdio: ['ignore', 'pipe', 'inherit'],
  });
  const base = await new Promise((resolve, reject) => {
    child.once('exit', (code) => reject(new Error(`the server ended with ${code}`)));
    createInterface({ input: child.stdout }).on('line', (line) => {
      const found = /https?:\/\/\S+/.exec(line);
      if (found) resolve(found[0].replace(/\/$/, ''));
    });
  });
  const stop = async () => {
    const ended = new Promise((resolve) => child.once('exit', resolve));
    child.kill('SIGTERM');
    await ended;
    rmSync(data, { recursive: true, force: true });
  };
  const children = () => readdirSync(`/proc/${child.pid}/task`).flatMap((task) =>
    readFileSync(`/proc/${child.pid}/task/${task}/children`, 'utf8').split(' ').filter(Boolean).map(Number));
  return { base, stop, children, signal: (name) => child.kill(name) };
}

/** Checks answers against the operations of the contract, and keeps a tally of what was seen. */
export class Contract {
  constructor(document) {
    this.document = document;
    this.seen = new Set();
    this.ajv = newAjv();
    this.ajv.addSchema({ $id: 'contract', components: document.components }, 'contract');
  }

  resolve(node) {
    return node?.$ref ? node.$ref.slice(2).split('/').reduce((at, key) => at[key], this.document) : node;
  }

  operation(method, pathname) {
    for (const [template, item] of Object.entries(this.document.paths)) {
      const pattern = new RegExp(`^${template.replace(/\{[^}]+\}/g, '[^/]+')}$`);
      // A path that answers GET answers HEAD.
      const operation = item[method] ?? (method === 'head' ? item.get : undefined);
      if (pattern.test(pathname) && operation) return { template, operation };
    }
    return null;
  }

  /** Returns the decoded body; throws with the reason if the contract does not know such an answer. */
  async check(method, url, response) {
    const { pathname } = new URL(url);
    const found = this.operation(method.toLowerCase(), pathname);
    const declared = found
      ? this.resolve(found.operation.responses[response.status] ?? (response.status >= 400 ? found.operation.responses.default : undefined))
      : this.resolve(this.document.components.responses.Problem);
    if (!declared || (!found && response.status < 400)) throw new Error(`${method} ${pathname}: ${response.status} is not in the contract`);
    if (found) this.seen.add(`${method.toLowerCase()} ${found.template} ${response.status}`);
    const bytes = Buffer.from(await response.arrayBuffer());
    if (!declared.content || method === 'HEAD') return bytes;
    const type = (response.headers.get('content-type') ?? '').split(';')[0];
    const media = declared.content[type];
    if (!media) throw new Error(`${method} ${pathname}: content type '${type}' of ${response.status} is not in the contract`);
    if (!type.endsWith('json') || response.status === 206) return bytes;
    const body = JSON.parse(bytes.toString('utf8'));
    this.validate(media.schema, body, `${method} ${pathname} ${response.status}`);
    return body;
  }

  validate(schema, value, what) {
    const absolute = JSON.parse(JSON.stringify(schema).replaceAll('"#/', '"contract#/'));
    const validator = this.ajv.compile(absolute);
    if (!validator(value)) throw new Error(`${what}: ${this.ajv.errorsText(validator.errors)}\n${JSON.stringify(value).slice(0, 2000)}`);
  }
}
