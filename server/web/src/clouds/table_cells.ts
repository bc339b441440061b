// SPDX-License-Identifier: GPL-3.0-or-later
// Cells of a table: values between separators, numbers as people write them.
const kMostColumns = 64;
const kSeparatorWords: Record<string, string> = {
  tab: '\t',
  comma: ',',
  semicolon: ';',
  bar: '|',
  blank: ' '
};
const kNumber = /^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$/;
const kNotFinite = /^[+-]?(nan(\(\w*\))?|inf|infinity|1\.#(inf|qnan|snan|ind)\w*)$/i;
const kNoMeasurement = new Set(['', '-', '--', 'na', 'n/a', '#n/a', 'null', 'none', 'nil', 'nodata']);

export const wordOf = (separator: string): string =>
    Object.entries(kSeparatorWords).find(([, sign]) => sign === separator)?.[0] ?? 'blank';
/** Both the word and the sign itself say it. */
export const signOf = (given: string): string => kSeparatorWords[given] ?? given;
export const trimmed = (text: string): string => text.replace(/^[ \t\v\f]+|[ \t\v\f]+$/g, '');
export const isWhole = (cell: string): boolean => /^[+-]?\d+$/.test(cell);
/** #N/A is what spreadsheets write for no value. */
export const isComment = (line: string): boolean =>
    (line.startsWith('#') && !/^#n\/a/i.test(line)) || line.startsWith('//');
/** Nothing but separators, two at least, and empty quotes: a point without a measurement. */
export const isEmptyRow = (line: string, separator: string): boolean => separator !== ' ' &&
    line.split(separator).length > 2 && [...line].every((c) => c === separator || c === '"' || /[ \t\v\f]/.test(c));
export const isContent = (line: string): boolean =>
    trimmed(line) !== '' && !isComment(trimmed(line)) && !isWhole(trimmed(line));
export const withoutMark = (line: string): string => trimmed(line.slice(line.startsWith('//') ? 2 : 1));

/** Digits in groups of three, at least two of them, and perhaps a decimal sign and more digits. */
export const kCommaGroups = /^[+-]?\d{1,3}(,\d{3})+(\.\d*)?$/;
const kPointGroups = /^[+-]?\d{1,3}(\.\d{3})+(,\d*)?$/;

/** 1'234.5 or 1 234.5. */
const kOtherGroups = /^[+-]?\d{1,3}(?:('\d{3})+|( \d{3})+)(\.\d*)?$/;
const kOtherGroupsWithComma = /^[+-]?\d{1,3}(?:('\d{3})+|( \d{3})+)(,\d*)?$/;

const readNumber = (text: string): number|undefined =>
    (kNumber.test(text)        ? Number(text) :
         kNotFinite.test(text) ? NaN :
                                 undefined);

/** A number that is written as programs for people write it. */
function readUnusual(text: string, decimalComma: boolean): number|undefined {
  if (kOtherGroups.test(text)) return readNumber(text.replace(/[' ]/g, ''));
  if (decimalComma && kPointGroups.test(text)) return readNumber(text.replaceAll('.', ''));
  return readNumber(text.replaceAll('\u2212', '-').replace(/(?<=.)[Dd](?=[+-])/g, 'e'));
}

function parseValue(text: string, decimalComma: boolean): number|undefined {
  if (!text.includes(',')) return readNumber(text) ?? readUnusual(text, decimalComma);
  if (kCommaGroups.test(text) && text.includes('.')) return readNumber(text.replaceAll(',', ''));
  if (!decimalComma) return undefined;
  const grouped = kPointGroups.test(text) ? text.replaceAll('.', '') :
      kOtherGroupsWithComma.test(text)    ? text.replace(/[' ]/g, '') :
                                            text;
  const pointed = grouped.replace(',', '.');
  return readNumber(pointed) ?? readUnusual(pointed, false);
}

/** A number of a table; NaN for what stands for no measurement, none for anything else. */
export function parseCell(text: string, decimalComma: boolean): number|undefined {
  return parseValue(text, decimalComma) ?? (kNoMeasurement.has(text.toLowerCase()) ? NaN : undefined);
}

export const isNumber = (cell: string, decimalComma: boolean): boolean => parseValue(cell, decimalComma) !== undefined;
/** Numbers, and words for no measurement. */
export const countValues = (cells: string[], decimalComma: boolean): number =>
    cells.filter((cell) => cell !== '' && parseCell(cell, decimalComma) !== undefined).length;

function unquoted(value: string): string {
  const cell = trimmed(value);
  return cell.length >= 2 && cell.startsWith('"') && cell.endsWith('"') ? trimmed(cell.slice(1, -1)) : cell;
}

/**
 * The values of a line, as many as there are. A separator within quotes is none, and one at the end of the line
 * neither.
 */
export function valuesOf(line: string, separator: string): string[] {
  const blank = separator === ' ';
  const rest = blank || line.includes('"') ? trimmed(line) : line;
  if (rest === '') return [];
  if (!rest.includes('"')) {
    const values = blank ? rest.split(/[ \t\v\f]+/) : rest.split(separator);
    if (!blank && values[values.length - 1] === '') values.pop();
    return values.map(trimmed);
  }
  const values: string[] = [];
  let inside = false;
  let begin = 0;
  for (let i = 0; i <= rest.length; i += 1) {
    if (rest[i] === '"') inside = !inside;
    const ends = i === rest.length || (!inside && (rest[i] === separator || (blank && /[ \t\v\f]/.test(rest[i]))));
    if (!ends) continue;
    if (i > begin || (!blank && i < rest.length)) values.push(unquoted(rest.slice(begin, i)));
    begin = i + 1;
  }
  return values;
}

export const cellsOf = (line: string, separator: string): string[] => valuesOf(line, separator).slice(0, kMostColumns);

export const hasDecimalComma = (cell: string): boolean =>
    /^[^,]*,\d[^,]*$/.test(cell) && (!cell.includes('.') || kPointGroups.test(cell));
