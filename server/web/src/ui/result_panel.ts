// SPDX-License-Identifier: GPL-3.0-or-later
// What became of the cloud: in words, in numbers, its worst triangles, its files, and how to come back to it.
import type {Session} from '../app/session';
import type {Result, State} from '../app/state';
import {worstOf} from '../geometry/quality';
import type {Stage} from '../view/stage';
import {curlLine} from '../words/curl';
import {count, real, seconds} from '../words/numbers';
import {reportWords} from '../words/report_words';
import {comparisonTable} from './comparison';
import {fill, h} from './dom';
import {histogram, type Bound} from './histogram';

const kWorst = 8;
/**
 * What Gong et al. prove for the coarsest sampling that their theorem takes, 1/(8κ);
 * docs/methods/intrinsic-delaunay.md.
 */
const kPaper = {
  shortest_edge_to_circumradius: 0.4997,
  inradius_to_longest_edge: 0.0208
};
const kFiles = ['glb', 'gltf', 'ply', 'obj', 'stl', '3mf', 'drc'];

const section = (title: string, open: boolean, ...children: (HTMLElement|false|undefined)[]): HTMLElement =>
    h('details', {class: 'section', open}, h('summary', {}, h('h3', {}, title)), ...children);

function boundsOf(result: Result, ratio: 'shortest_edge_to_circumradius'|'inradius_to_longest_edge'): Bound[] {
  const certified = result.report.certificate?.bounds[ratio].lower ?? 0;
  const paper: Bound = {value: kPaper[ratio], name: 'paper'};
  return certified > 0 && Math.abs(certified - paper.value) > 0.02 * paper.value ?
      [paper, {value: certified, name: 'here'}] :
      [paper];
}

function histograms(first: Result, second: Result|undefined): HTMLElement {
  const of = (result: Result|undefined) => result?.report.quality;
  const [lR, rL] = [of(first)?.shortest_edge_to_circumradius, of(first)?.inradius_to_longest_edge];
  return section(
      'Shape of the triangles', true,
      lR ? histogram(
               'l/R', 'shortest edge over circumradius, best 1.732', lR,
               of(second)?.shortest_edge_to_circumradius ?? undefined,
               boundsOf(first, 'shortest_edge_to_circumradius')) :
           undefined,
      rL ? histogram(
               'r/L', 'inradius over longest edge, best 0.2887', rL, of(second)?.inradius_to_longest_edge ?? undefined,
               boundsOf(first, 'inradius_to_longest_edge')) :
           undefined);
}

function corners(result: Result, triangle: number): [number, number, number][] {
  const {positions, index} = result.mesh;
  return [0, 1, 2].map(
      (k) => Array.from(positions.subarray(
                 3 * index[3 * triangle + k], 3 * index[3 * triangle + k] + 3)) as [number, number, number]);
}

function flyTo(session: Session, result: Result, triangle: number, stage: Stage): void {
  const [a, b, c] = corners(result, triangle);
  session.change({pointed: Float32Array.from([a, b, b, c, c, a].flat())}, 'view');
  stage.flyTo([a, b, c]);
}

function worst(session: Session, result: Result, stage: Stage|undefined): HTMLElement {
  const rows = worstOf(result.mesh.shapes.lR, kWorst).map((triangle) => {
    const {lR, rL, angle} = result.mesh.shapes;
    const text = `l/R ${real(lR[triangle])} · r/L ${real(rL[triangle])} · ${real(angle[triangle])}°`;
    return h(
        'li', {},
        h('button',
          {type: 'button', class: 'link number', onclick: () => stage && flyTo(session, result, triangle, stage)},
          `#${count(triangle)}`),
        h('span', {class: 'number'}, text));
  });
  return section(
      'Worst triangles', false, h('p', {class: 'hint'}, 'A click flies there.'), h('ol', {class: 'worst'}, ...rows));
}

async function save(session: Session, path: string, name: string): Promise<void> {
  await session.guard(async () => {
    session.change({notice: `Fetching ${name} …`});
    const body = await session.api.bytes(path, () => undefined);
    const link = h('a', {href: URL.createObjectURL(new Blob([body])), download: name});
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
    session.change({notice: `${name} is saved.`});
  });
}

function files(session: Session, result: Result): HTMLElement {
  const stem = (session.state.cloud?.name ?? 'mesh').replace(/\.[^.]*$/, '');
  const button = (output: string, name: string, text: string) =>
      h('button', {
        type: 'button',
        class: 'chip',
        'data-output': output,
        onclick: () => void save(session, `v1/jobs/${result.job.id}/outputs/${output}`, name)
      },
        text);
  return section(
      'Download', true,
      h('div', {class: 'row samples'},
        ...kFiles.map((format) => button(`mesh.${format}`, `${stem}.${format}`, format.toUpperCase())),
        ...(result.job.outputs?.includes('cloud.ply') ? [button('cloud.ply', `${stem}-points.ply`, 'Points')] : []),
        button('report.json', `${stem}-report.json`, 'Report'), button('log.txt', `${stem}-log.txt`, 'Log')));
}

function copyable(label: string, text: string, session: Session): HTMLElement {
  const box = h('textarea', {readOnly: true, rows: 2, 'aria-label': label, value: text, spellcheck: false});
  const copy = async(): Promise<void> => {
    box.select();
    try {
      await navigator.clipboard.writeText(text);
      session.change({notice: `${label}: copied.`});
    } catch {
      session.change({notice: `${label}: selected; copy it with Ctrl+C.`});
    }
  };
  return h(
      'div', {class: 'copyable'},
      h('div', {class: 'between'}, h('span', {class: 'label'}, label),
        h('button', {type: 'button', class: 'button small', onclick: () => void copy()}, 'Copy')),
      box);
}

function again(session: Session, {job}: Result): HTMLElement {
  const {api, state} = session;
  return section(
      'Again', false, copyable('Link to this result', location.href, session),
      copyable(
          'The same with curl',
          curlLine(api.base.href, state.cloud?.name ?? 'cloud.ply', job.method, job.parameters, api.key !== ''),
          session));
}

function words(result: Result): HTMLElement {
  return h(
      'ul', {class: 'words'},
      ...reportWords(result.report)
          .map(({mood, text}) => h('li', {class: mood}, h('span', {class: 'visually-hidden'}, `${mood}: `), text)));
}

function headline(state: State, result: Result): HTMLElement {
  const title = state.methods.find((method) => method.id === result.job.method)?.title ?? result.job.method;
  const {vertices, triangles} = result.report.mesh;
  const took = result.report.resources ? ` · ${seconds(result.report.resources.wall_seconds)}` : '';
  return h(
      'div', {class: 'headline'}, h('h2', {}, title),
      h('p', {class: 'number'}, `${count(vertices)} vertices · ${count(triangles)} triangles${took}`));
}

function empty(): HTMLElement[] {
  return [
    h('h2', {}, 'Result'),
    h('p', {class: 'hint'},
      'The report stands here once a cloud is reconstructed: whether the mesh is watertight, how well its triangles are shaped, which points it left out.')
  ];
}

export function mountResultPanel(host: HTMLElement, session: Session, stage: Stage|undefined): void {
  let shown: State['results']|undefined;
  session.onChange((state, what) => {
    if (what !== 'all' || (shown && shown[0] === state.results[0] && shown[1] === state.results[1])) return;
    shown = state.results;
    const [first, second] = state.results;
    if (!first) {
      fill(host, ...empty());
      return;
    }
    fill(
        host,
        ...(second ?
                [
                  comparisonTable(state, first, second, () => session.closeSecond()),
                  section('First in words', true, words(first)), section('Second in words', true, words(second))
                ] :
                [headline(state, first), words(first)]),
        histograms(first, second), worst(session, first, stage), files(session, first), again(session, first));
  });
  fill(host, ...empty());
}
