// SPDX-License-Identifier: GPL-3.0-or-later
// Work on the cloud: say what is under a place, measure, cut by a plane, crop by a box.
import {uncrop} from '../app/cropping';
import type {Session} from '../app/session';
import type {State} from '../app/state';
import {boxEdges, boxOf} from '../geometry/box';
import type {Picked} from '../view/picking';
import type {Stage} from '../view/stage';
import {count, real} from '../words/numbers';
import {t} from '../words/words';
import {clipControls, cropControls} from './cutting';
import {fill, h} from './dom';

const kTools = ['pick', 'measure', 'crop'] as const;
type Tool = typeof kTools[number];
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

/** What the tools say and draw. */
interface Answers {
  say(...lines: (string|HTMLElement)[]): void;
  /** Ends of lines, in the frame of the mesh or cloud. */
  show(segments: number[]|undefined): void;
}

function pick(state: State, picked: Picked, size: number, {say, show}: Answers): void {
  show(outline(state, picked, size));
  say(...describe(state, picked));
}

/** @param earlier the other end, if there is one already. */
function measure(state: State, picked: Picked, earlier: Picked|undefined, size: number, {say, show}: Answers): void {
  const here = crossAt(picked.place, size);
  if (!earlier) {
    show(here);
    return say(t.tools.at(coordinates(inFile(state, picked.place))), h('p', {class: 'hint'}, t.tools.measureHint));
  }
  show([...here, ...crossAt(earlier.place, size), ...earlier.place, ...picked.place]);
  say(t.tools.distance(real(distance(earlier.place, picked.place))));
}

/** Calls with the place of each press that turns nothing. */
function onPress(canvas: HTMLCanvasElement, act: (x: number, y: number) => void): void {
  const at = (event: PointerEvent): [number, number] => {
    const frame = canvas.getBoundingClientRect();
    return [event.clientX - frame.left, event.clientY - frame.top];
  };
  let pressed: [number, number]|undefined;
  canvas.addEventListener('pointerdown', (event) => (pressed = at(event)));
  canvas.addEventListener('pointerup', (event) => {
    const [x, y] = at(event);
    if (pressed && Math.hypot(x - pressed[0], y - pressed[1]) <= kStill) act(x, y);
  });
}

function toolButtons(choose: (tool: Tool) => void): Map<Tool, HTMLButtonElement> {
  return new Map(kTools.map((name) => {
    const title = t.tools[`${name}Title`];
    const press = () => choose(name);
    const properties =
        {type: 'button', class: 'toggle', 'aria-pressed': 'false', 'data-tool': name, title, onclick: press};
    return [name, h('button', properties, t.tools[name])];
  }));
}

export function mountTools(host: HTMLElement, session: Session, stage: Stage): void {
  let tool: Tool|undefined;
  let earlier: Picked|undefined;
  const said = h('div', {class: 'tool-said', role: 'status'});
  const show = (segments: number[]|undefined): void =>
      session.change({pointed: segments && Float32Array.from(segments)}, 'view');
  const say = (...lines: (string|HTMLElement)[]): void =>
      fill(said, ...lines.map((line) => (typeof line === 'string' ? h('p', {class: 'number'}, line) : line)));
  const begin: Record<Tool, () => void> = {
    pick: () => say(h('p', {class: 'hint'}, t.tools.pickHint)),
    measure: () => say(h('p', {class: 'hint'}, t.tools.measureHint)),
    crop: () => {
      const data = session.state.cloud?.data;
      if (data) say(cropControls(session, boxOf(data.positions), (box) => show(boxEdges(box))));
    },
  };
  /** The same again ends it. */
  const choose = (next: Tool): void => {
    tool = tool === next ? undefined : next;
    earlier = undefined;
    stage.canvas.style.cursor = tool === 'pick' || tool === 'measure' ? 'crosshair' : '';
    for (const [name, button] of buttons) button.setAttribute('aria-pressed', String(name === tool));
    if (session.state.pointed) show(undefined);
    say();
    if (tool) begin[tool]();
  };
  const buttons = toolButtons(choose);
  onPress(stage.canvas, (x, y) => {
    if (tool !== 'pick' && tool !== 'measure') return;
    const picked = stage.pick(x, y);
    const size = 6 * stage.unitsOfPixel();
    if (!picked) return say(h('p', {class: 'hint'}, t.tools.nothing));
    if (tool === 'pick') return pick(session.state, picked, size, {say, show});
    measure(session.state, picked, earlier, size, {say, show});
    earlier = earlier ? undefined : picked;
  });
  const undo =
      h('button', {type: 'button', class: 'toggle', id: 'uncrop', onclick: () => void uncrop(session)}, t.tools.undo);
  fill(host, h('div', {class: 'pair'}, ...buttons.values(), clipControls(session, stage), undo), said);
  followSubject(session, host, undo, buttons, () => tool && choose(tool));
}

/** Another cloud or mesh ends what was begun on the one before. */
function followSubject(
    session: Session, host: HTMLElement, undo: HTMLElement, buttons: Map<Tool, HTMLElement>, end: () => void): void {
  let subject: unknown;
  session.onChange(({cloud, results: [first]}) => {
    host.hidden = !cloud?.data && !first;
    const crop = buttons.get('crop');
    if (crop) crop.hidden = !cloud?.data || !cloud.file || first !== undefined;
    undo.hidden = !cloud?.whole;
    const now = first ?? cloud?.data;
    if (now !== subject) end();
    subject = now;
  });
}
