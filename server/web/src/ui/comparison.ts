// SPDX-License-Identifier: GPL-3.0-or-later
// Two results in one table.
import type {Report} from '../api/types';
import type {Result} from '../app/state';
import {count, real, seconds} from '../words/numbers';
import {t} from '../words/words';
import {h} from './dom';

const yes = (value: boolean): string => (value ? t.result.yes : t.result.no);
const some = (value: number|null|undefined): string => (value === null || value === undefined ? '–' : count(value));
const ratio = (value: number|undefined): string => (value === undefined ? '–' : real(value));

const {rows: names} = t.result;
const rows: [string, (report: Report) => string][] = [
  [names.watertight, ({mesh}) => yes(mesh.closed)],
  [names.manifold, ({mesh}) => yes(mesh.edge_manifold && mesh.vertex_manifold)],
  [names.genus, ({mesh}) => some(mesh.genus)],
  [names.pieces, ({mesh}) => count(mesh.components)],
  [names.openings, ({mesh}) => count(mesh.boundary_loops)],
  [names.vertices, ({mesh}) => count(mesh.vertices)],
  [names.triangles, ({mesh}) => count(mesh.triangles)],
  [names.unused, ({quality}) => some(quality.unused_points)],
  [names.inside, ({quality}) => some(quality.interior_vertices)],
  [names.lR5, ({quality}) => ratio(quality.shortest_edge_to_circumradius?.p05)],
  [names.lR50, ({quality}) => ratio(quality.shortest_edge_to_circumradius?.p50)],
  [names.rL50, ({quality}) => ratio(quality.inradius_to_longest_edge?.p50)],
  [names.area, ({quality}) => real(quality.area)],
  [names.time, ({resources}) => (resources ? seconds(resources.wall_seconds) : '–')],
];

export function comparisonTable(titles: string[], first: Result, second: Result, close: () => void): HTMLElement {
  const closing =
      h('button', {type: 'button', class: 'button small', id: 'close-second', onclick: close}, t.result.closeSecond);
  const head = h('tr', {}, h('td', {}), ...titles.map((title) => h('th', {scope: 'col'}, title)));
  const body = rows.map(([name, of]) => {
    const [a, b] = [of(first.report), of(second.report)];
    const cells = [a, b].map((text) => h('td', {class: 'number'}, text));
    return h('tr', {class: a === b ? '' : 'differs'}, h('th', {scope: 'row'}, name), ...cells);
  });
  return h(
      'div', {class: 'comparison'}, h('div', {class: 'between'}, h('h2', {}, t.result.comparison), closing),
      h('table', {}, h('caption', {class: 'visually-hidden'}, t.result.bothResults), h('thead', {}, head),
        h('tbody', {}, ...body)));
}
