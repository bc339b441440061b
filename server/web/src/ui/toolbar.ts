// SPDX-License-Identifier: GPL-3.0-or-later
// How the result is looked at.
import type {Session} from '../app/session';
import type {ColourBy, State} from '../app/state';
import type {Look} from '../view/layers';
import type {Stage} from '../view/stage';
import {fill, h, must} from './dom';

const toggles: [keyof Look, string, string][] = [
  ['points', 'Points', 'p'],
  ['surface', 'Surface', 's'],
  ['wireframe', 'Edges', 'e'],
  ['smooth', 'Smooth', 'm'],
  ['marks', 'Marks', 'k'],
];

function colours(state: State): [ColourBy, string][] {
  const [first, second] = state.results;
  const list: [ColourBy, string][] = [['none', 'Plain'], ['lR', 'l/R'], ['rL', 'r/L'], ['angle', 'Smallest angle']];
  if (first && state.cloud?.data) list.push(['distance', 'Distance to the points']);
  if (first && second) list.push(['difference', 'Difference of the two']);
  return list;
}

function clipControls(session: Session, stage: Stage): HTMLElement {
  const {clip} = session.state;
  const set = (part: Partial<State['clip']>): void => {
    const rebuilt = (part.axis ?? clip.axis) !== clip.axis && (part.axis === 'none' || clip.axis === 'none');
    Object.assign(clip, part);
    slider.hidden = flip.hidden = clip.axis === 'none';
    if (rebuilt)
      session.change({}, 'view');
    else
      stage.setClip(clip);
  };
  const axis =
      h('select', {'aria-label': 'Clipping plane', id: 'clip'},
        ...['none', 'x', 'y', 'z'].map(
            (name) =>
                h('option', {value: name, selected: name === clip.axis}, name === 'none' ? 'Not cut' : `Cut ${name}`)));
  const slider = h('input', {
    type: 'range',
    min: 0,
    max: 1,
    step: 0.002,
    value: String(clip.place),
    hidden: clip.axis === 'none',
    'aria-label': 'Place of the cut',
    id: 'clip-place'
  });
  const flip =
      h('button', {type: 'button', class: 'toggle', hidden: clip.axis === 'none', title: 'The other side'}, '⇄',
        h('span', {class: 'visually-hidden'}, 'Show the other side of the cut'));
  axis.addEventListener('change', () => set({axis: axis.value as State['clip']['axis']}));
  slider.addEventListener('input', () => set({place: Number(slider.value)}));
  flip.addEventListener('click', () => set({flip: !clip.flip}));
  return h('span', {class: 'pair'}, axis, slider, flip);
}

export function mountToolbar(host: HTMLElement, session: Session, stage: Stage): void {
  const buttons = new Map(toggles.map(
      ([key, text, letter]) => [key,
                                h('button', {
                                  type: 'button',
                                  class: 'toggle',
                                  'data-look': key,
                                  title: `${text} (${letter})`,
                                  onclick: () => session.setLook({[key]: !session.state.look[key]})
                                },
                                  text)] as const));
  const colour = h('select', {id: 'colour', 'aria-label': 'Colour by'});
  colour.addEventListener('change', () => session.setColour(colour.value as ColourBy));
  const up = h('button', {type: 'button', class: 'toggle', title: 'Which axis points up (u)'});
  up.addEventListener('click', () => session.change({up: session.state.up === 'y' ? 'z' : 'y'}, 'view'));
  const fit =
      h('button',
        {type: 'button', class: 'toggle', title: 'All in view (f)', onclick: () => stage.fit(session.state.up)}, 'Fit');
  fill(
      host, h('span', {class: 'pair'}, ...buttons.values()), colour, clipControls(session, stage),
      h('span', {class: 'pair'}, up, fit));
  const update = (state: State): void => {
    for (const [key, button] of buttons) {
      button.setAttribute('aria-pressed', String(state.look[key]));
      button.disabled = key !== 'points' && !state.results[0];
    }
    host.hidden = !state.cloud?.data && !state.results[0];
    const options = colours(state);
    if (colour.options.length !== options.length)
      fill(colour, ...options.map(([value, text]) => h('option', {value}, text)));
    colour.value = state.colour;
    colour.disabled = !state.results[0];
    up.textContent = `${state.up} up`;
  };
  session.onChange(update);
  update(session.state);
}

/**
 * Letters that do what the buttons do, arrows that turn; only while the canvas or its toolbar has the focus, and no
 * field there.
 */
export function listenToKeys(session: Session, stage: Stage): void {
  must<HTMLElement>('#view').addEventListener('keydown', (event) => {
    const target = event.target as HTMLElement;
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName)) return;
    const toggle = toggles.find(([, , letter]) => letter === event.key);
    if (toggle && session.state.results[0]) session.setLook({[toggle[0]]: !session.state.look[toggle[0]]});
    if (event.key === 'f') stage.fit(session.state.up);
    if (event.key === 'u') session.change({up: session.state.up === 'y' ? 'z' : 'y'}, 'view');
    if (target !== stage.canvas) return;
    const turns: Record<string, () => void> = {
      ArrowLeft: () => stage.orbit(-0.12, 0),
      ArrowRight: () => stage.orbit(0.12, 0),
      ArrowUp: () => stage.orbit(0, 0.12),
      ArrowDown: () => stage.orbit(0, -0.12),
      '+': () => stage.zoom(0.88),
      '-': () => stage.zoom(1.14)
    };
    if (!turns[event.key]) return;
    event.preventDefault();
    turns[event.key]();
  });
}
