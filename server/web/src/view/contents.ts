// What the panes show, out of what the page knows.
import type { State } from '../app/state';
import { kLargest } from '../geometry/quality';
import type { ScaleName } from './colormap';
import type { Colouring, Content } from './layers';

export interface ScaleLegend {
  title: string;
  upper: number;
  scale: ScaleName;
}

const titles = { lR: 'l/R, shortest edge over circumradius', rL: 'r/L, inradius over longest edge', angle: 'Smallest angle, degrees' };

function largest(...lists: (Float32Array | undefined)[]): number {
  let most = 0;
  for (const list of lists) list?.forEach((value) => (most = Math.max(most, value)));
  return most;
}

export function colouringsOf(state: State): { colourings: (Colouring | undefined)[]; legend?: ScaleLegend } {
  const { colour, results, difference } = state;
  if (colour === 'none' || !results[0]) return { colourings: [] };
  if (colour === 'distance' || colour === 'difference') {
    const values = colour === 'distance' ? results.map((result) => result?.distances) : [difference?.first, difference?.second];
    const upper = largest(...values);
    const title = colour === 'distance' ? 'Distance to the nearest input point' : 'Distance to the other mesh';
    return { colourings: values.map((list) => list && { values: list, per: 'vertex', upper, scale: 'distance' }), legend: { title, upper, scale: 'distance' } };
  }
  const upper = kLargest[colour];
  return {
    colourings: results.map((result) => result && { values: result.mesh.shapes[colour], per: 'triangle', upper, scale: 'quality' }),
    legend: { title: titles[colour], upper, scale: 'quality' },
  };
}

export function contentsOf(state: State): Content[] {
  const { colourings } = colouringsOf(state);
  const shown = state.results.filter((result) => result !== undefined);
  if (shown.length === 0) return [{ cloud: state.cloud?.data }];
  return shown.map((result, i) => ({ cloud: state.cloud?.data, mesh: result.mesh, wireframe: result.wireframe, unused: result.unused, colouring: colourings[i] }));
}
