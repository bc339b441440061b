// SPDX-License-Identifier: GPL-3.0-or-later
// The worker, as the page calls it.
import type {Answer, GeometryCalls, Question} from './protocol';

export type Geometry = GeometryCalls;

export function startGeometry(): Geometry {
  const worker = new Worker(new URL('./geometry_worker.ts', import.meta.url), {type: 'module'});
  const open = new Map < number, {
    resolve: (value: unknown) => void;
    reject: (failure: Error) => void
  }
  > ();
  let questions = 0;
  const fail = (failure: Error): void => {
    for (const {reject} of open.values()) reject(failure);
    open.clear();
  };
  worker.onmessage = ({data}: MessageEvent<Answer>) => {
    const waiting = open.get(data.id);
    open.delete(data.id);
    if (data.error === undefined)
      waiting?.resolve(data.value);
    else
      waiting?.reject(new Error(data.error));
  };
  worker.onerror = (event) => fail(new Error(event.message || 'the worker of this page could not be started'));
  const ask = (call: keyof GeometryCalls) => (...words: unknown[]) => new Promise((resolve, reject) => {
    const question: Question = {id: ++questions, call, words};
    open.set(question.id, {resolve, reject});
    worker.postMessage(question, words.filter((word): word is ArrayBuffer => word instanceof ArrayBuffer));
  });
  return new Proxy({} as Geometry, {get: (_, call) => ask(call as keyof GeometryCalls)});
}
