// SPDX-License-Identifier: GPL-3.0-or-later
// What the columns of a table without names are, told by their values: the rules of core/io/table_values.cpp.
import {kRoles, type Role} from './table_names';

export interface ColumnValues {
  /** NaN where there is no number. */
  values: number[];
  numeric: boolean;
}

const kNormalSlack = 0.1;
const kLargestClass = 31;
const kMostReturns = 15;
const kFewestCounted = 3;
const kClearlyGreyer = 0.75;
const kFewestWithGaps = 16;

const isConstant = ({values}: ColumnValues): boolean => values.every((x) => x === values[0]);
const within = ({values}: ColumnValues, low: number, high: number): boolean =>
    values.every((x) => Number.isNaN(x) || (x >= low && x <= high));
const largest = ({values}: ColumnValues): number => values.reduce((most, x) => (x > most ? x : most), -Infinity);
const isNormal = (v: number[]): boolean => Math.abs(Math.hypot(...v) - 1) <= kNormalSlack;
const isColor = (v: number[]): boolean => v.every((x) => x >= 0 && x <= 255 && Number.isInteger(x));

const threeOf = (columns: ColumnValues[], first: number, row: number):
    number[] => [0, 1, 2].map((i) => columns[first + i].values[row]);

/** The triples of three columns, without those that were not measured. */
const triplesOf = (columns: ColumnValues[], first: number): number[][] =>
    columns[first].values.map((_, row) => threeOf(columns, first, row)).filter((v) => !v.every(Number.isNaN));

function allRows(columns: ColumnValues[], first: number, is: (v: number[]) => boolean): boolean {
  const triples = triplesOf(columns, first);
  return triples.length > 0 && triples.every(is);
}

/** Number of a return and number of returns. */
const areReturns = (number: ColumnValues, count: ColumnValues): boolean => within(number, 1, kMostReturns) &&
    within(count, 1, kMostReturns) && number.values.every((x, row) => !(x > count.values[row]));

/**
 * A column of few small numbers that come again beside such as have more of them, or fewer; or one that varies beside
 * two that stay.
 */
function hasClassBeside(three: ColumnValues[]): boolean {
  const distinct = three.map(({values}) => new Set(values.filter((x) => !Number.isNaN(x))).size);
  const isDark = (i: number): boolean => largest(three[i]) <= kLargestClass;
  const found = [0, 1, 2].some(
      (c) => isDark(c) && 2 * distinct[c] <= three[c].values.length + 2 && largest(three[c]) >= 1 &&
          [0, 1, 2].every((i) => isDark(i) || distinct[i] !== distinct[c]));
  return found || (distinct.filter((n) => n === 1).length === 2 && Math.max(...distinct) >= kFewestCounted);
}

function areClasses(columns: ColumnValues[], first: number): boolean {
  const three = columns.slice(first, first + 3);
  if (Math.max(...three.map(largest)) <= kLargestClass) return true;
  if (areReturns(three[0], three[1]) || areReturns(three[1], three[2])) return true;
  return three[0].values.length >= kFewestCounted && hasClassBeside(three);
}

/** How far the channels are from one another. */
const spread = (columns: ColumnValues[], first: number): number =>
    triplesOf(columns, first)
        .reduce((sum, v) => sum + (v.reduce((a, b) => (b > a ? b : a)) - v.reduce((a, b) => (b < a ? b : a))), 0);

export function countsUp({values, numeric}: ColumnValues): boolean {
  if (!numeric || values.length < kFewestCounted || !(values[0] >= 0) || !Number.isInteger(values[0])) return false;
  if (values.slice(1).some((x, i) => !(x > values[i]) || !Number.isInteger(x))) return false;
  const step = values.length < kFewestWithGaps ? 1 : 4;
  return values[values.length - 1] - values[0] <= step * (values.length - 1);
}

const hasFractions = ({values}: ColumnValues): boolean =>
    values.some((x) => Number.isFinite(x) && !Number.isInteger(x));
const areIdentifiers = ({values, numeric}: ColumnValues): boolean => numeric && values.length >= kFewestCounted &&
    values.every((x) => x >= 0 && Number.isInteger(x)) && new Set(values).size === values.length;

function take(roles: Role[], first: number, role: Role): void {
  for (let i = 0; i < 3; i += 1) roles[first + i] = kRoles[kRoles.indexOf(role) + i];
}

function takeGroups(columns: ColumnValues[], roles: Role[]): void {
  const isFree =
      (first: number): boolean => [0, 1, 2].every((i) => roles[first + i] === '-' && columns[first + i].numeric);
  const places = columns.map((_, c) => c).slice(0, Math.max(0, columns.length - 2));
  const normals = places.find((c) => isFree(c) && allRows(columns, c, isNormal));
  if (normals !== undefined) take(roles, normals, 'nx');
  const rank = (c: number): number =>
      (columns.slice(c, c + 3).every((column) => largest(column) > kLargestClass) ? 1 : 0);
  let best = -1;
  for (const c of places) {
    if (!isFree(c) || !allRows(columns, c, isColor) || areClasses(columns, c)) continue;
    const opaqueFollows = best >= 0 && best + 1 === c && isConstant(columns[c + 2]) && columns[c + 2].values[0] === 255;
    if (best >= 0 && (rank(c) < rank(best) || opaqueFollows)) continue;
    if (best >= 0 && rank(c) === rank(best) && spread(columns, best) < kClearlyGreyer * spread(columns, c)) continue;
    best = c;
  }
  if (best >= 0) take(roles, best, 'r');
}

export function rolesByValues(columns: ColumnValues[]): Role[] {
  const numbers = columns.map((_, c) => c).filter((c) => columns[c].numeric);
  const roles: Role[] = columns.map(() => '-');
  const numbered = numbers.length >= 4 && !isConstant(columns[numbers[1]]) &&
      (countsUp(columns[numbers[0]]) ||
       (areIdentifiers(columns[numbers[0]]) && numbers.slice(1, 4).every((c) => hasFractions(columns[c]))));
  if (numbered) numbers.shift();
  if (numbers.length < 3) return roles;
  const [first, second] = numbers;
  const northAndEast = within(columns[first], 1e6, 1e7) && within(columns[second], 1e5, 999_999);
  if (northAndEast) numbers.splice(0, 2, second, first);
  for (let i = 0; i < 3; i += 1) roles[numbers[i]] = kRoles[i];
  takeGroups(columns, roles);
  return roles;
}
