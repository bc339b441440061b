// SPDX-License-Identifier: GPL-3.0-or-later
// What the columns of a table without names are, told by their values: the rules of core/io/table_values.cpp.
import { kRoles, type Role } from './table_names';

export interface ColumnValues {
  /** NaN where there is no number. */
  values: number[];
  numeric: boolean;
}

const kNormalSlack = 0.1;
const kLargestClass = 31;
const kMostReturns = 15;
const kFewestWithGaps = 16;

const isConstant = ({ values }: ColumnValues): boolean => values.every((x) => x === values[0]);
const within = ({ values }: ColumnValues, low: number, high: number): boolean => values.every((x) => Number.isNaN(x) || (x >= low && x <= high));
const largest = ({ values }: ColumnValues): number => values.reduce((most, x) => (x > most ? x : most), -Infinity);
const isNormal = (v: number[]): boolean => Math.abs(Math.hypot(...v) - 1) <= kNormalSlack;
const isColor = (v: number[]): boolean => v.every((x) => x >= 0 && x <= 255 && Number.isInteger(x));

function allRows(columns: ColumnValues[], first: number, is: (v: number[]) => boolean): boolean {
  return columns[first].values.every((_, row) => is([0, 1, 2].map((i) => columns[first + i].values[row])));
}

function areClasses(columns: ColumnValues[], first: number): boolean {
  if (Math.max(...[0, 1, 2].map((i) => largest(columns[first + i]))) <= kLargestClass) return true;
  const returns = (number: number): boolean => within(columns[number], 1, kMostReturns) && within(columns[number + 1], 1, kMostReturns) &&
    columns[number].values.every((x, row) => !(x > columns[number + 1].values[row]));
  return returns(first) || returns(first + 1);
}

export function countsUp({ values, numeric }: ColumnValues): boolean {
  if (!numeric || values.length < 3 || !(values[0] >= 0) || !Number.isInteger(values[0])) return false;
  if (values.slice(1).some((x, i) => !(x > values[i]) || !Number.isInteger(x))) return false;
  const step = values.length < kFewestWithGaps ? 1 : 4;
  return values[values.length - 1] - values[0] <= step * (values.length - 1);
}

const hasFractions = ({ values }: ColumnValues): boolean => values.some((x) => Number.isFinite(x) && !Number.isInteger(x));
const areIdentifiers = ({ values, numeric }: ColumnValues): boolean =>
  numeric && values.length >= 3 && values.every((x) => x >= 0 && Number.isInteger(x)) && new Set(values).size === values.length;

function take(roles: Role[], first: number, role: Role): void {
  for (let i = 0; i < 3; i += 1) roles[first + i] = kRoles[kRoles.indexOf(role) + i];
}

function takeGroups(columns: ColumnValues[], roles: Role[]): void {
  const isFree = (first: number): boolean => [0, 1, 2].every((i) => roles[first + i] === '-' && columns[first + i].numeric);
  const places = columns.map((_, c) => c).slice(0, Math.max(0, columns.length - 2));
  const normals = places.find((c) => isFree(c) && allRows(columns, c, isNormal));
  if (normals !== undefined) take(roles, normals, 'nx');
  const rank = (c: number): number => (largest(columns[c]) > kLargestClass ? 1 : 0);
  let best = -2;
  let bestRank = -1;
  for (const c of places) {
    if (!isFree(c) || !allRows(columns, c, isColor) || areClasses(columns, c)) continue;
    const here = Math.min(rank(c), rank(c + 1), rank(c + 2));
    const opaqueFollows = best + 1 === c && isConstant(columns[c + 2]) && columns[c + 2].values[0] === 255;
    if (here < bestRank || opaqueFollows) continue;
    best = c;
    bestRank = here;
  }
  if (best >= 0) take(roles, best, 'r');
}

export function rolesByValues(columns: ColumnValues[]): Role[] {
  const numbers = columns.map((_, c) => c).filter((c) => columns[c].numeric);
  const roles: Role[] = columns.map(() => '-');
  const numbered = numbers.length >= 4 && !isConstant(columns[numbers[1]]) &&
    (countsUp(columns[numbers[0]]) || (areIdentifiers(columns[numbers[0]]) && numbers.slice(1, 4).every((c) => hasFractions(columns[c]))));
  if (numbered) numbers.shift();
  if (numbers.length < 3) return roles;
  const [first, second] = numbers;
  const northAndEast = within(columns[first], 1e6, 1e7) && within(columns[second], 1e5, 999_999);
  if (northAndEast) numbers.splice(0, 2, second, first);
  for (let i = 0; i < 3; i += 1) roles[numbers[i]] = kRoles[i];
  takeGroups(columns, roles);
  return roles;
}
