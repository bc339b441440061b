// SPDX-License-Identifier: GPL-3.0-or-later
// The first step: which cloud.
import type {Session} from '../app/session';
import type {ChosenCloud, State} from '../app/state';
import {wordOf} from '../clouds/table';
import {bytes, count, real} from '../words/numbers';
import {whenChanged} from './changed';
import {fill, h} from './dom';

export const kFormats = 'PLY, Draco, LAS, PCD, glTF, OBJ, STL, XYZ, CSV';

export function fileButton(session: Session, text: string, look: string): HTMLElement {
  const input = h('input', {type: 'file', class: 'visually-hidden', 'aria-label': 'Choose a point cloud file'});
  input.addEventListener('change', () => {
    const file = input.files?.[0];
    if (file) void session.chooseFile(file);
    input.value = '';
  });
  return h('label', {class: `button ${look}`}, text, input);
}

function facts(cloud: ChosenCloud): HTMLElement {
  const rows: [string, string][] = [];
  if (cloud.size > 0) rows.push(['Size', bytes(cloud.size)]);
  const {data} = cloud;
  if (data) {
    rows.push(
        ['Format', data.format], ['Points', count(data.positions.length / 3 + data.missing)],
        ['Extent', extent(data.positions)]);
  }
  return h('dl', {class: 'facts'}, ...rows.flatMap(([name, value]) => [h('dt', {}, name), h('dd', {}, value)]));
}

/** The first rows of a text under what their columns are taken for. */
function rows(cloud: ChosenCloud): HTMLElement|undefined {
  const table = cloud.data?.table;
  if (!table) return undefined;
  const how = `Columns ${table.guessed ? 'guessed' : 'read'} as ${table.roles.join(',')}, ${
      wordOf(table.separator)} between values, decimal ${table.decimalComma ? 'commas' : 'points'}.`;
  return h(
      'details', {class: 'table-preview', open: table.guessed}, h('summary', {}, 'Columns'),
      h('p', {class: 'hint'}, how, ' The parameters ', h('code', {}, 'columns'), ', ', h('code', {}, 'separator'), ', ',
        h('code', {}, 'decimal'), ' and ', h('code', {}, 'skip'), ' say otherwise.'),
      h('div', {class: 'scroll'},
        h('table', {}, h('thead', {}, h('tr', {}, ...table.roles.map((role) => h('th', {scope: 'col'}, role)))),
          h('tbody', {},
            ...table.preview.map((cells) => h('tr', {}, ...table.roles.map((_, c) => h('td', {}, cells[c] ?? ''))))))));
}

function extent(positions: Float32Array): string {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  positions.forEach((value, i) => {
    low[i % 3] = Math.min(low[i % 3], value);
    high[i % 3] = Math.max(high[i % 3], value);
  });
  return low.map((value, axis) => real(high[axis] - value)).join(' × ');
}

export function mountCloudPanel(host: HTMLElement, session: Session): void {
  const show = (state: State): void => {
    const {cloud} = state;
    fill(
        host, h('h2', {}, h('span', {class: 'step', 'aria-hidden': 'true'}, '1'), 'Cloud'),
        cloud ? h('p', {class: 'name'}, cloud.name) :
                h('p', {class: 'hint'}, `Drop a file anywhere on the page, or choose one: ${kFormats}.`),
        cloud && facts(cloud), cloud && rows(cloud),
        cloud?.noPreview &&
            h('p', {class: 'note'},
              `Its points are not shown: ${cloud.noPreview}. The server reads the file itself and may know it.`),
        h('div', {class: 'row'},
          fileButton(session, cloud ? 'Another file …' : 'Choose a file …', cloud ? '' : 'primary')),
        state.samples.length > 0 &&
            h('div', {class: 'row samples'}, h('span', {class: 'label'}, 'Samples'),
              ...state.samples.map(
                  (sample) =>
                      h('button', {
                        type: 'button',
                        class: 'chip',
                        title: sample.description,
                        onclick: () => void session.chooseSample(sample)
                      },
                        sample.title))));
  };
  const update = whenChanged(({cloud, samples}) => [cloud, cloud?.data, cloud?.noPreview, samples], show);
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
    const file = event.dataTransfer?.files[0];
    if (file) void session.chooseFile(file);
  });
}
