// SPDX-License-Identifier: GPL-3.0-or-later
// Turns a point cloud into a mesh with a surfaced server. Runs on Node 18 or newer; the types are those of the contract.
//   npm ci && npm run build && node dist/reconstruct.js --help
import { randomUUID } from 'node:crypto';
import { createReadStream } from 'node:fs';
import { rename, stat, writeFile } from 'node:fs/promises';
import { setTimeout as sleep } from 'node:timers/promises';
import type { paths } from './contract.js';

type Job = paths['/v1/jobs/{id}']['get']['responses'][200]['content']['application/json'];
type Problem = NonNullable<Job['error']>;
interface Distribution { min: number; mean: number }
interface Report {
  mesh: { vertices: number; triangles: number; genus: number | null; closed: boolean };
  quality: { shortest_edge_to_circumradius: Distribution | null; unused_points: number | null };
  warnings: string[];
}

const usage = `usage: node reconstruct.js CLOUD MESH.glb [name=value...]

Uploads the cloud, follows the job, downloads the mesh and prints its quality.
name=value: method=ID and the method's parameters.
SURFACED_URL is the server (default http://127.0.0.1:8080), SURFACED_KEY the key, if it wants one.`;

const server = process.env.SURFACED_URL ?? 'http://127.0.0.1:8080';
const key: Record<string, string> = process.env.SURFACED_KEY ? { Authorization: `Bearer ${process.env.SURFACED_KEY}` } : {};
const tries = 5;
const passing = [429, 502, 503, 504];

/** The server's answer is no, and would be no again. */
class Refused extends Error {}

function show(text: string): void {
  process.stderr.write(process.stderr.isTTY ? `\r\x1b[K${text}` : `${text.trimEnd()}\n`);
}

/** A problem in words; what does not speak JSON is a proxy in between. */
async function said(answer: Response): Promise<string> {
  const problem = (await answer.json().catch(() => null)) as Problem | null;
  return problem ? `${problem.title}: ${problem.detail}. ${problem.hint}` : `${answer.status} ${answer.statusText}`;
}

/** Tries again what may pass: no connection, a lost answer, 429 and 503. */
async function request(path: string, init: () => RequestInit = () => ({})): Promise<Response> {
  let reason = '';
  for (let attempt = 0; attempt < tries; ++attempt) {
    let pause = 0.5 * 2 ** attempt;
    try {
      const { headers, ...rest } = init();
      const answer = await fetch(server + path, { ...rest, headers: { ...key, ...(headers as Record<string, string>) } });
      if (answer.ok) return answer;
      reason = await said(answer);
      if (!passing.includes(answer.status)) throw new Refused(reason);
      pause = Number(answer.headers.get('retry-after') ?? pause);
    } catch (failure) {
      if (failure instanceof Refused) throw failure;
      reason = String((failure as Error).cause ?? failure);
    }
    show(`${reason}; trying again in ${pause} s\n`);
    await sleep(1000 * pause);
  }
  throw new Refused(`given up after ${tries} tries; the last said: ${reason}`);
}

/** The cloud as a request's body, in pieces, telling how much has been sent. */
async function* pieces(cloud: string, size: number): AsyncGenerator<Uint8Array> {
  let sent = 0;
  for await (const piece of createReadStream(cloud)) {
    yield piece as Uint8Array;
    sent += (piece as Uint8Array).length;
    show(`upload ${Math.floor((100 * sent) / size)} %`);
  }
}

/** Events of a job until `done`; where the stream breaks off, a new one goes on. */
async function* events(path: string): AsyncGenerator<{ event: string; data: unknown }> {
  let event = '';
  let last: Record<string, string> = {};
  while (event !== 'done') {
    const stream = await request(path, () => ({ headers: last }));
    let text = '';
    const decoder = new TextDecoder();
    try {
      for await (const bytes of stream.body ?? []) {
        text += decoder.decode(bytes as Uint8Array, { stream: true });
        for (let end = text.indexOf('\n\n'); end >= 0; end = text.indexOf('\n\n')) {
          const fields = new Map(text.slice(0, end).split('\n').map((line) => line.split(/: (.*)/, 2) as [string, string]));
          text = text.slice(end + 2);
          if (!fields.has('data')) continue;
          event = fields.get('event') ?? '';
          last = { 'Last-Event-ID': fields.get('id') ?? '' };
          yield { event, data: JSON.parse(fields.get('data') ?? 'null') };
        }
      }
    } catch (failure) {
      show(`${String(failure)}; following on\n`);
    }
    await sleep(100);
  }
}

async function reconstruct(cloud: string, mesh: string, parameters: string[]): Promise<Report> {
  const { size } = await stat(cloud);
  // With this key a submission whose answer was lost can be repeated: it makes no second job.
  const headers = { 'Idempotency-Key': randomUUID(), 'Content-Type': 'application/octet-stream' };
  const query = new URLSearchParams(parameters.map((each) => each.split(/=(.*)/s, 2) as [string, string]));
  const submission = () => ({ method: 'POST', headers, body: pieces(cloud, size), duplex: 'half' }) as unknown as RequestInit;
  let job = (await (await request(`/v1/jobs?${query}`, submission)).json()) as Job;
  show(`job ${job.id}\n`);
  for await (const { event, data } of events(`/v1/jobs/${job.id}/events`)) {
    if (event === 'progress') {
      const { phase, progress } = data as Pick<Job, 'phase' | 'progress'>;
      show(`${phase || 'waiting'} ${Math.round(100 * progress)} %`);
    }
    if (event === 'done') job = data as Job;
  }
  if (job.status !== 'successful') throw new Refused(`${job.status}: ${job.error?.detail ?? 'the job was removed'}`);
  const content = await request(`/v1/jobs/${job.id}/outputs/mesh.glb`);
  await writeFile(`${mesh}.part`, Buffer.from(await content.arrayBuffer()));
  await rename(`${mesh}.part`, mesh);
  return (await (await request(`/v1/jobs/${job.id}/outputs/report.json`)).json()) as Report;
}

const [cloud, mesh, ...parameters] = process.argv.slice(2);
if (cloud === '--help' || !mesh || !parameters.every((each) => each.includes('='))) {
  (cloud === '--help' ? console.log : console.error)(usage);
  process.exit(cloud === '--help' ? 0 : 2);
}
try {
  const { mesh: made, quality, warnings } = await reconstruct(cloud!, mesh, parameters);
  const shape = quality.shortest_edge_to_circumradius;
  console.log(`${made.vertices} vertices, ${made.triangles} triangles, genus ${made.genus}, closed: ${made.closed}`);
  console.log(`shortest edge / circumradius: min ${shape?.min.toFixed(3)}, mean ${shape?.mean.toFixed(3)} (equilateral: 1.732)`);
  console.log(`unused points: ${quality.unused_points}`);
  warnings.forEach((warning) => console.log(`warning: ${warning}`));
} catch (failure) {
  console.error(`reconstruct: ${(failure as Error).message}`);
  process.exit(1);
}
