// SPDX-License-Identifier: GPL-3.0-or-later
// Small pictures of the latest results, kept by this browser under the ids of their jobs. Where it permits none, there
// are none.
const kKept = 'surfaced.pictures';
const kMost = 40;

/** Oldest first. */
function kept(): [string, string][] {
  try {
    return JSON.parse(localStorage.getItem(kKept) ?? '[]') as [string, string][];
  } catch {
    return [];
  }
}

function store(pictures: [string, string][]): void {
  try {
    localStorage.setItem(kKept, JSON.stringify(pictures));
  } catch (failure) {
    console.info('the picture is not kept on this device:', failure);
  }
}

export const pictureOf = (job: string): string|undefined => kept().find(([id]) => id === job)?.[1];

export function keepPicture(job: string, url: string): void {
  store([...kept().filter(([id]) => id !== job), [job, url] as [string, string]].slice(-kMost));
}

export const dropPicture = (job: string): void => store(kept().filter(([id]) => id !== job));
