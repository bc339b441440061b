// SPDX-License-Identifier: GPL-3.0-or-later
// The title of the tab: what is shown, or how far the work is.
import type {Session} from '../app/session';
import type {State} from '../app/state';
import {t} from '../words/words';

const kName = 'surfaced';

function titleOf({cloud, results: [first, second], work, error, methods}: State): string {
  const name = cloud?.name ?? '';
  const method = (id: string) => methods.find((each) => each.id === id)?.title ?? id;
  if (error) return [t.jobs.failed, name, kName].filter(Boolean).join(' · ');
  if (work) {
    const percent = work.fraction === undefined ? t.work[work.what] : `${Math.round(100 * work.fraction)} %`;
    return [percent, name, kName].filter(Boolean).join(' · ');
  }
  const shown = [first, second].filter((result) => result !== undefined).map((result) => method(result.job.method));
  return [name, shown.join(' / '), kName].filter(Boolean).join(' · ');
}

export function mountTitle(session: Session): void {
  session.onChange((state) => {
    const title = titleOf(state);
    if (document.title !== title) document.title = title;
  });
}
