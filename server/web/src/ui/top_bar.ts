// SPDX-License-Identifier: GPL-3.0-or-later
// Name, links, key, theme.
import type {Session} from '../app/session';
import {fill, h} from './dom';

function keyDialog(session: Session): HTMLDialogElement {
  const input = h('input', {type: 'password', id: 'key', autocomplete: 'off', value: session.api.key});
  const dialog = h('dialog', {'aria-labelledby': 'key-title'});
  const use = (): void => {
    dialog.close();
    void session.useKey(input.value);
  };
  fill(
      dialog, h('h2', {id: 'key-title'}, 'Key'),
      h('p', {class: 'hint'},
        'If this server wants one: the text that `surfaced keys add` printed. It is kept until this tab is closed.'),
      h('div', {class: 'field'},
        h('label',
          { for: 'key'
          },
          'Key'),
        input),
      h('div', {class: 'row'}, h('button', {type: 'button', class: 'button primary', onclick: use}, 'Use'),
        h('button', {type: 'button', class: 'button', onclick: () => dialog.close()}, 'Close')));
  input.addEventListener('keydown', (event) => {
    if (event.key !== 'Enter') return;
    // Or it presses the button that gets the focus back.
    event.preventDefault();
    use();
  });
  return dialog;
}

export function mountTopBar(host: HTMLElement, session: Session): void {
  const dialog = keyDialog(session);
  const key = h('button', {type: 'button', class: 'quiet', id: 'key-button', onclick: () => dialog.showModal()}, 'Key');
  const theme = h('button', {type: 'button', class: 'quiet', id: 'theme'});
  theme.addEventListener('click', () => {
    const next = session.state.theme === 'dark' ? 'light' : 'dark';
    localStorage.setItem('surfaced.theme', next);
    session.change({theme: next}, 'view');
  });
  const icon = h('span', {class: 'mark', 'aria-hidden': 'true'});
  const links: [string, string][] =
      [['docs', 'API'], ['licenses', 'Licences'], [__SOURCE_URL__ || 'licenses#source', 'Source']];
  fill(
      host, h('h1', {}, icon, 'surfaced'), h('p', {class: 'tagline'}, 'point clouds to meshes'),
      h('nav', {'aria-label': 'About'}, ...links.map(([href, text]) => h('a', {href}, text)), key, theme,
        h('span', {class: 'version'}, __VERSION__)),
      dialog);
  const update = (): void => {
    const {theme: now, needsKey} = session.state;
    document.documentElement.dataset.theme = now;
    theme.textContent = now === 'dark' ? 'Light' : 'Dark';
    key.classList.toggle('wanted', needsKey && session.api.key === '');
  };
  session.onChange(update);
  update();
}
