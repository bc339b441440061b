// SPDX-License-Identifier: GPL-3.0-or-later
// A job for each of several files, by the same method and parameters.
import {ApiError} from '../api/client';
import {t} from '../words/words';

import {sendCloud, sendJob, submissionOf} from './sending';

import type {Session} from './session';
import type {Run} from './state';

/** The files that could not be sent stay chosen. */
export function runBatch(session: Session, files: File[], run: Run): Promise<void> {
  return session.begin(async (signal) => {
    const failed: {file: File; why: Error}[] = [];
    for (const [i, file] of files.entries()) {
      const told = (fraction: number|undefined, detail: string): void => session.work(
          {
            side: 0,
            what: 'upload',
            fraction: (i + (fraction ?? 0)) / files.length,
            detail: `${file.name}: ${detail} · ${t.batch.sent(String(i), String(files.length))}`
          },
          signal);
      try {
        if (file.size === 0) throw new Error(t.cloud.empty);
        const id = await sendCloud(session.api, file, told, signal);
        await sendJob(session.api, submissionOf(id, file.name, run.method, run.parameters), signal);
      } catch (failure) {
        signal.throwIfAborted();
        failed.push({file, why: failure instanceof Error ? failure : new Error(String(failure))});
      }
    }
    await session.refreshHistory();
    const [first] = failed;
    session.change(
        {dropped: failed.map(({file}) => file), work: undefined, notice: t.batch.done(files.length - failed.length)});
    if (!first) return;
    const why = first.why instanceof ApiError ? first.why.detail : first.why.message;
    throw new ApiError(
        'page', t.errors.page, `${t.batch.failed(failed.map(({file}) => file.name).join(', '))}: ${why}`, '');
  });
}
