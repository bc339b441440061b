// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers as people read them.
import {language} from './language';

const whole = new Intl.NumberFormat(language, {maximumFractionDigits: 0});
const four = new Intl.NumberFormat(language, {maximumSignificantDigits: 4, useGrouping: false});
const localised = (text: string): string => (language === 'de' ? text.replace('.', ',') : text);

export const count = (value: number): string => whole.format(value);

export const countOf = (value: number, one: string, many = `${one}s`): string =>
    `${count(value)} ${value === 1 ? one : many}`;

/** Four significant digits; exponents only where they are shorter. */
export function real(value: number): string {
  if (value === 0 || !Number.isFinite(value)) return String(value);
  const size = Math.abs(value);
  return size >= 1e6 || size < 1e-3 ? localised(value.toExponential(2)) : four.format(value);
}

/** A share as a percentage of two digits, never an exponent; 100 only for all. */
export function percent(part: number, all: number): string {
  const share = (100 * part) / all;
  if (part < all && share > 99) return `> 99 %`;
  return `${localised(String(Number(share.toPrecision(2))))} %`;
}

export function bytes(value: number): string {
  const units = ['B', 'KiB', 'MiB', 'GiB', 'TiB'];
  let unit = 0;
  let size = value;
  while (size >= 1024 && unit + 1 < units.length) {
    size /= 1024;
    unit += 1;
  }
  return `${localised(unit === 0 ? String(size) : size.toFixed(size < 10 ? 1 : 0))} ${units[unit]}`;
}

export function seconds(value: number): string {
  if (value < 0.9995) return `${Math.round(1000 * value)} ms`;
  return value < 60 ? `${localised(value.toFixed(1))} s` : `${Math.floor(value / 60)} min ${Math.round(value % 60)} s`;
}
