// SPDX-License-Identifier: GPL-3.0-or-later
// The language of the page: what was chosen here before, else the first of the browser's that there is a table for.
export type Language = 'en'|'de';
export const languages: Record<Language, string> = {
  en: 'English',
  de: 'Deutsch',
};

const kKept = 'surfaced.language';

function chosen(): Language {
  if (typeof document === 'undefined') return 'en';
  const wanted =
      [localStorage.getItem(kKept) ?? '', ...navigator.languages].map((each) => each.slice(0, 2).toLowerCase());
  return (wanted.find((each) => each in languages) ?? 'en') as Language;
}

export const language = chosen();

/** The words are read once: another language is another start of the page. */
export function chooseLanguage(next: Language): void {
  localStorage.setItem(kKept, next);
  location.reload();
}
