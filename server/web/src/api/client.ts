// SPDX-License-Identifier: GPL-3.0-or-later
// Calls of the API. Everything that goes wrong becomes an ApiError with the words of the server, or of the network.
import {t} from '../words/words';
import type {Cloud, Job, Method, Problem, Report, Sample, Submission} from './types';

export class ApiError extends Error {
  constructor(
      readonly code: string,
      readonly title: string,
      readonly detail: string,
      readonly hint: string,
      readonly status = 0,
      readonly requestId = '',
      /** The parameter that is wrong, if it is one. */
      readonly field = '',
  ) {
    super(`${title}: ${detail}`);
  }

  static of(problem: Problem): ApiError {
    const {code, title, detail, hint, status, request_id, field} = problem;
    return new ApiError(
        code ?? 'unknown', title ?? t.errors.somethingWrong, detail ?? '', hint ?? '', status ?? 0, request_id ?? '',
        field ?? '');
  }
}

export const unreachable = (what: string): ApiError =>
    new ApiError('unreachable', t.errors.unreachable, what, t.errors.unreachableHint);

const kKey = 'surfaced.key';

export class Api {
  /** Below a proxy's prefix everything is, too. */
  readonly base = new URL('.', document.baseURI);
  private secret = sessionStorage.getItem(kKey) ?? '';

  get key(): string {
    return this.secret;
  }

  set key(text: string) {
    this.secret = text;
    if (text)
      sessionStorage.setItem(kKey, text);
    else
      sessionStorage.removeItem(kKey);
  }

  url(path: string): string {
    return new URL(path.replace(/^\//, ''), this.base).href;
  }

  headers(extra: Record<string, string> = {}): Record<string, string> {
    return this.secret ? {...extra, Authorization: `Bearer ${this.secret}`} : extra;
  }

  async fetch(path: string, options: RequestInit = {}): Promise<Response> {
    let response: Response;
    try {
      response =
          await fetch(this.url(path), {...options, headers: this.headers(options.headers as Record<string, string>)});
    } catch (failure) {
      if (options.signal?.aborted) throw failure;
      throw unreachable(t.errors.noAnswer(`${options.method ?? 'GET'} ${path}`));
    }
    if (response.ok || response.status === 304) return response;
    throw await problemOf(response);
  }

  async json<T>(path: string, options: RequestInit = {}): Promise<T> {
    return (await (await this.fetch(path, options)).json()) as T;
  }

  async methods(): Promise<Method[]> {
    return (await this.json<{methods: Method[]}>('v1/methods')).methods;
  }

  async samples(): Promise<Sample[]> {
    return (await this.json<{samples: Sample[]}>('samples')).samples;
  }

  job = (id: string, signal: AbortSignal|null = null): Promise<Job> =>
      this.json<Job>(`v1/jobs/${encodeURIComponent(id)}`, {signal});
  cloud = (id: string): Promise<Cloud> => this.json<Cloud>(`v1/clouds/${encodeURIComponent(id)}`);
  report = (id: string, signal: AbortSignal|null = null): Promise<Report> =>
      this.json<Report>(`v1/jobs/${encodeURIComponent(id)}/outputs/report.json`, {signal});

  async jobs(limit: number): Promise<Job[]> {
    return (await this.json<{jobs: Job[]}>(`v1/jobs?limit=${limit}`)).jobs;
  }

  remove = (id: string): Promise<Job> => this.json<Job>(`v1/jobs/${id}`, {method: 'DELETE'});

  submit(submission: Submission, idempotencyKey: string): Promise<Job> {
    return this.json<Job>('v1/jobs', {
      method: 'POST',
      headers: {'Content-Type': 'application/json', 'Idempotency-Key': idempotencyKey},
      body: JSON.stringify(submission),
    });
  }

  cancel = (id: string): Promise<Job> => this.json<Job>(`v1/jobs/${id}`, {method: 'DELETE'});
  retry = (id: string): Promise<Job> => this.json<Job>(`v1/jobs/${id}/retry`, {method: 'POST'});

  /** The bytes of an output; tells how much has arrived. */
  async bytes(path: string, onProgress: (fraction: number) => void, signal?: AbortSignal): Promise<ArrayBuffer> {
    const response = await this.fetch(path, signal ? {signal} : {});
    const total = Number(response.headers.get('content-length') ?? 0);
    // Of a compressed answer the length is that of its compressed form.
    if (!response.body || !total || response.headers.has('content-encoding')) return response.arrayBuffer();
    const whole = new Uint8Array(total);
    const reader = response.body.getReader();
    for (let at = 0;;) {
      const {done, value} = await reader.read();
      if (done) return at === total ? whole.buffer : Promise.reject(unreachable(t.errors.brokeOff(path, at, total)));
      whole.set(value, at);
      at += value.length;
      onProgress(at / total);
    }
  }
}

async function problemOf(response: Response): Promise<ApiError> {
  try {
    return ApiError.of((await response.json()) as Problem);
  } catch {
    return new ApiError(
        'unknown', t.errors.answered(response.status), response.statusText, t.errors.later, response.status);
  }
}
