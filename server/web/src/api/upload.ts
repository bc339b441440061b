// SPDX-License-Identifier: GPL-3.0-or-later
// Sends a cloud with tus: what has arrived counts, also when the connection is lost or the page is closed meanwhile.
import {DetailedError, Upload} from 'tus-js-client';
import {ApiError, unreachable, type Api} from './client';
import {t} from '../words/words';
import type {Problem} from './types';

export interface UploadWatcher {
  progress(sent: number, total: number): void;
  /** The connection broke off; it is tried again. */
  interrupted(): void;
}

const kRetries = [500, 1000, 2000, 4000, 8000, 8000, 8000, 8000];

/** Resolves with the id of the stored cloud. */
export function uploadCloud(api: Api, file: File, watcher: UploadWatcher, signal: AbortSignal): Promise<string> {
  return new Promise((resolve, reject) => {
    let cloudId = '';
    const upload = new Upload(file, {
      endpoint: api.url('v1/uploads'),
      retryDelays: kRetries,
      removeFingerprintOnSuccess: true,
      metadata: {filename: file.name},
      onBeforeRequest: (request) => {
        if (api.key) request.setHeader('Authorization', `Bearer ${api.key}`);
      },
      onAfterResponse: (_request, response) => {
        cloudId = response.getHeader('Surfaced-Cloud-Id') ?? cloudId;
      },
      onProgress: (sent, total) => watcher.progress(sent, total ?? file.size),
      onShouldRetry: (failure) => {
        const status = failure instanceof DetailedError ? (failure.originalResponse?.getStatus() ?? 0) : 0;
        const again = status === 0 || status === 409 || status === 423 || status === 429 || status >= 500;
        if (again) watcher.interrupted();
        return again;
      },
      onError: (failure) => reject(errorOf(failure)),
      onSuccess: () => (cloudId ? resolve(cloudId) : reject(unreachable(t.errors.uploadUnnamed))),
    });
    const stop = (): void => {
      reject(signal.reason as Error);
      void upload.abort().catch(() => undefined);
    };
    if (signal.aborted) stop();
    signal.addEventListener('abort', stop, {once: true});
    void upload.findPreviousUploads().then((earlier) => {
      const latest = earlier.at(-1);
      if (latest) upload.resumeFromPreviousUpload(latest);
      if (!signal.aborted) upload.start();
    }, reject);
  });
}

function errorOf(failure: Error): ApiError {
  const response = failure instanceof DetailedError ? failure.originalResponse : null;
  if (response) {
    try {
      return ApiError.of(JSON.parse(response.getBody()) as Problem);
    } catch {
      return new ApiError(
          'unknown', t.errors.answered(response.getStatus()), t.errors.uploadRefused, '', response.getStatus());
    }
  }
  return unreachable(t.errors.uploadLost);
}
