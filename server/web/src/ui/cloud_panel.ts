// SPDX-License-Identifier: GPL-3.0-or-later
// The first step: which cloud.
import type {Session} from '../app/session';
import type {ChosenCloud, State} from '../app/state';
import {wordOf} from '../clouds/table_cells';
import {boxOf, sizesOf} from '../geometry/box';
import {bytes, count, real} from '../words/numbers';
import {t} from '../words/words';
import {whenChanged} from './changed';
import {fill, h} from './dom';

export const kFormats = 'PLY, Draco, LAS, PCD, glTF, OBJ, STL, XYZ, CSV';

export function fileButton(session: Session, text: string, look: string): HTMLElement {
  const input = h('input', {type: 'file', multiple: true, class: 'visually-hidden', 'aria-label': t.cloud.chooseLabel});
  input.addEventListener('change', () => {
    void session.chooseFiles([...(input.files ?? [])]);
    input.value = '';
  });
  return h('label', {class: `button ${look}`}, text, input);
}

const product = (sizes: number[]): string => sizes.map((size) => real(size)).join(' × ');

/** What is known of each point besides its place. */
function attributes({data, stored}: ChosenCloud): string {
  const server = stored?.attributes ?? [];
  const known: [unknown, string][] = [
    [data?.colours ?? server.includes('color'), t.cloud.colours],
    [data?.normals ?? server.includes('normal'), t.cloud.normals],
    [data?.intensity, t.cloud.intensity],
    [data?.classes, t.cloud.classes],
  ];
  return known.filter(([there]) => there).map(([, word]) => word).join(', ');
}

function facts(cloud: ChosenCloud): HTMLElement {
  const {data, stored} = cloud;
  const rows: [string, string][] = [];
  if (cloud.size > 0) rows.push([t.cloud.size, bytes(cloud.size)]);
  if (data) {
    rows.push([t.cloud.format, data.format], [t.cloud.points, count(data.positions.length / 3 + data.missing)]);
    rows.push([t.cloud.extent, product(sizesOf(boxOf(data.positions)))]);
  } else if (stored?.points && stored.bounds) {
    rows.push(
        [t.cloud.points, count(stored.points)],
        [t.cloud.extent, product(stored.bounds.max.map((high, axis) => high - (stored.bounds?.min[axis] ?? 0)))]);
  }
  const list = h('dl', {class: 'facts'}, ...rows.flatMap(([name, value]) => [h('dt', {}, name), h('dd', {}, value)]));
  const has = attributes(cloud);
  return has ? h('div', {}, list, h('p', {class: 'hint attributes'}, `${t.cloud.has}: ${has}`)) : list;
}

/** The first rows of a text under what their columns are taken for. */
function rows(cloud: ChosenCloud): HTMLElement|undefined {
  const table = cloud.data?.table;
  if (!table) return undefined;
  const how = t.cloud.columnsTaken(table.guessed, table.roles.join(','), wordOf(table.separator), table.decimalComma);
  const names =
      ['columns', 'separator', 'decimal', 'skip'].flatMap((name, i) => [i > 0 ? ', ' : '', h('code', {}, name)]);
  const head = h('tr', {}, ...table.roles.map((role) => h('th', {scope: 'col'}, role)));
  const lines = table.preview.map((cells) => h('tr', {}, ...table.roles.map((_, c) => h('td', {}, cells[c] ?? ''))));
  return h(
      'details', {class: 'table-preview', open: table.guessed}, h('summary', {}, t.cloud.columns),
      h('p', {class: 'hint'}, how, ' ', t.cloud.columnsOtherwise[0], ...names, t.cloud.columnsOtherwise[1]),
      h('div', {class: 'scroll', tabIndex: 0, role: 'region', 'aria-label': t.cloud.columns},
        h('table', {}, h('thead', {}, head), h('tbody', {}, ...lines))));
}

function note(cloud: ChosenCloud): string|undefined {
  if (cloud.file?.size === 0) return t.cloud.empty;
  if (cloud.noPreview) return t.cloud.noPreview(cloud.noPreview);
  return cloud.file ? undefined : t.cloud.onServer;
}

function droppedFiles(session: Session, files: File[]): HTMLElement {
  const first =
      h('button', {type: 'button', class: 'button small', onclick: () => files[0] && void session.chooseFile(files[0])},
        t.batch.first);
  return h(
      'div', {class: 'dropped'}, h('p', {class: 'name'}, t.batch.title(files.length)),
      h('ul', {class: 'hint'}, ...files.map((file) => h('li', {}, `${file.name} · ${bytes(file.size)}`))),
      h('p', {class: 'hint'}, t.batch.hint), h('div', {class: 'row'}, first));
}

export function mountCloudPanel(host: HTMLElement, session: Session): void {
  const show = (state: State): void => {
    const {cloud, dropped} = state;
    const said = cloud && note(cloud);
    const samples = state.samples.map(
        (sample) =>
            h('button', {
              type: 'button',
              class: 'chip',
              title: sample.description,
              onclick: () => void session.chooseSample(sample)
            },
              sample.title));
    // The button that was pressed keeps the focus.
    const focused = host.contains(document.activeElement) ? document.activeElement?.textContent : undefined;
    const step = h('span', {class: 'step', 'aria-hidden': 'true'}, '1');
    fill(
        host, h('h2', {}, step, t.cloud.title), dropped.length > 0 && droppedFiles(session, dropped),
        cloud ? h('p', {class: 'name'}, cloud.name) : h('p', {class: 'hint'}, t.cloud.drop(kFormats)),
        cloud && facts(cloud), cloud && rows(cloud), said && h('p', {class: 'note'}, said),
        h('div', {class: 'row'}, fileButton(session, cloud ? t.cloud.another : t.cloud.choose, cloud ? '' : 'primary')),
        samples.length > 0 &&
            h('div', {class: 'row samples'}, h('span', {class: 'label'}, t.cloud.samples), ...samples));
    if (focused) samples.find((sample) => sample.textContent === focused)?.focus();
  };
  const update = whenChanged(
      ({cloud, samples, dropped}) => [cloud, cloud?.data, cloud?.noPreview, cloud?.stored, samples, dropped], show);
  session.onChange(update);
  update(session.state);
}

/** Files may be dropped anywhere. */
export function acceptDrops(session: Session): void {
  const over = (on: boolean): void => void document.body.classList.toggle('dropping', on);
  addEventListener('dragover', (event) => {
    event.preventDefault();
    over(true);
  });
  addEventListener('dragleave', (event) => {
    if (event.relatedTarget === null) over(false);
  });
  addEventListener('drop', (event) => {
    event.preventDefault();
    over(false);
    void session.chooseFiles([...(event.dataTransfer?.files ?? [])]);
  });
}
