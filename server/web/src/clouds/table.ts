// SPDX-License-Identifier: GPL-3.0-or-later
// How a table of text is made: the rules of core/io/table_guess.cpp. Both are held to tests/support/tables.json.
import {UnreadableCloud} from './cloud_data';
import {cellsOf, countValues, hasDecimalComma, isComment, isContent, isEmptyRow, isNumber, isWhole, kCommaGroups, parseCell, signOf, trimmed, withoutMark} from './table_cells';
import {meaningOf, rolesNamed, withoutUnits, type Role} from './table_names';
import {rolesByValues, type ColumnValues} from './table_values';

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
const kMostPreamble = 20;
const kMostBehindHeader = 3;
/** Lines with which a row of words and numbers is compared. */
const kCompared = 10;
const kSeparators = ['\t', ';', '|', ',', ' '];
/** Whether the line names x, y and z, whatever separates the names. */
function namesColumns(line: string): boolean {
  const text = withoutUnits(line);
  return line.length >= 5 && kSeparators.some((separator) => {
    const meaning = meaningOf(cellsOf(text, separator));
    return meaning.hasPosition || meaning.degrees;
  });
}

/** A row as a separator splits it: how many cells, and which of them hold values. */
function shapeOf(line: string, separator: string): {cells: number; values: number[]} {
  const cells = cellsOf(line, separator);
  return {cells: cells.length, values: cells.flatMap((cell, c) => (countValues([cell], true) > 0 ? [c] : []))};
}

/** No word beside its values, whose places are there: 17,,, */
const isSparse = (cells: string[], separator: string): boolean =>
    separator !== ' ' && cells.length >= 3 && cells.every((cell) => cell === '' || countValues([cell], true) > 0);

function areAlike(a: {cells: number; values: number[]}, b: {cells: number; values: number[]}): boolean {
  return b.values.length >= 3 && (a.cells === b.cells || [0, 1, 2].every((i) => a.values[i] === b.values[i]));
}

class Guesser {
  private roles: Role[]|undefined;
  private header: string|undefined;
  private hinted: string|undefined;
  private tries = 0;
  private lastPassed = '';
  private behindHeader = 0;
  private rows: string[] = [];
  private readonly form: TableForm;

  constructor(private readonly options: TableOptions) {
    this.form = {separator: ' ', decimalComma: false, skip: options.skip ?? 0, roles: [], guessed: false, preview: []};
  }

  run(lines: string[]): TableForm {
    if (this.options.columns) {
      this.roles = rolesNamed(this.options.columns);
      if (!this.roles)
        throw new UnreadableCloud(`columns=${this.options.columns} is no list of x, y, z, nx, ny, nz, r, g, b and -`);
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
      const blank = kSeparators.some((separator) => isEmptyRow(lines[at], separator));
      if (blank && this.header === undefined) continue;
      if (blank || (!comment && this.looksLikeRow(line) && this.beginsTable(lines, at))) break;
      const known = (!comment && this.takeHint(line)) || this.takeHeader(comment ? withoutMark(line) : lines[at]);
      if (known || !comment) this.form.skip = at + 1;
      if (known || comment) continue;
      this.lastPassed = line;
      if (this.header !== undefined) this.behindHeader += 1;
      preamble += 1;
    }
    if (preamble > kMostPreamble) at = lines.length;  // prose
    for (; at < lines.length && this.rows.length < kTableRows; at += 1) {
      if (isContent(lines[at])) this.rows.push(lines[at]);
    }
    const none = this.rows.length === 0 && (this.header === undefined || this.behindHeader > kMostBehindHeader);
    if (none) throw new UnreadableCloud('no line of the text holds three numbers');
    if (!this.options.columns && this.isProse()) throw new UnreadableCloud('the text is no table of points');
  }

  /** Words may stand beside the numbers of a row if they do so in most of the next lines. */
  private beginsTable(lines: string[], at: number): boolean {
    if (this.header !== undefined) return true;
    const next: string[] = [];
    for (let i = at + 1; i < lines.length && next.length < kCompared; i += 1)
      if (isContent(lines[i])) next.push(lines[i]);
    if (next.length > 0 && namesColumns(next[0])) return false;
    return this.separators().some((separator) => {
      const shape = shapeOf(lines[at], separator);
      if (isSparse(cellsOf(lines[at], separator), separator)) return true;
      if (shape.values.length < 3) return false;
      // A last line of words and numbers behind others is prose.
      if (next.length === 0 && shape.values.length < shape.cells) return this.lastPassed === '';
      const alike = next.filter((line) => areAlike(shape, shapeOf(line, separator))).length;
      return shape.values.length === shape.cells || 2 * alike >= next.length;
    });
  }

  /** A few broken rows do not make it that. */
  private isProse(): boolean {
    const rows = this.rows.filter(
        (row) => this.looksLikeRow(row) || kSeparators.some((separator) => isEmptyRow(row, separator)));
    return 2 * rows.length < this.rows.length;
  }

  private takeHint(line: string): boolean {
    if (line.length !== 5 || line.slice(0, 4).toLowerCase() !== 'sep=') return false;
    this.hinted = line[4];
    return true;
  }

  private separators(): string[] {
    return this.options.separator ? [signOf(this.options.separator)] : kSeparators;
  }

  private looksLikeRow(line: string): boolean {
    return this.separators().some((separator) => {
      const cells = cellsOf(line, separator);
      const values = countValues(cells, true);
      return values >= (this.header === undefined ? 3 : 1) || (values > 0 && isSparse(cells, separator));
    });
  }

  private takeHeader(line: string): boolean {
    if (this.header !== undefined) return false;
    this.tries += 1;
    if (this.tries > 100 || !namesColumns(line)) return false;
    this.header = line;
    return true;
  }

  /** The first with three values, or else with anything. */
  private firstRow(): string {
    const withValues = (least: number): string|undefined =>
        this.rows.find((row) => countValues(cellsOf(row, this.form.separator), true) >= least);
    return withValues(3) ?? withValues(1) ?? this.rows[0];
  }

  private tellSeparator(): void {
    const {form, options} = this;
    form.separator = options.separator ?
        signOf(options.separator) :
        (this.hinted ?? (this.rows.length === 0 ? this.separatorOfHeader() : this.guessedSeparator()));
    if (options.decimal) {
      form.decimalComma = ['comma', ','].includes(options.decimal);
      return;
    }
    form.decimalComma = this.rows.some(
        (row) => cellsOf(row, form.separator).some((cell) => hasDecimalComma(cell) && isNumber(cell, true)));
    const thousands = this.rows.some(
        (row) => cellsOf(row, form.separator).some((cell) => cell.includes('.') && kCommaGroups.test(cell)));
    if (form.decimalComma && thousands)
      throw new UnreadableCloud('commas stand between thousands and seem to be decimal commas elsewhere');
    form.guessed ||= form.decimalComma || thousands;
    this.checkCommas();
  }

  private separatorOfHeader(): string {
    const text = withoutUnits(this.header ?? '');
    return kSeparators.find((separator) => meaningOf(cellsOf(text, separator)).hasPosition) ?? ' ';
  }

  private guessedSeparator(): string {
    const good = kSeparators.find((separator) => {
      const bad =
          this.rows
              .filter(
                  (row) => !isEmptyRow(row, separator) && countValues(cellsOf(row, separator), separator !== ',') < 3)
              .length;
      return 10 * bad <= this.rows.length;
    });
    return good ?? ['\t', ';', '|', ','].find((separator) => this.firstRow().includes(separator)) ?? ' ';
  }

  private checkCommas(): void {
    const {form} = this;
    if (form.separator !== ',' || form.decimalComma || this.roles || this.options.separator ||
        this.rows.some((row) => row.includes('"')))
      return;
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
        const cells = cellsOf(this.firstRow(), this.form.separator);
        values.forEach((column, c) => {
          column.numeric = isNumber(cells[c], this.form.decimalComma);
        });
        this.form.roles = rolesByValues(values);
      }
      if (!this.form.roles.includes('x')) throw new UnreadableCloud('no three of the columns hold numbers throughout');
      this.checkPassedOver(columns);
      this.form.guessed ||= columns > 3;
    }
  }

  /** A separator at its end is one more, where the header has a name for it. */
  private columnsOfFirstRow(): number {
    const {separator} = this.form;
    const columns = cellsOf(this.firstRow(), separator).length;
    const open = separator !== ' ' && this.firstRow().endsWith(separator);
    return open && this.header !== undefined && cellsOf(this.header, separator).length === columns + 1 ? columns + 1 :
                                                                                                         columns;
  }

  private takeNamed(roles: Role[], columns: number): void {
    if (this.rows.length > 0 && columns < roles.length) {
      throw new UnreadableCloud(
          `columns=${roles.join(',')} names ${roles.length} columns; the first row has ${columns}`);
    }
    this.form.guessed = false;
    this.form.roles = [...roles, ...Array<Role>(Math.max(0, columns - roles.length)).fill('-')];
  }

  private takeHeaderRoles(header: string, columns: number): void {
    const text = withoutUnits(header);
    const read = [...new Set([this.form.separator, ...kSeparators])]
                     .map((separator) => meaningOf(cellsOf(text, separator)))
                     .filter((meaning) => meaning.hasPosition || meaning.degrees);
    const best = read.find((meaning) => meaning.roles.length === columns) ?? read[0];
    if (best.degrees)
      throw new UnreadableCloud('the columns are longitude and latitude, which are angles and no lengths');
    let {roles} = best;
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
      const placed = (['x', 'y', 'z'] as Role[]).every((role) => roles.slice(0, known).includes(role));
      if (!placed || known > columns)
        throw new UnreadableCloud(`the header names ${roles.length} columns, the first row has ${columns}`);
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
    const values: ColumnValues[] = Array.from({length: columns}, () => ({values: [], numeric: true}));
    for (const row of this.rows) {
      if (isEmptyRow(row, this.form.separator)) continue;
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
