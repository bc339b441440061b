// SPDX-License-Identifier: GPL-3.0-or-later
// Positions of text: XYZ, CSV, PTS. The first three numbers of a line are the point, unless a header names the columns.
import { UnreadableCloud } from './cloud_data';

const kComment = /^\s*(#|\/\/|;|$)/;

export function splitLine(line: string): string[] {
  const trimmed = line.trim();
  if (trimmed.includes(';')) return trimmed.replaceAll(',', '.').split(/[\s;]+/);
  if (trimmed.includes('\t') || !trimmed.includes(',')) return trimmed.split(/\s+/);
  return trimmed.split(/\s*,\s*/);
}

function columnsOf(words: string[]): number[] | undefined {
  const names = words.map((word) => word.toLowerCase().replace(/["/]/g, ''));
  const columns = ['x', 'y', 'z'].map((axis) => names.findIndex((name) => name === axis || name === `${axis}coord`));
  return columns.includes(-1) ? undefined : columns;
}

export function readText(bytes: Uint8Array): Float64Array {
  const lines = new TextDecoder('utf-8').decode(bytes).replace(/^\uFEFF/, '').split(/\r?\n/);
  const values: number[] = [];
  let columns = [0, 1, 2];
  let header = false;
  lines.forEach((line, at) => {
    if (kComment.test(line)) return;
    const words = splitLine(line);
    const point = columns.map((column) => Number(words[column] || NaN));
    if (point.every(Number.isFinite)) {
      values.push(...point);
      return;
    }
    // PTS gives the count of the points that follow.
    if (words.length === 1 && /^\d+$/.test(words[0])) return;
    if (header || values.length > 0) throw new UnreadableCloud(`line ${at + 1} of the text is no point`);
    header = true;
    columns = columnsOf(words) ?? columns;
  });
  if (values.length === 0) throw new UnreadableCloud('the text holds no lines of three numbers');
  return Float64Array.from(values);
}

export function readObj(bytes: Uint8Array): Float64Array {
  const values: number[] = [];
  for (const line of new TextDecoder('utf-8').decode(bytes).split('\n')) {
    if (!line.startsWith('v ') && !line.startsWith('v\t')) continue;
    const words = line.trim().split(/\s+/);
    values.push(Number(words[1]), Number(words[2]), Number(words[3]));
  }
  return Float64Array.from(values);
}

export const isObj = (text: string): boolean => /^(\s*(#.*)?\r?\n)*\s*(v|vn|vt|o|g|mtllib|s|f)\s/.test(text);
