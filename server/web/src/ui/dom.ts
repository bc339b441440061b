// SPDX-License-Identifier: GPL-3.0-or-later
// Elements of the page, made without a template language.
type Child = Node|string|null|undefined|false;
type Properties = Record<string, unknown>;

/**
 * An element with attributes, properties and listeners: `on…` is a listener, `class`, `for`, `aria-*` and `data-*` are
 * attributes.
 */
export function h<K extends keyof HTMLElementTagNameMap>(
    tag: K, properties: Properties = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith('on'))
      element.addEventListener(name.slice(2).toLowerCase(), value as EventListener);
    else if (name in element && name !== 'list' && name !== 'form')
      Reflect.set(element, name, value);
    else
      element.setAttribute(name, value === true ? '' : String(value));
  }
  fill(element, ...children);
  return element;
}

export function fill(element: Element, ...children: Child[]): void {
  element.replaceChildren(
      ...children.filter((child): child is Node|string => child !== null && child !== undefined && child !== false));
}

export function svg(tag: string, attributes: Record<string, string|number> = {}, ...children: Node[]): SVGElement {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

export function must<T extends Element>(selector: string): T {
  const found = document.querySelector<T>(selector);
  if (!found) throw new Error(`the page has no ${selector}`);
  return found;
}
