// SPDX-License-Identifier: GPL-3.0-or-later
// Follows a job by its Server-Sent Events. EventSource cannot send a key, so the stream is read with fetch.
import {ApiError, type Api} from './client';
import type {Job, Problem} from './types';

export interface Watcher {
  state(job: Job): void;
  progress(progress: number, phase: string): void;
  log(lines: string[]): void;
  /** The stream broke off, and is taken up again after the milliseconds; 0 once it is back. */
  lost(again: number): void;
}

export interface SseEvent {
  event: string;
  id: string;
  data: string;
}

/** Cuts a text/event-stream into events; keeps what is not complete yet. */
export class EventCutter {
  private rest = '';

  push(text: string): SseEvent[] {
    const blocks = (this.rest + text).replaceAll('\r\n', '\n').split('\n\n');
    this.rest = blocks.pop() ?? '';
    return blocks.map(parseEvent).filter((event) => event.data !== '');
  }
}

function parseEvent(block: string): SseEvent {
  const event: SseEvent = {event: 'message', id: '', data: ''};
  const data: string[] = [];
  for (const line of block.split('\n')) {
    const colon = line.indexOf(':');
    const name = colon < 0 ? line : line.slice(0, colon);
    const value = colon < 0 ? '' : line.slice(colon + 1).replace(/^ /, '');
    if (name === 'event') event.event = value;
    if (name === 'id') event.id = value;
    if (name === 'data') data.push(value);
  }
  event.data = data.join('\n');
  return event;
}

/** Ends early, and without complaint, if the signal does. */
export const pause = (milliseconds: number, signal: AbortSignal): Promise<void> => new Promise((resolve) => {
  const timer = setTimeout(resolve, milliseconds);
  signal.addEventListener('abort', () => (clearTimeout(timer), resolve()), {once: true});
});

/** Resolves with the job once it has ended; undefined if the signal ended the watching. */
export async function followJob(api: Api, id: string, watcher: Watcher, signal: AbortSignal): Promise<Job|undefined> {
  let last = '';
  for (let wait = 500; !signal.aborted; wait = Math.min(2 * wait, 8000)) {
    try {
      const ended =
          await readStream(api, id, last, (event) => (last = event.id || last), watcher, signal, () => (wait = 500));
      if (ended) return ended;
    } catch (failure) {
      if (signal.aborted) return undefined;
      if (failure instanceof ApiError && failure.status >= 400 && failure.status < 500 && failure.status !== 429)
        throw failure;
    }
    watcher.lost(wait);
    await pause(wait, signal);
  }
  return undefined;
}

async function readStream(
    api: Api, id: string, last: string, seen: (event: SseEvent) => void, watcher: Watcher, signal: AbortSignal,
    alive: () => void): Promise<Job|undefined> {
  const headers: Record<string, string> = {Accept: 'text/event-stream'};
  if (last) headers['Last-Event-ID'] = last;
  const response = await api.fetch(`v1/jobs/${id}/events`, {headers, signal});
  if (response.status === 204 || !response.body) return api.job(id);
  watcher.lost(0);
  alive();
  const cutter = new EventCutter();
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  for (;;) {
    const {done, value} = await reader.read();
    if (done) return undefined;
    for (const event of cutter.push(value)) {
      seen(event);
      const data: unknown = JSON.parse(event.data);
      if (event.event === 'done') return doneJob(data);
      tell(watcher, event.event, data);
    }
  }
}

function doneJob(data: unknown): Job {
  if ((data as Problem).code !== undefined && (data as Job).id === undefined) throw ApiError.of(data as Problem);
  return data as Job;
}

function tell(watcher: Watcher, event: string, data: unknown): void {
  if (event === 'state') watcher.state(data as Job);
  if (event === 'log') watcher.log((data as {lines: string[]}).lines);
  if (event === 'progress') {
    const {progress, phase} = data as {
      progress: number;
      phase: string
    };
    watcher.progress(progress, phase);
  }
}
