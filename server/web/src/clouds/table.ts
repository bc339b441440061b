// SPDX-License-Identifier: GPL-3.0-or-later
// How a table of text is made: the rules of core/io/table_guess.cpp. Both are held to tests/support/tables.json.
import { UnreadableCloud } from './cloud_data';
import { meaningOf, rolesNamed, withoutUnits, type Role } from './table_names';
import { rolesByValues, type ColumnValues } from './table_values';

export interface TableOptions {
  columns?: string;
  separator?: string;
  decimal?: string;
  skip?: number;
}

export interface TableForm {
  /** A blank stands for any run of blanks and tabs. */
  separator: string;
  decimalComma: boolean;
  /** Lines before the first row, or before the count of points before it. */
  skip: number;
  roles: Role[];
  guessed: boolean;
  /** The first five rows, by their columns. */
  preview: string[][];
}

/** So much of a file is looked at, and so many of its rows. */
export const kTableSample = 65_536;
const kTableRows = 1000;
const kMostColumns = 64;
const kMostPreamble = 20;
const kSeparators = ['\t', ';', '|', ',', ' '];
const kSeparatorWords: Record<string, string> = { tab: '\t', comma: ',', semicolon: ';', bar: '|', blank: ' ' };
const kNumber = /^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$/;
const kNotFinite = /^[+-]?(nan(\(\w*\))?|inf|infinity|1\.#(inf|qnan|snan|ind)\w*)$/i;
const kNoMeasurement = new Set(['', '-', '--', 'na', 'n/a', '#n/a', 'null', 'none', 'nil', 'nodata']);

export const wordOf = (separator: string): string => Object.entries(kSeparatorWords).find(([, sign]) => sign === separator)?.[0] ?? 'blank';
/** Both the word and the sign itself say it. */
const signOf = (given: string): string => kSeparatorWords[given] ?? given;
const trimmed = (text: string): string => text.replace(/^[ \t\v\f]+|[ \t\v\f]+$/g, '');
const isWhole = (cell: string): boolean => /^[+-]?\d+$/.test(cell);
/** #N/A is what spreadsheets write for no value. */
export const isComment = (line: string): boolean => (line.startsWith('#') && !/^#n\/a/i.test(line)) || line.startsWith('//');
const withoutMark = (line: string): string => trimmed(line.slice(line.startsWith('//') ? 2 : 1));

/** Digits in groups of three, at least two of them, and perhaps a decimal sign and more digits. */
const kCommaGroups = /^[+-]?\d{1,3}(,\d{3})+(\.\d*)?$/;
const kPointGroups = /^[+-]?\d{1,3}(\.\d{3})+(,\d*)?$/;

/** 1'234.5 or 1 234.5. */
const kOtherGroups = /^[+-]?\d{1,3}(?:('\d{3})+|( \d{3})+)(\.\d*)?$/;
const kOtherGroupsWithComma = /^[+-]?\d{1,3}(?:('\d{3})+|( \d{3})+)(,\d*)?$/;

const readNumber = (text: string): number | undefined => (kNumber.test(text) ? Number(text) : kNotFinite.test(text) ? NaN : undefined);

/** A number that is written as programs for people write it. */
function readUnusual(text: string, decimalComma: boolean): number | undefined {
  if (kOtherGroups.test(text)) return readNumber(text.replace(/[' ]/g, ''));
  if (decimalComma && kPointGroups.test(text)) return readNumber(text.replaceAll('.', ''));
  return readNumber(text.replaceAll('\u2212', '-').replace(/(?<=.)[Dd](?=[+-])/g, 'e'));
}

function parseValue(text: string, decimalComma: boolean): number | undefined {
  if (!text.includes(',')) return readNumber(text) ?? readUnusual(text, decimalComma);
  if (kCommaGroups.test(text) && text.includes('.')) return readNumber(text.replaceAll(',', ''));
  if (!decimalComma) return undefined;
  const grouped = kPointGroups.test(text) ? text.replaceAll('.', '') : kOtherGroupsWithComma.test(text) ? text.replace(/[' ]/g, '') : text;
  const pointed = grouped.replace(',', '.');
  return readNumber(pointed) ?? readUnusual(pointed, false);
}

/** A number of a table; NaN for what stands for no measurement, none for anything else. */
export function parseCell(text: string, decimalComma: boolean): number | undefined {
  return parseValue(text, decimalComma) ?? (kNoMeasurement.has(text.toLowerCase()) ? NaN : undefined);
}

const isNumber = (cell: string, decimalComma: boolean): boolean => parseValue(cell, decimalComma) !== undefined;
/** Numbers, and words for no measurement. */
const countValues = (cells: string[], decimalComma: boolean): number => cells.filter((cell) => cell !== '' && parseCell(cell, decimalComma) !== undefined).length;

function unquoted(value: string): string {
  const cell = trimmed(value);
  return cell.length >= 2 && cell.startsWith('"') && cell.endsWith('"') ? trimmed(cell.slice(1, -1)) : cell;
}

/** The values of a line, as many as there are. A separator within quotes is none, and one at the end of the line neither. */
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

const cellsOf = (line: string, separator: string): string[] => valuesOf(line, separator).slice(0, kMostColumns);

const hasDecimalComma = (cell: string): boolean => /^[^,]*,\d[^,]*$/.test(cell) && (!cell.includes('.') || kPointGroups.test(cell));

class Guesser {
  private roles: Role[] | undefined;
  private header: string | undefined;
  private hinted: string | undefined;
  private tries = 0;
  private lastPassed = '';
  private rows: string[] = [];
  private readonly form: TableForm;

  constructor(private readonly options: TableOptions) {
    this.form = { separator: ' ', decimalComma: false, skip: options.skip ?? 0, roles: [], guessed: false, preview: [] };
  }

  run(lines: string[]): TableForm {
    if (this.options.columns) {
      this.roles = rolesNamed(this.options.columns);
      if (!this.roles) throw new UnreadableCloud(`columns=${this.options.columns} is no list of x, y, z, nx, ny, nz, r, g, b and -`);
    }
    this.findTable(lines);
    this.tellSeparator();
    this.tellColumns();
    this.form.preview = this.rows.slice(0, 5).map((row) => cellsOf(row, this.form.separator));
    return this.form;
  }

  private findTable(lines: string[]): void {
    let preamble = 0;
    let at = this.form.skip;
    for (; at < lines.length && preamble <= kMostPreamble; at += 1) {
      const line = trimmed(lines[at]);
      if (line === '' || isWhole(line)) continue;
      const comment = isComment(line);
      if (!comment && this.looksLikeRow(line)) break;
      const known = (!comment && this.takeHint(line)) || this.takeHeader(comment ? withoutMark(line) : lines[at]);
      if (known || !comment) this.form.skip = at + 1;
      if (known || comment) continue;
      this.lastPassed = line;
      preamble += 1;
    }
    if (preamble > kMostPreamble) at = lines.length; // prose
    for (; at < lines.length && this.rows.length < kTableRows; at += 1) {
      const line = trimmed(lines[at]);
      if (line !== '' && !isComment(line) && !isWhole(line)) this.rows.push(lines[at]);
    }
    if (this.rows.length === 0 && !this.header) throw new UnreadableCloud('no line of the text holds three numbers');
  }

  private takeHint(line: string): boolean {
    if (line.length !== 5 || line.slice(0, 4).toLowerCase() !== 'sep=') return false;
    this.hinted = line[4];
    return true;
  }

  private looksLikeRow(line: string): boolean {
    const given = this.options.separator;
    return (given ? [signOf(given)] : kSeparators).some((separator) => countValues(cellsOf(line, separator), true) >= (this.header === undefined ? 3 : 1));
  }

  private takeHeader(line: string): boolean {
    if (this.header !== undefined || line.length < 5) return false;
    this.tries += 1;
    if (this.tries > 100) return false;
    const text = withoutUnits(line);
    const known = kSeparators.some((separator) => {
      const meaning = meaningOf(cellsOf(text, separator));
      return meaning.hasPosition || meaning.degrees;
    });
    if (known) this.header = line;
    return known;
  }

  private tellSeparator(): void {
    const { form, options } = this;
    form.separator = options.separator ? signOf(options.separator) : (this.hinted ?? (this.rows.length === 0 ? this.separatorOfHeader() : this.guessedSeparator()));
    if (options.decimal) {
      form.decimalComma = ['comma', ','].includes(options.decimal);
      return;
    }
    form.decimalComma = this.rows.some((row) => cellsOf(row, form.separator).some((cell) => hasDecimalComma(cell) && isNumber(cell, true)));
    const thousands = this.rows.some((row) => cellsOf(row, form.separator).some((cell) => cell.includes('.') && kCommaGroups.test(cell)));
    if (form.decimalComma && thousands) throw new UnreadableCloud('commas stand between thousands and seem to be decimal commas elsewhere');
    form.guessed ||= form.decimalComma || thousands;
    this.checkCommas();
  }

  private separatorOfHeader(): string {
    const text = withoutUnits(this.header ?? '');
    return kSeparators.find((separator) => meaningOf(cellsOf(text, separator)).hasPosition) ?? ' ';
  }

  private guessedSeparator(): string {
    const good = kSeparators.find((separator) => {
      const bad = this.rows.filter((row) => countValues(cellsOf(row, separator), separator !== ',') < 3).length;
      return 10 * bad <= this.rows.length;
    });
    return good ?? ['\t', ';', '|', ','].find((separator) => this.rows[0].includes(separator)) ?? ' ';
  }

  private checkCommas(): void {
    const { form } = this;
    if (form.separator !== ',' || form.decimalComma || this.roles || this.options.separator || this.rows.some((row) => row.includes('"'))) return;
    let fraction = false;
    for (const row of this.rows) {
      const cells = cellsOf(row, ',');
      if (cells.length < 6 || cells.length % 2 !== 0 || !cells.every(isWhole)) return;
      const behind = cells.filter((_, i) => i % 2 === 1);
      if (behind.some((cell) => !/^\d/.test(cell))) return;
      fraction ||= behind.some((cell) => cell.length > 1 && cell.startsWith('0'));
    }
    if (fraction) throw new UnreadableCloud('commas separate the values and seem to be decimal commas as well');
  }

  private tellColumns(): void {
    const columns = this.rows.length === 0 ? 0 : this.columnsOfFirstRow();
    if (this.roles) {
      this.takeNamed(this.roles, columns);
    } else if (this.header !== undefined) {
      this.takeHeaderRoles(this.header, columns);
    } else {
      const values = this.valuesOfColumns(columns);
      this.form.roles = rolesByValues(values);
      if (!this.form.roles.includes('x')) {
        // The first row decides, so that a later one that breaks the table is named where it is read.
        const cells = cellsOf(this.rows[0], this.form.separator);
        values.forEach((column, c) => { column.numeric = isNumber(cells[c], this.form.decimalComma); });
        this.form.roles = rolesByValues(values);
      }
      if (!this.form.roles.includes('x')) throw new UnreadableCloud('no three of the columns hold numbers throughout');
      this.checkPassedOver(columns);
      this.form.guessed ||= columns > 3;
    }
  }

  /** A separator at its end is one more, where the header has a name for it. */
  private columnsOfFirstRow(): number {
    const { separator } = this.form;
    const columns = cellsOf(this.rows[0], separator).length;
    const open = separator !== ' ' && this.rows[0].endsWith(separator);
    return open && this.header !== undefined && cellsOf(this.header, separator).length === columns + 1 ? columns + 1 : columns;
  }

  private takeNamed(roles: Role[], columns: number): void {
    if (this.rows.length > 0 && columns < roles.length) {
      throw new UnreadableCloud(`columns=${roles.join(',')} names ${roles.length} columns; the first row has ${columns}`);
    }
    this.form.guessed = false;
    this.form.roles = [...roles, ...Array<Role>(Math.max(0, columns - roles.length)).fill('-')];
  }

  private takeHeaderRoles(header: string, columns: number): void {
    const text = withoutUnits(header);
    const read = [...new Set([this.form.separator, ...kSeparators])].map((separator) => meaningOf(cellsOf(text, separator))).filter((meaning) => meaning.hasPosition || meaning.degrees);
    const best = read.find((meaning) => meaning.roles.length === columns) ?? read[0];
    if (best.degrees) throw new UnreadableCloud('the columns are longitude and latitude, which are angles and no lengths');
    let { roles } = best;
    // A mark of a comment that is not one of ours.
    if (roles.length === columns + 1 && columns > 0 && best.names[0] === '') roles = roles.slice(1);
    if (roles.length + 1 === columns && this.rows.length > 0) {
      roles = ['-', ...roles];
      this.form.guessed = true;
    }
    this.form.guessed ||= best.synonyms;
    if (this.rows.length > 0 && roles.length !== columns) {
      this.form.guessed = true;
      const known = roles.includes('-') ? roles.indexOf('-') : roles.length;
      if (known < 3 || known > columns) throw new UnreadableCloud(`the header names ${roles.length} columns, the first row has ${columns}`);
      roles = [...roles.slice(0, known), ...Array<Role>(columns - known).fill('-')];
    }
    this.form.roles = roles;
  }

  private checkPassedOver(columns: number): void {
    const cells = this.lastPassed === '' ? [] : cellsOf(this.lastPassed, this.form.separator);
    if (cells.length !== columns || countValues(cells, true) > 0) return;
    throw new UnreadableCloud(`no columns x, y, z; found: ${cells.join(', ')}`);
  }

  private valuesOfColumns(columns: number): ColumnValues[] {
    const values: ColumnValues[] = Array.from({ length: columns }, () => ({ values: [], numeric: true }));
    for (const row of this.rows) {
      const cells = cellsOf(row, this.form.separator);
      values.forEach((column, c) => {
        const value = c < cells.length ? parseCell(cells[c], this.form.decimalComma) : NaN;
        if (value === undefined) column.numeric = false;
        column.values.push(value ?? NaN);
      });
    }
    for (const column of values) column.numeric &&= column.values.some((x) => !Number.isNaN(x));
    return values;
  }
}

/** @param whole whether the sample is all there is; otherwise its last line is not looked at. */
export function guessTable(sample: string, whole: boolean, options: TableOptions = {}): TableForm {
  const lines = sample.split(/\r\n|\n|\r/);
  if (whole ? lines[lines.length - 1] === '' : lines.length > 1) lines.pop();
  return new Guesser(options).run(lines);
}
