// SPDX-License-Identifier: GPL-3.0-or-later
// How a job goes, as words and a share of the whole.
import type {Api} from '../api/client';
import {followJob} from '../api/follow';
import {isEnded, type Job} from '../api/types';
import {seconds} from '../words/numbers';
import {t} from '../words/words';
import type {Work} from './state';

/** So long a work has gone on, and so far, before anybody may say when it ends. */
const kForetold = {
  seconds: 3,
  fraction: 0.1
};

function timeLeft(began: number, fraction: number): string {
  const spent = (performance.now() - began) / 1000;
  if (spent < kForetold.seconds || fraction < kForetold.fraction) return '';
  return ` · ${t.work.left(seconds(Math.max(1, Math.round(spent / fraction - spent))))}`;
}

const placeOf = ({queue_position: before}: Job): string => (before ? t.work.before(before) : t.work.next);

/** Resolves with the job once it has ended; undefined if the signal ended the watching. */
export async function followWork(
    api: Api, begun: Job, told: (work: Omit<Work, 'side'>) => void, signal: AbortSignal): Promise<Job|undefined> {
  let job = begun;
  let phases: string[] = [];
  let fraction: number|undefined;
  const began = performance.now();
  const show = (detail: string): void =>
      told({what: job.status === 'accepted' ? 'queue' : 'run', fraction, detail, job, phases});
  show(placeOf(job));
  if (isEnded(job)) return job;
  return followJob(
      api, job.id, {
        state: (now) => {
          job = now;
          phases = [];
          fraction = undefined;
          if (job.status === 'accepted') show(placeOf(job));
        },
        progress: (progress, phase) => {
          job = {...job, status: 'running'};
          const words = phase.replaceAll(/[-_]/g, ' ');
          if (words !== '' && phases.at(-1) !== words) phases = [...phases, words];
          fraction = progress;
          show(words + timeLeft(began, progress));
        },
        log: () => undefined,
        lost: (again) => {
          if (again > 0) show(t.work.serverLost);
        },
      },
      signal);
}
