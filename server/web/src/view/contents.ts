// SPDX-License-Identifier: GPL-3.0-or-later
// What the panes show, out of what the page knows.
import type {State} from '../app/state';
import {kLargest} from '../geometry/quality';
import {real} from '../words/numbers';
import type {ScaleName} from './colormap';
import type {Colouring, Content} from './layers';

export interface ScaleLegend {
  title: string;
  upper: number;
  scale: ScaleName;
}

const titles = {
  lR: 'l/R, shortest edge over circumradius',
  rL: 'r/L, inradius over longest edge',
  angle: 'Smallest angle, degrees'
};

function extremes(lists: (Float32Array|undefined)[]): {most: number; mean: number} {
  let [most, sum, count] = [0, 0, 0];
  for (const list of lists) {
    list?.forEach((value) => {
      most = Math.max(most, value);
      sum += value;
    });
    count += list?.length ?? 0;
  }
  return {most, mean: sum / Math.max(1, count)};
}

export function colouringsOf(state: State): {colourings: (Colouring|undefined)[]; legend?: ScaleLegend} {
  const {colour, results, difference} = state;
  if (colour === 'none' || !results[0]) return {colourings: []};
  if (colour === 'distance' || colour === 'difference') {
    const values =
        colour === 'distance' ? results.map((result) => result?.distances) : [difference?.first, difference?.second];
    if (!values[0]) return {colourings: []};
    const {most: upper, mean} = extremes(values);
    const title =
        `${colour === 'distance' ? 'Distance to the nearest input point' : 'Distance to the other mesh'}, mean ${
            real(mean)}`;
    return {
      colourings: values.map((list) => list && {values: list, upper, scale: 'distance'}),
      legend: {title, upper, scale: 'distance'}
    };
  }
  const upper = kLargest[colour];
  return {
    colourings: results.map((result) => result && {values: result.mesh.shapes[colour], upper, scale: 'quality'}),
    legend: {title: titles[colour], upper, scale: 'quality'},
  };
}

export function contentsOf(state: State): Content[] {
  const {colourings} = colouringsOf(state);
  const shown = state.results.filter((result) => result !== undefined);
  if (shown.length === 0) return [{cloud: state.cloud?.data}];
  return shown.map((result, i) => ({
                     cloud: state.cloud?.data,
                     mesh: result.mesh,
                     wireframe: result.wireframe,
                     unused: result.unused,
                     colouring: colourings[i],
                     solid: result.report.mesh.closed && result.report.mesh.oriented && state.clip.axis === 'none',
                     pointed: result === state.results[0] ? state.pointed : undefined
                   }));
}
