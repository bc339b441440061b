// SPDX-License-Identifier: GPL-3.0-or-later
// What the panes show, out of what the page knows.
import {kLargest} from '../geometry/quality';
import {coloursOf, kClassColours, type ScaleName} from '../view/colormap';
import type {Colouring, Content} from '../view/layers';
import {count, real} from '../words/numbers';
import {t} from '../words/words';
import type {ColourBy, Result, State} from './state';

export interface ScaleLegend {
  title: string;
  lower: number;
  upper: number;
  scale: ScaleName;
}

const titles = {
  lR: t.view.lR,
  rL: t.view.rL,
  angle: t.view.angleDegrees,
};

/** Colours of points or vertices. */
interface PointColours {
  points?: Uint8Array|undefined;
  vertices: (Uint8Array|undefined)[];
  legend?: ScaleLegend;
}

function extremes(lists: (ArrayLike<number>|undefined)[]): {least: number; most: number; mean: number} {
  let [least, most, sum, n] = [Infinity, -Infinity, 0, 0];
  for (const list of lists) {
    for (let i = 0; list && i < list.length; i += 1) {
      least = Math.min(least, list[i]);
      most = Math.max(most, list[i]);
      sum += list[i];
    }
    n += list?.length ?? 0;
  }
  return {least, most, mean: sum / Math.max(1, n)};
}

function heightsOf(part: {positions: Float32Array; origin: [number, number, number]}, axis: number): Float64Array {
  const {positions, origin} = part;
  return Float64Array.from({length: positions.length / 3}, (_, i) => positions[3 * i + axis] + origin[axis]);
}

function byHeight({cloud, results, up}: State): PointColours {
  const axis = up === 'y' ? 1 : 2;
  const points = cloud?.data && heightsOf(cloud.data, axis);
  const vertices = results.map((result) => result && heightsOf(result.mesh, axis));
  const {least: lower, most: upper} = extremes([points, ...vertices]);
  const colours = (values: Float64Array|undefined) => values && coloursOf(values, upper, 'height', lower);
  const legend: ScaleLegend = {title: t.view.heightOf(up), lower, upper, scale: 'height'};
  return {points: colours(points), vertices: vertices.map(colours), legend};
}

function byIntensity({cloud}: State): PointColours {
  const values = cloud?.data?.intensity;
  const {least: lower, most: upper} = extremes([values]);
  const legend: ScaleLegend = {title: t.view.intensity, lower, upper, scale: 'grey'};
  return {points: values && coloursOf(values, upper, 'grey', lower), vertices: [], legend};
}

function byClass({cloud}: State): PointColours {
  const classes = cloud?.data?.classes;
  const points = classes && new Uint8Array(3 * classes.length);
  classes?.forEach((each, i) => points?.set(kClassColours[each % kClassColours.length], 3 * i));
  return {points, vertices: []};
}

function pointColoursOf(state: State): PointColours {
  const {colour, cloud, results} = state;
  if (colour === 'own') return {points: cloud?.data?.colours, vertices: results.map((result) => result?.mesh.colours)};
  if (colour === 'height') return byHeight(state);
  if (colour === 'intensity') return byIntensity(state);
  if (colour === 'class') return byClass(state);
  return {vertices: []};
}

/** Colours by triangle. */
interface Colourings {
  colourings: (Colouring|undefined)[];
  legend?: ScaleLegend;
}

function byDistance({colour, results, difference}: State): Colourings {
  const values =
      colour === 'distance' ? results.map((result) => result?.distances) : [difference?.first, difference?.second];
  if (!values[0]) return {colourings: []};
  const {most: upper, mean} = extremes(values);
  const title = colour === 'distance' ? t.view.distanceMean(real(mean)) : t.view.differenceMean(real(mean));
  return {
    colourings: values.map((list) => list && {values: list, upper, scale: 'distance'}),
    legend: {title, lower: 0, upper, scale: 'distance'},
  };
}

function colouringsOf(state: State): Colourings {
  const {colour, results} = state;
  if (!results[0]) return {colourings: []};
  if (colour === 'distance' || colour === 'difference') return byDistance(state);
  if (colour !== 'lR' && colour !== 'rL' && colour !== 'angle') return {colourings: []};
  const upper = kLargest[colour];
  return {
    colourings: results.map((result) => result && {values: result.mesh.shapes[colour], upper, scale: 'quality'}),
    legend: {title: titles[colour], lower: 0, upper, scale: 'quality'},
  };
}

export const legendOf = (state: State): ScaleLegend|undefined =>
    colouringsOf(state).legend ?? (state.cloud?.data || state.results[0] ? pointColoursOf(state).legend : undefined);

function contentOf(state: State, result: Result, pointColours: PointColours, colouring?: Colouring): Content {
  const {closed, oriented} = result.report.mesh;
  return {
    cloud: state.cloud?.data,
    pointColours: pointColours.points,
    mesh: result.mesh,
    vertexColours: pointColours.vertices[state.results.indexOf(result)],
    wireframe: result.wireframe,
    unused: result.unused,
    colouring,
    solid: closed && oriented && state.clip.axis === 'none',
    pointed: result === state.results[0] ? state.pointed : undefined,
  };
}

export function contentsOf(state: State): Content[] {
  const {colourings} = colouringsOf(state);
  const pointColours = pointColoursOf(state);
  const shown = state.results.filter((result) => result !== undefined);
  if (shown.length === 0)
    return [{cloud: state.cloud?.data, pointColours: pointColours.points, pointed: state.pointed}];
  return shown.map((result, i) => contentOf(state, result, pointColours, colourings[i]));
}

/** What there is to colour by, in the order of the list. */
export function colourChoices({cloud, results: [first, second]}: State): [ColourBy, string][] {
  const data = cloud?.data;
  const list: [ColourBy, string][] = [['none', t.view.plain]];
  if (first ? first.mesh.colours : data?.colours) list.push(['own', t.view.own]);
  list.push(['height', t.view.height]);
  if (data?.intensity && !first) list.push(['intensity', t.view.intensity]);
  if (data?.classes && !first) list.push(['class', t.view.class]);
  if (!first) return list;
  list.push(['lR', 'l/R'], ['rL', 'r/L'], ['angle', t.view.angle]);
  if (data) list.push(['distance', t.view.distance]);
  if (second) list.push(['difference', t.view.difference]);
  return list;
}

/** What a screen reader says of the canvas. */
export function describeView(state: State): string {
  const [first, second] = state.results;
  const {cloud} = state;
  if (!first) return cloud?.data ? t.view.pointsOf(count(cloud.data.positions.length / 3), cloud.name) : t.view.nothing;
  const of = (result: Result) => t.view.meshBy(count(result.report.mesh.triangles), result.job.method);
  return second ? t.view.two(of(first), of(second)) : t.view.one(of(first));
}
