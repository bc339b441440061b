// SPDX-License-Identifier: GPL-3.0-or-later
// Name, links, key, theme, language.
import type {Session} from '../app/session';
import {chooseLanguage, language, languages, type Language} from '../words/language';
import {t} from '../words/words';
import {fill, h} from './dom';

function keyDialog(session: Session): HTMLDialogElement {
  const input = h('input', {type: 'password', id: 'key', autocomplete: 'off', value: session.api.key});
  const dialog = h('dialog', {'aria-labelledby': 'key-title'});
  const use = (): void => {
    dialog.close();
    void session.useKey(input.value);
  };
  fill(
      dialog, h('h2', {id: 'key-title'}, t.top.key), h('p', {class: 'hint'}, t.top.keyText),
      h('div', {class: 'field'}, h('label', {'for': 'key'}, t.top.key), input),
      h('div', {class: 'row'}, h('button', {type: 'button', class: 'button primary', onclick: use}, t.top.use),
        h('button', {type: 'button', class: 'button', onclick: () => dialog.close()}, t.top.close)));
  input.addEventListener('keydown', (event) => {
    if (event.key !== 'Enter') return;
    // Or it presses the button that gets the focus back.
    event.preventDefault();
    use();
  });
  return dialog;
}

function languageSelect(): HTMLSelectElement {
  const options = Object.entries(languages).map(
      ([value, text]) => h('option', {value, lang: value, selected: value === language}, text));
  const select = h('select', {id: 'language', class: 'quiet', 'aria-label': t.top.language}, ...options);
  select.addEventListener('change', () => chooseLanguage(select.value as Language));
  return select;
}

export function mountTopBar(host: HTMLElement, session: Session): void {
  const dialog = keyDialog(session);
  const key =
      h('button', {type: 'button', class: 'quiet', id: 'key-button', onclick: () => dialog.showModal()}, t.top.key);
  const theme = h('button', {type: 'button', class: 'quiet', id: 'theme'});
  theme.addEventListener('click', () => {
    const next = session.state.theme === 'dark' ? 'light' : 'dark';
    localStorage.setItem('surfaced.theme', next);
    session.change({theme: next}, 'view');
  });
  const icon = h('span', {class: 'mark', 'aria-hidden': 'true'});
  const links: [string, string][] =
      [['docs', t.top.api], ['licenses', t.top.licences], [__SOURCE_URL__ || 'licenses#source', t.top.source]];
  fill(
      host, h('h1', {}, icon, 'surfaced'), h('p', {class: 'tagline'}, t.top.tagline),
      h('nav', {'aria-label': t.top.about}, ...links.map(([href, text]) => h('a', {href}, text)), key, theme,
        languageSelect(), h('span', {class: 'version'}, __VERSION__)),
      dialog);
  let asked = false;
  const update = (): void => {
    const {theme: now, needsKey, error} = session.state;
    document.documentElement.dataset.theme = now;
    theme.textContent = now === 'dark' ? t.top.light : t.top.dark;
    key.classList.toggle('wanted', needsKey && session.api.key === '');
    // Asked for once each time the server says so.
    const wanted = error?.code === 'unauthorized';
    if (wanted && !asked && !dialog.open) dialog.showModal();
    asked = wanted;
  };
  session.onChange(update);
  update();
}
