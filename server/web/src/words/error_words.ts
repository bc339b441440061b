// SPDX-License-Identifier: GPL-3.0-or-later
// What went wrong, for people: the server's words are for whoever writes a program, too.
import type {ApiError} from '../api/client';
import {t} from './words';

export interface ErrorWords {
  title: string;
  detail: string;
  hint: string;
}

export function errorWords({code, title, detail, hint}: ApiError): ErrorWords {
  const own = t.errors.people[code] ?? {};
  return {title: own.title ?? title, detail: own.detail ?? detail, hint: own.hint ?? hint};
}
