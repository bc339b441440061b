// SPDX-License-Identifier: GPL-3.0-or-later
// Two results in one table.
import type {Report} from '../api/types';
import type {Result, State} from '../app/state';
import {count, real, seconds} from '../words/numbers';
import {h} from './dom';

const yes = (value: boolean): string => (value ? 'yes' : 'no');
const some = (value: number|null|undefined): string => (value === null || value === undefined ? '–' : count(value));

const rows: [string, (report: Report) => string][] = [
  ['Watertight', ({mesh}) => yes(mesh.closed)],
  ['Manifold', ({mesh}) => yes(mesh.edge_manifold && mesh.vertex_manifold)],
  ['Genus', ({mesh}) => some(mesh.genus)],
  ['Pieces', ({mesh}) => count(mesh.components)],
  ['Openings', ({mesh}) => count(mesh.boundary_loops)],
  ['Vertices', ({mesh}) => count(mesh.vertices)],
  ['Triangles', ({mesh}) => count(mesh.triangles)],
  ['Unused points', ({quality}) => some(quality.unused_points)],
  ['of them inside', ({quality}) => some(quality.interior_vertices)],
  ['l/R, 5 %', ({quality}) => real(quality.shortest_edge_to_circumradius?.p05 ?? NaN)],
  ['l/R, median', ({quality}) => real(quality.shortest_edge_to_circumradius?.p50 ?? NaN)],
  ['r/L, median', ({quality}) => real(quality.inradius_to_longest_edge?.p50 ?? NaN)],
  ['Area', ({quality}) => real(quality.area)],
  ['Time', ({resources}) => (resources ? seconds(resources.wall_seconds) : '–')],
];

export function comparisonTable(state: State, first: Result, second: Result, close: () => void): HTMLElement {
  const title = (result: Result) =>
      state.methods.find((method) => method.id === result.job.method)?.title ?? result.job.method;
  return h(
      'div', {class: 'comparison'},
      h('div', {class: 'between'}, h('h2', {}, 'Comparison'),
        h('button', {type: 'button', class: 'button small', id: 'close-second', onclick: close}, 'Close the second')),
      h('table', {}, h('caption', {class: 'visually-hidden'}, 'Both results side by side'),
        h('thead', {},
          h('tr', {}, h('td', {}), h('th', {scope: 'col'}, title(first)), h('th', {scope: 'col'}, title(second)))),
        h('tbody', {}, ...rows.map(([name, of]) => {
          const [a, b] = [of(first.report), of(second.report)];
          return h(
              'tr', {class: a === b ? '' : 'differs'}, h('th', {scope: 'row'}, name), h('td', {class: 'number'}, a),
              h('td', {class: 'number'}, b));
        }))));
}
