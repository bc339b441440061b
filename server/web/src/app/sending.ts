// SPDX-License-Identifier: GPL-3.0-or-later
// The way of a cloud to the server, and of a job into its queue.
import {ApiError, type Api} from '../api/client';
import {pause} from '../api/follow';
import type {Job, Submission} from '../api/types';
import {uploadCloud} from '../api/upload';
import {bytes} from '../words/numbers';
import {t} from '../words/words';
import {keepCloud} from './kept_clouds';

/** How far the upload is, 0 to 1; none if nobody knows. */
export type Told = (fraction: number|undefined, detail: string) => void;

const kSubmissions = 4;
/** The longest label that the contract takes. */
const kLabel = 64;

function randomKey(): string {
  return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, '0')).join('');
}

/** Resolves with the id of the stored cloud. */
export async function sendCloud(api: Api, file: File, told: Told, signal: AbortSignal): Promise<string> {
  const total = bytes(file.size);
  let fraction = 0;
  told(0, t.work.of('0', total));
  const watcher = {
    progress: (sent: number) => {
      fraction = sent / file.size;
      told(fraction, t.work.of(bytes(sent), total));
    },
    interrupted: () => told(fraction, t.work.lost),
  };
  const id = await uploadCloud(api, file, watcher, signal);
  void keepCloud(id, file);
  return id;
}

export function submissionOf(
    cloud_id: string, name: string, method: string, parameters: Record<string, unknown>): Submission {
  // The name goes with the job, so that its link and the list of jobs say on every device what it is.
  const label = Array.from(name.trim()).slice(0, kLabel).join('');
  return {
    cloud_id,
    method,
    parameters,
    outputs: ['mesh.glb', 'report.json', 'log.txt'],
    ...(label ? {labels: [label]} : {}),
  };
}

/** Sent again under the same key when the answer is lost, it makes no second job. */
export async function sendJob(api: Api, submission: Submission, signal: AbortSignal): Promise<Job> {
  const key = randomKey();
  for (let attempt = 1;; attempt += 1) {
    try {
      // Without the signal: who does not hear the answer does not know which job to cancel.
      const job = await api.submit(submission, key);
      if (signal.aborted) await api.cancel(job.id).catch(() => undefined);
      signal.throwIfAborted();
      return job;
    } catch (failure) {
      signal.throwIfAborted();
      const again = failure instanceof ApiError && (failure.status === 0 || failure.code === 'queue_full') &&
          attempt < kSubmissions;
      if (!again) throw failure;
      await pause(1000 * attempt, signal);
      signal.throwIfAborted();
    }
  }
}
