// SPDX-License-Identifier: GPL-3.0-or-later
// The points of a box become a cloud of their own, which is written as PLY; the whole one is kept, to come back to.
import type {Box} from '../geometry/box';
import {t} from '../words/words';
import type {Session} from './session';

export function cropCloud(session: Session, box: Box): Promise<void> {
  return session.begin(async (signal) => {
    const {cloud} = session.state;
    if (!cloud?.data || !cloud.file) return;
    const bytes = await session.geometry.cropped(cloud.data.handle, box);
    signal.throwIfAborted();
    const name = `${cloud.name.replace(/\.[^.]*$/, '').replace(/-crop$/, '')}-crop.ply`;
    await session.setCloud(new File([bytes], name), undefined, cloud.whole ?? cloud);
    session.change({notice: t.tools.cropped(cloud.name)});
  });
}

export function uncrop(session: Session): Promise<void> {
  return session.begin(async () => {
    const whole = session.state.cloud?.whole;
    if (!whole?.file) return;
    await session.setCloud(whole.file, whole.id);
    session.change({notice: t.tools.undone});
  });
}
