// SPDX-License-Identifier: GPL-3.0-or-later
// The table of words in the language of the page. Another language is another table: a copy of en.ts, named here and in
// language.ts; the compiler says which words it lacks.
import {de} from './de';
import {en, type Words} from './en';
import {language} from './language';

const tables: Record<typeof language, Words> = {
  en,
  de
};
export const t: Words = tables[language];
