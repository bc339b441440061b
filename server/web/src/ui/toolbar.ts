// SPDX-License-Identifier: GPL-3.0-or-later
// How the result is looked at.
import {colourChoices} from '../app/contents';
import type {Session} from '../app/session';
import type {ColourBy, State} from '../app/state';
import type {Look} from '../view/layers';
import type {Stage} from '../view/stage';
import {t} from '../words/words';
import {turnUp} from './compass';
import {fill, h, must} from './dom';

const toggles: [keyof Look, string, string][] = [
  ['points', t.view.points, 'p'],
  ['surface', t.view.surface, 's'],
  ['wireframe', t.view.wireframe, 'e'],
  ['smooth', t.view.smooth, 'm'],
  ['marks', t.view.marks, 'k'],
  ['shade', t.view.shade, 'd'],
];
/** These are of points alone, too. */
const kWithoutMesh: (keyof Look)[] = ['points', 'shade'];

const isAble = (key: keyof Look, state: State): boolean => state.results[0] !== undefined || kWithoutMesh.includes(key);

export function mountToolbar(host: HTMLElement, session: Session): void {
  const toggle = (key: keyof Look): void => {
    if (isAble(key, session.state)) session.setLook({[key]: !session.state.look[key]});
  };
  const buttons = new Map(toggles.map(([key, text, letter]) => {
    const title = `${key === 'shade' ? t.view.shadeTitle : text} (${letter})`;
    return [
      key, h('button', {type: 'button', class: 'toggle', 'data-look': key, title, onclick: () => toggle(key)}, text)
    ] as const;
  }));
  const colour = h('select', {id: 'colour', 'aria-label': t.view.colour});
  colour.addEventListener('change', () => session.setColour(colour.value as ColourBy));
  fill(host, h('span', {class: 'pair'}, ...buttons.values()), colour);
  const update = (state: State): void => {
    for (const [key, button] of buttons) {
      button.setAttribute('aria-pressed', String(state.look[key]));
      button.setAttribute('aria-disabled', String(!isAble(key, state)));
    }
    host.hidden = !state.cloud?.data && !state.results[0];
    const options = colourChoices(state);
    const values = options.map(([value]) => value).join();
    if ([...colour.options].map(({value}) => value).join() !== values)
      fill(colour, ...options.map(([value, text]) => h('option', {value}, text)));
    colour.value = options.some(([value]) => value === state.colour) ? state.colour : 'none';
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
    const found = toggles.find(([, , letter]) => letter === event.key);
    if (found && isAble(found[0], session.state)) session.setLook({[found[0]]: !session.state.look[found[0]]});
    if (event.key === 'f') stage.fit(session.state.up);
    if (event.key === 'u') turnUp(session);
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
