// SPDX-License-Identifier: GPL-3.0-or-later
// Measures what the present look of the results needs and has not yet.
import type {Geometry} from '../worker/geometry';
import {marksUnused} from '../words/report_words';
import {t} from '../words/words';
import type {Result, State} from './state';

type Change = (part: Partial<State>, what?: 'all'|'view') => void;

/** The worker holds what is shown, and may have let go of the others meanwhile. */
const isShown = (state: State, result: Result|undefined): result is Result =>
    result !== undefined && state.results.includes(result);

async function completeResult(geometry: Geometry, state: State, result: Result, change: Change): Promise<void> {
  const {cloud, look, colour} = state;
  const {mesh, report} = result;
  if (cloud?.data && look.marks && !result.unused && marksUnused(report)) {
    result.unused = await geometry.unused(mesh.handle, cloud.data.handle, report.mesh.closed);
    change({}, 'view');
  }
  if (look.wireframe && !result.wireframe && isShown(state, result)) {
    result.wireframe = await geometry.wireframe(mesh.handle);
    change({}, 'view');
  }
  if (colour === 'distance' && cloud?.data && !result.distances && isShown(state, result)) {
    result.distances = await geometry.distances(mesh.handle, cloud.data.handle);
    change({}, 'view');
  }
}

export async function complete(geometry: Geometry, state: State, change: Change): Promise<void> {
  for (const result of state.results) {
    if (isShown(state, result)) await completeResult(geometry, state, result, change);
  }
  const [first, second] = state.results;
  if (state.colour !== 'difference' || !first || !second || state.difference) return;
  change({notice: t.work.difference});
  const difference = await geometry.difference(first.mesh.handle, second.mesh.handle);
  if (isShown(state, first) && isShown(state, second)) change({difference, notice: ''});
}
