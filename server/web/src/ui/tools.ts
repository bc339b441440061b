// SPDX-License-Identifier: GPL-3.0-or-later
// Work on the cloud: say what is under a place, measure, cut by a plane, crop by a box.
import {boxEdges, boxOf, countInside, type Box} from '../geometry/box';
import {cropCloud, uncrop} from '../app/cropping';
import type {Session} from '../app/session';
import type {State} from '../app/state';
import type {Picked} from '../view/picking';
import type {Stage} from '../view/stage';
import {count, real} from '../words/numbers';
import {t} from '../words/words';
import {fill, h} from './dom';

type Tool = 'pick'|'measure'|'crop';
type Vector = [number, number, number];
const kAxes = ['x', 'y', 'z'] as const;
/** A click that moves farther is a turn. */
const kStill = 4;

const distance = (a: Vector, b: Vector): number => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

/** Coordinates as in the file. */
function inFile({cloud, results: [first]}: State, place: Vector): Vector {
  const origin = first?.mesh.origin ?? cloud?.data?.origin ?? [0, 0, 0];
  return place.map((value, k) => value + origin[k]) as Vector;
}

/** Enough digits to tell points apart, however far from zero they are. */
const coordinates = (xyz: Vector): string => xyz.map((value) => String(Number(value.toPrecision(9)))).join(', ');

/** Three short lines through a place. */
function crossAt(place: Vector, size: number): number[] {
  return kAxes.flatMap(
      (_, k) => [-1, 1].flatMap((side) => place.map((value, i) => (i === k ? value + side * size : value))));
}

function describe(state: State, {kind, index, place}: Picked): string[] {
  const [first] = state.results;
  const at = t.tools.at(coordinates(inFile(state, place)));
  if (kind === 'point' || !first) return [t.tools.point(count(index)), at];
  const {lR, rL, angle} = first.mesh.shapes;
  return [
    t.tools.triangle(count(index)), at, `l/R ${real(lR[index])} · r/L ${real(rL[index])} · ${real(angle[index])}°`
  ];
}

/** The sides of a picked triangle, or a cross at a point. */
function outline({results: [first]}: State, {kind, index, place}: Picked, size: number): number[] {
  if (kind === 'point' || !first) return crossAt(place, size);
  const {positions, index: corners} = first.mesh;
  const [a, b, c] =
      [0, 1, 2].map((k) => [...positions.subarray(3 * corners[3 * index + k], 3 * corners[3 * index + k] + 3)]);
  return [a, b, b, c, c, a].flat();
}

function cropControls(session: Session, box: Box, changed: (crop: Box) => void): HTMLElement {
  const crop: Box = {low: [...box.low], high: [...box.high]};
  const positions = session.state.cloud?.data?.positions ?? new Float32Array();
  const tally = h('p', {class: 'number'});
  const tell = (): void => {
    tally.textContent = t.tools.kept(count(countInside(positions, crop)), count(positions.length / 3));
    changed(crop);
  };
  const slider = (axis: 0|1|2, side: 'low'|'high') => {
    const [from, to] = [box.low[axis], box.high[axis]];
    const input = h('input', {
      type: 'range',
      min: 0,
      max: 1000,
      value: side === 'low' ? '0' : '1000',
      id: `crop-${kAxes[axis]}-${side}`,
      'aria-label': (side === 'low' ? t.tools.low : t.tools.high)(kAxes[axis])
    });
    input.addEventListener('input', () => {
      crop[side][axis] = from + (Number(input.value) / 1000) * (to - from);
      tell();
    });
    return input;
  };
  const rows = ([0, 1, 2] as const)
                   .map(
                       (axis) =>
                           h('div', {class: 'pair'}, h('span', {class: 'label'}, kAxes[axis]), slider(axis, 'low'),
                             slider(axis, 'high')));
  const apply =
      h('button',
        {type: 'button', class: 'button primary small', id: 'crop-apply', onclick: () => void cropCloud(session, crop)},
        t.tools.apply);
  tell();
  return h('div', {class: 'crop'}, h('p', {class: 'hint'}, t.tools.cropHint), ...rows, tally, apply);
}

function clipControls(session: Session, stage: Stage): HTMLElement {
  const {clip} = session.state;
  const names = (['none', ...kAxes] as const)
                    .map(
                        (name) =>
                            h('option', {value: name, selected: name === clip.axis},
                              name === 'none' ? t.view.notCut : t.view.cut(name)));
  const axis = h('select', {'aria-label': t.view.clip, id: 'clip'}, ...names);
  const slider = h('input', {
    type: 'range',
    min: 0,
    max: 1,
    step: 0.002,
    value: String(clip.place),
    'aria-label': t.view.place,
    id: 'clip-place'
  });
  const flip =
      h('button', {type: 'button', class: 'toggle', title: t.view.otherSide}, '⇄',
        h('span', {class: 'visually-hidden'}, t.view.otherSide));
  const set = (part: Partial<State['clip']>): void => {
    const rebuilt = (part.axis ?? clip.axis) !== clip.axis && (part.axis === 'none' || clip.axis === 'none');
    Object.assign(clip, part);
    slider.hidden = flip.hidden = clip.axis === 'none';
    if (rebuilt)
      session.change({}, 'view');
    else
      stage.setClip(clip);
  };
  slider.hidden = flip.hidden = clip.axis === 'none';
  axis.addEventListener('change', () => set({axis: axis.value as State['clip']['axis']}));
  slider.addEventListener('input', () => set({place: Number(slider.value)}));
  flip.addEventListener('click', () => set({flip: !clip.flip}));
  return h('span', {class: 'pair'}, axis, slider, flip);
}

export function mountTools(host: HTMLElement, session: Session, stage: Stage): void {
  let tool: Tool|undefined;
  let first: Picked|undefined;
  const said = h('div', {class: 'tool-said', role: 'status'});
  const show = (segments: number[]|undefined): void =>
      session.change({pointed: segments && Float32Array.from(segments)}, 'view');
  const say = (...lines: (string|HTMLElement)[]): void =>
      fill(said, ...lines.map((line) => (typeof line === 'string' ? h('p', {class: 'number'}, line) : line)));
  const hints: Record<Tool, string> = {pick: t.tools.pickHint, measure: t.tools.measureHint, crop: ''};
  const crop = (): void => {
    const data = session.state.cloud?.data;
    if (!data) return say();
    say(cropControls(session, boxOf(data.positions), (box) => show(boxEdges(box))));
  };
  const choose = (next: Tool|undefined): void => {
    tool = tool === next ? undefined : next;
    first = undefined;
    stage.canvas.style.cursor = tool === 'pick' || tool === 'measure' ? 'crosshair' : '';
    for (const [name, button] of buttons) button.setAttribute('aria-pressed', String(name === tool));
    if (session.state.pointed) show(undefined);
    if (tool === 'crop')
      crop();
    else if (tool)
      say(h('p', {class: 'hint'}, hints[tool]));
    else
      say();
  };
  const button = (name: Tool): [Tool, HTMLButtonElement] =>
      [name,
       h('button', {
         type: 'button',
         class: 'toggle',
         'aria-pressed': 'false',
         'data-tool': name,
         title: t.tools[`${name}Title`],
         onclick: () => choose(name)
       },
         t.tools[name])];
  const buttons = new Map((['pick', 'measure', 'crop'] as const).map(button));
  const undo =
      h('button', {type: 'button', class: 'toggle', id: 'uncrop', onclick: () => void uncrop(session)}, t.tools.undo);
  const at = (event: PointerEvent): [number, number] => {
    const frame = stage.canvas.getBoundingClientRect();
    return [event.clientX - frame.left, event.clientY - frame.top];
  };
  const clicked = (picked: Picked|undefined): void => {
    const {state} = session;
    const size = 6 * stage.unitsOfPixel();
    if (!picked) return say(h('p', {class: 'hint'}, t.tools.nothing));
    if (tool === 'pick') {
      show(outline(state, picked, size));
      return say(...describe(state, picked));
    }
    const earlier = first;
    first = earlier ? undefined : picked;
    show([
      ...crossAt(picked.place, size),
      ...(earlier ? [...crossAt(earlier.place, size), ...earlier.place, ...picked.place] : [])
    ]);
    if (earlier)
      say(t.tools.distance(real(distance(earlier.place, picked.place))));
    else
      say(t.tools.at(coordinates(inFile(state, picked.place))), h('p', {class: 'hint'}, t.tools.measureHint));
  };
  let pressed: [number, number]|undefined;
  stage.canvas.addEventListener('pointerdown', (event) => (pressed = at(event)));
  stage.canvas.addEventListener('pointerup', (event) => {
    const [x, y] = at(event);
    if (!pressed || !tool || tool === 'crop' || Math.hypot(x - pressed[0], y - pressed[1]) > kStill) return;
    clicked(stage.pick(x, y));
  });
  fill(host, h('div', {class: 'pair'}, ...buttons.values(), clipControls(session, stage), undo), said);
  let subject: unknown;
  session.onChange((state) => {
    host.hidden = !state.cloud?.data && !state.results[0];
    for (const [name, each] of buttons)
      each.hidden = name === 'crop' && (!state.cloud?.data || state.results[0] !== undefined);
    undo.hidden = !state.cloud?.whole;
    const now = state.results[0] ?? state.cloud?.data;
    if (now !== subject && tool) choose(tool);
    subject = now;
  });
}
