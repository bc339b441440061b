// SPDX-License-Identifier: GPL-3.0-or-later
// Points of text: XYZ, CSV, PTS, as the server reads them.
import {colourBytes, UnreadableCloud, type Points} from './cloud_data';
import {guessTable, kTableSample, type TableForm, type TableOptions} from './table';
import {isComment, isEmptyRow, parseCell, valuesOf} from './table_cells';

export interface TextPoints extends Points {
  form: TableForm;
}

/** The encoding, which a byte order mark or the zeros tell. */
export function encodingOf(bytes: Uint8Array): 'utf-16le'|'utf-16be'|'utf-8' {
  const [first, second] = bytes;
  const zeros =
      [0, 1].map((offset) => bytes.subarray(0, 16).filter((byte, i) => i % 2 === offset && byte === 0).length);
  if ((first === 0xff && second === 0xfe) || (zeros[0] === 0 && zeros[1] === 8)) return 'utf-16le';
  if ((first === 0xfe && second === 0xff) || (zeros[0] === 8 && zeros[1] === 0)) return 'utf-16be';
  return 'utf-8';
}

export const decodeText = (bytes: Uint8Array): string =>
    new TextDecoder(encodingOf(bytes)).decode(bytes).replace(/^\uFEFF/, '');

/** The form of a text, told by as many of its bytes as the server looks at. */
export function formOf(text: string, options: TableOptions = {}): TableForm {
  const bytes = new TextEncoder().encode(text.slice(0, kTableSample));
  if (bytes.length <= kTableSample && text.length <= kTableSample) return guessTable(text, true, options);
  return guessTable(new TextDecoder('utf-8').decode(bytes.subarray(0, kTableSample)), false, options);
}

/** How many points there are up to the end of a scan whose count stands alone; none where no count may stand. */
function countedIn(cell: string, points: number, declared: number|undefined): number|undefined {
  const begins = points === 0 ? !declared : declared !== undefined && points >= declared;
  return begins && /^\+?\d+$/.test(cell) ? points + Number(cell) : undefined;
}

export function readText(bytes: Uint8Array, options: TableOptions = {}): TextPoints {
  const text = decodeText(bytes);
  const form = formOf(text, options);
  const columns = (['x', 'y', 'z'] as const).map((role) => form.roles.indexOf(role));
  const tints = (['r', 'g', 'b'] as const).map((role) => form.roles.indexOf(role));
  const values: number[] = [];
  const channels: number[] = [];
  let declared: number|undefined;
  text.split(/\r\n|\n|\r/).forEach((line, at) => {
    const start = line.trimStart();
    if (at < form.skip || start === '\u001a' || isComment(start)) return;
    const empty = isEmptyRow(line, form.separator);
    if (start === '' && !empty) return;
    const cells = valuesOf(line, form.separator);
    // The last value may be missing behind its separator.
    if (form.separator !== ' ' && line.endsWith(form.separator)) cells.push('');
    while (empty && cells.length < form.roles.length) cells.push('');
    if (cells.length === 1) {
      declared = countedIn(cells[0], values.length / 3, declared);
      if (declared === undefined) throw new UnreadableCloud(`line ${at + 1} of the text is no point`);
      return;
    }
    const point =
        columns.map((column) => (column < cells.length ? parseCell(cells[column], form.decimalComma) : undefined));
    if (point.includes(undefined)) throw new UnreadableCloud(`line ${at + 1} of the text is no point`);
    values.push(...(point as number[]));
    if (tints[0] >= 0)
      channels.push(...tints.map((column) => parseCell(cells[column] ?? '', form.decimalComma) ?? NaN));
  });
  if (values.length === 0) throw new UnreadableCloud('the text holds no points');
  return {
    xyz: Float64Array.from(values),
    form,
    colours: colourBytes(channels, channels.every(Number.isInteger)),
    normals: form.roles.includes('nx'),
  };
}

export function readObj(bytes: Uint8Array): Points {
  const values: number[] = [];
  const channels: number[] = [];
  let normals = false;
  let begun = '';
  for (const line of [...decodeText(bytes).split(/\r\n|\n|\r/), '']) {
    const statement = begun + line.trim();
    begun = '';
    // It goes on in the next line; a path in a comment may end so too.
    if (statement.endsWith('\\') && !statement.startsWith('#')) {
      begun = `${statement.slice(0, -1)} `;
      continue;
    }
    const words = statement.split(/\s+/);
    normals ||= words[0] === 'vn';
    if (words[0] !== 'v') continue;
    values.push(Number(words[1]), Number(words[2]), Number(words[3]));
    if (words.length === 7) channels.push(Number(words[4]), Number(words[5]), Number(words[6]));
  }
  const coloured = channels.length === values.length;
  return {
    xyz: Float64Array.from(values),
    colours: coloured ? colourBytes(channels, channels.every(Number.isInteger)) : undefined,
    normals,
  };
}

export const isObj = (text: string): boolean => /^(\s*(#.*)?\r?\n)*\s*(v|vn|vt|o|g|mtllib|s|f)\s/.test(text);
