// SPDX-License-Identifier: GPL-3.0-or-later
// The cloud of a job that was opened by its link: the file, if this device has kept it; else what the server says of
// it.
import type {Api} from '../api/client';
import type {Job} from '../api/types';
import {t} from '../words/words';
import {keptCloud} from './kept_clouds';
import type {ChosenCloud} from './state';

/** None if the job brought its own. */
export async function cloudOfJob(api: Api, {cloud_id, labels}: Job): Promise<ChosenCloud|undefined> {
  if (!cloud_id) return undefined;
  const file = await keptCloud(cloud_id);
  if (file) return {name: file.name, size: file.size, id: cloud_id, file};
  const stored = await api.cloud(cloud_id).catch(() => undefined);
  const name = labels[0] ?? t.cloud.unnamed(cloud_id.slice(0, 8));
  return {name, size: stored?.bytes ?? 0, id: cloud_id, stored};
}
