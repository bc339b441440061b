// SPDX-License-Identifier: GPL-3.0-or-later
// What became of the cloud: in words, in numbers, its worst triangles, its files, and how to come back to it.
import type {Session} from '../app/session';
import type {Result, State} from '../app/state';
import {worstOf} from '../geometry/quality';
import type {Stage} from '../view/stage';
import {curlLine} from '../words/curl';
import {count, real, seconds} from '../words/numbers';
import {reportWords} from '../words/report_words';
import {t} from '../words/words';
import {whenChanged} from './changed';
import {comparisonTable} from './comparison';
import {fill, h, must} from './dom';
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
  const paper: Bound = {value: kPaper[ratio], name: t.result.paper};
  return certified > 0 && Math.abs(certified - paper.value) > 0.02 * paper.value ?
      [paper, {value: certified, name: t.result.here}] :
      [paper];
}

function histograms(first: Result, second: Result|undefined): HTMLElement {
  const of = (result: Result|undefined) => result?.report.quality;
  const [lR, rL] = [of(first)?.shortest_edge_to_circumradius, of(first)?.inradius_to_longest_edge];
  return section(
      t.result.shape, true,
      lR ? histogram(
               'l/R', t.result.lR, lR, of(second)?.shortest_edge_to_circumradius ?? undefined,
               boundsOf(first, 'shortest_edge_to_circumradius')) :
           undefined,
      rL ? histogram(
               'r/L', t.result.rL, rL, of(second)?.inradius_to_longest_edge ?? undefined,
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
    const fly = () => stage && flyTo(session, result, triangle, stage);
    const button = h('button', {type: 'button', class: 'link number', onclick: fly}, `#${count(triangle)}`);
    return h('li', {}, button, h('span', {class: 'number'}, text));
  });
  return section(t.result.worst, false, h('p', {class: 'hint'}, t.result.flies), h('ol', {class: 'worst'}, ...rows));
}

async function save(session: Session, path: string, name: string): Promise<void> {
  await session.guard(async () => {
    session.change({notice: t.result.fetching(name)});
    const body = await session.api.bytes(path, () => undefined);
    const link = h('a', {href: URL.createObjectURL(new Blob([body])), download: name});
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
    session.change({notice: t.result.saved(name)});
  });
}

/** @param suffix tells the files of one result from those of the other. */
function files(session: Session, {job}: Result, title: string, suffix: string): HTMLElement {
  const stem = `${(session.state.cloud?.name ?? 'mesh').replace(/\.[^.]*$/, '')}${suffix}`;
  const button = (output: string, name: string, text: string) => {
    const get = () => void save(session, `v1/jobs/${job.id}/outputs/${output}`, name);
    return h('button', {type: 'button', class: 'chip', 'data-output': output, 'data-job': job.id, onclick: get}, text);
  };
  const points =
      job.outputs?.includes('cloud.ply') ? [button('cloud.ply', `${stem}-points.ply`, t.result.pointsFile)] : [];
  return section(
      title, true,
      h('div', {class: 'row samples'},
        ...kFiles.map((format) => button(`mesh.${format}`, `${stem}.${format}`, format.toUpperCase())), ...points,
        button('report.json', `${stem}-report.json`, t.result.report),
        button('log.txt', `${stem}-log.txt`, t.result.log)));
}

function copyable(label: string, text: string, session: Session): HTMLElement {
  const box = h('textarea', {readOnly: true, rows: 2, 'aria-label': label, value: text, spellcheck: false});
  const copy = async(): Promise<void> => {
    box.select();
    try {
      await navigator.clipboard.writeText(text);
      session.change({notice: t.result.copied(label)});
    } catch {
      session.change({notice: t.result.selected(label)});
    }
  };
  const button =
      h('button',
        {type: 'button', class: 'button small', 'aria-label': `${t.result.copy}: ${label}`, onclick: () => void copy()},
        t.result.copy);
  return h('div', {class: 'copyable'}, h('div', {class: 'between'}, h('span', {class: 'label'}, label), button), box);
}

function again(session: Session, {job}: Result): HTMLElement {
  const {api, state} = session;
  const line = curlLine(api.base.href, state.cloud?.name ?? 'cloud.ply', job.method, job.parameters, api.key !== '');
  return section(
      t.result.again, false, copyable(t.result.link, location.href, session), copyable(t.result.curl, line, session));
}

function words(result: Result): HTMLElement {
  const items = reportWords(result.report)
                    .map(
                        ({mood, text}) =>
                            h('li', {class: mood}, h('span', {class: 'visually-hidden'}, `${t.report[mood]}: `), text));
  return h('ul', {class: 'words'}, ...items);
}

const titleOf = (state: State, {job}: Result): string =>
    state.methods.find((method) => method.id === job.method)?.title ?? job.method;

function headline(state: State, result: Result): HTMLElement {
  const {vertices, triangles} = result.report.mesh;
  const took = result.report.resources ? ` · ${seconds(result.report.resources.wall_seconds)}` : '';
  const size =
      `${t.result.vertices(vertices, count(vertices))} · ${t.result.triangles(triangles, count(triangles))}${took}`;
  return h('div', {class: 'headline'}, h('h2', {}, titleOf(state, result)), h('p', {class: 'number'}, size));
}

function empty(): HTMLElement[] {
  return [h('h2', {}, t.result.title), h('p', {class: 'hint'}, t.result.empty)];
}

function one(session: Session, result: Result, stage: Stage|undefined): HTMLElement[] {
  return [
    headline(session.state, result), words(result), histograms(result, undefined), worst(session, result, stage),
    files(session, result, t.result.download, ''), again(session, result)
  ];
}

function two(session: Session, first: Result, second: Result, stage: Stage|undefined): HTMLElement[] {
  let titles = [first, second].map((result) => titleOf(session.state, result));
  if (titles[0] === titles[1])
    titles = titles.map((title, i) => `${title}, ${i === 0 ? t.result.first : t.result.second}`);
  return [
    comparisonTable(titles, first, second, () => session.closeSecond()),
    ...[first, second].map((result, i) => section(t.result.wordsOf(titles[i]), true, words(result))),
    histograms(first, second),
    worst(session, first, stage),
    ...[first, second].map(
        (result, i) => files(session, result, t.result.downloadOf(titles[i]), `-${i + 1}-${result.job.method}`)),
    again(session, first),
  ];
}

export function mountResultPanel(host: HTMLElement, session: Session, stage: Stage|undefined): void {
  const show = ({results: [first, second]}: State): void => {
    document.body.classList.toggle('has-result', first !== undefined);
    fill(host, ...(!first ? empty() : second ? two(session, first, second, stage) : one(session, first, stage)));
    // On a telephone the picture may lie above what was pressed.
    if (first && must('#view').getBoundingClientRect().bottom < 80) must('#view').scrollIntoView({block: 'start'});
  };
  session.onChange(whenChanged(({results}) => results, show));
  fill(host, ...empty());
}
