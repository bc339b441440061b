// SPDX-License-Identifier: GPL-3.0-or-later
// Spares the page what has not changed: a button that is made anew loses the focus, a mesh is long on its way to the
// card.
import type {State} from '../app/state';

/** Calls `show` if one of the parts that it shows is another one than the last time. */
export function whenChanged(parts: (state: State) => unknown[], show: (state: State) => void): (state: State) => void {
  let before: unknown[] = [];
  return (state) => {
    const now = parts(state);
    if (now.length === before.length && now.every((part, i) => part === before[i])) return;
    before = now;
    show(state);
  };
}
