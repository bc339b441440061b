// SPDX-License-Identifier: GPL-3.0-or-later
// The address of the page: which job it shows, and which beside it. Each result is a step of the browser's history.
export interface Link {
  job?: string|undefined;
  other?: string|undefined;
}

export function readLink(): Link {
  const query = new URLSearchParams(location.search);
  return {job: query.get('job') ?? undefined, other: query.get('with') ?? undefined};
}

/** Nothing happens if the address says so already: it was gone back to, or opened. */
export function writeLink({job, other}: Link): void {
  const query = job ? `?job=${job}${other ? `&with=${other}` : ''}` : '';
  if (query !== location.search) history.pushState(null, '', query || location.pathname);
}

export function onLink(open: (link: Link) => void): void {
  addEventListener('popstate', () => open(readLink()));
}
