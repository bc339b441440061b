// SPDX-License-Identifier: GPL-3.0-or-later
// What the names in the header of a table mean: the rules of core/io/table_names.cpp.
export type Role = 'x'|'y'|'z'|'nx'|'ny'|'nz'|'r'|'g'|'b'|'-';

export const kRoles: Role[] = ['x', 'y', 'z', 'nx', 'ny', 'nz', 'r', 'g', 'b'];

const words = (text: string): Set<string> => new Set(['', ...text.split(' ')]);

const kAxisWords = words(
    'pos position positions coord coords coordinate coordinates koordinate koord point points pt p loc location cartesian utm world ' +
    'local m mm cm ft km meter meters metre metres center centre vertex global xyz');
const kNormalWords = new Set('n normal normals norm'.split(' '));
const kColorWords = words('color colour col rgb f diffuse color8 scan');
const kEast =
    new Set('easting eastings east rechtswert rechts ostwert ost este est xeast xeasting eastx eastingx me'.split(' '));
const kNorth = new Set(
    'northing northings north hochwert hoch nordwert nord norte ynorth ynorthing northy northingy mn'.split(' '));
const kUp = new Set(
    'height elevation elev ele altitude alt hoehe höhe h\ufffdhe level rl cota quota zheight heightz zelev zelevation h up'
        .split(' '));
/** What has an x, y and z too, and is no place. */
const kOtherVectors = new Set(
    ('n normal normals norm v vel velocity a acc accel acceleration f force s std sigma sd err error rot rotation angle euler q quat gyro mag scale ' +
     'size dir direction t tangent orientation angular linear')
        .split(' '));
/** What such a name may begin with. */
const kWhose = 'ortho orthometric ellipsoidal ellipsoid ell grid local ground geoid project point utm'.split(' ');
const kLongitude = new Set('lon long lng longitude londeg'.split(' '));
const kLatitude = new Set('lat latitude latdeg'.split(' '));

export interface HeaderMeaning {
  names: string[];
  roles: Role[];
  hasPosition: boolean;
  degrees: boolean;
  synonyms: boolean;
}

const lower = (text: string): string => text.replace(/[A-Z]/g, (letter) => letter.toLowerCase());
const plain = (name: string): string => lower(name).replace(/[^a-z0-9\u0080-\uffff]/g, '');

function isAxis(name: string, among: Set<string>, letter: string, number: string): boolean {
  if (name.startsWith(letter) && among.has(name.slice(letter.length))) return true;
  if (name.endsWith(letter) && among.has(name.slice(0, name.length - letter.length))) return true;
  const stem = name.slice(0, -1);
  return name.length > 1 && name.endsWith(number) && (among.has(stem) || (stem.endsWith('xyz') && among.has('xyz')));
}

const isWord = (among: Set<string>, name: string):
    boolean => ['', 'm', 'ft', 'meters', 'metres', 'coord', 'coordinate', 'koordinate'].some(
                   (more) => name.endsWith(more) && among.has(name.slice(0, name.length - more.length))) ||
    kWhose.some((whose) => name.startsWith(whose) && among.has(name.slice(whose.length)));

/** Whether what stands before the letter of an axis says that the three are no place. */
const isOtherVector = (before: string): boolean =>
    kOtherVectors.has(before) || [...kOtherVectors].some((word) => word.length >= 4 && before.endsWith(word));

function takeGroup(names: string[], among: Set<string>, letters: string[], first: Role, meaning: HeaderMeaning): void {
  const columns = letters.map((letter, i) => names.findIndex((name) => isAxis(name, among, letter, String(i))));
  if (columns.some((column) => column < 0 || meaning.roles[column] !== '-')) return;
  columns.forEach((column, i) => {
    meaning.roles[column] = kRoles[kRoles.indexOf(first) + i];
  });
}

function findCompass(names: string[], among: Set<string>, letter: string, other: string): number {
  const found = names.findIndex((name) => isWord(among, name));
  if (found >= 0) return found;
  return names.findIndex(
      (name) =>
          name.endsWith(letter) && kAxisWords.has(name.slice(0, -1)) && names.includes(name.slice(0, -1) + other));
}

/**
 * Three names that differ in the letter of an axis alone, or X1, X2, X3 with nothing beside them. None if there are
 * several such.
 */
function findAlike(names: string[]): number[]|undefined {
  const found = names.flatMap((name, c) => [...name].flatMap((letter, i) => {
    const numbered = names.length === 3 && i > 0 && letter === '1';
    if ((letter !== 'x' && !numbered) || isOtherVector(name.slice(0, i))) return [];
    const others = (numbered ? ['2', '3'] : [
                     'y', 'z'
                   ]).map((other) => names.indexOf(name.slice(0, i) + other + name.slice(i + 1)));
    return others.every((column) => column >= 0) ? [[c, ...others]] : [];
  }));
  return found.length === 1 ? found[0] : undefined;
}

function takePosition(names: string[], meaning: HeaderMeaning): void {
  const own =
      ['x', 'y', 'z'].map((letter, i) => names.findIndex((name) => isAxis(name, kAxisWords, letter, String(i))));
  const letters = own[0] >= 0 && own[1] >= 0;
  const up = own[2] >= 0 ? own[2] : names.findIndex((name) => isWord(kUp, name));
  const words = [
    letters ? own[0] : findCompass(names, kEast, 'e', 'n'), letters ? own[1] : findCompass(names, kNorth, 'n', 'e'), up
  ];
  const taken = words.every((column) => column >= 0) ? words : (findAlike(names) ?? words);
  if (taken.every((column) => column >= 0)) {
    taken.forEach((column, i) => {
      meaning.roles[column] = kRoles[i];
    });
    meaning.hasPosition = true;
    meaning.synonyms = !letters || own[2] < 0;
    return;
  }
  // GPSLatitude, decimalLongitude and the like.
  const has = (among: Set<string>): boolean =>
      names.some((name) => among.has(name) || [...among].some((word) => word.length > 7 && name.includes(word)));
  meaning.degrees = has(kLongitude) && has(kLatitude);
}

export function meaningOf(cells: string[]): HeaderMeaning {
  const names = cells.map(plain);
  const meaning:
      HeaderMeaning = {names, roles: names.map(() => '-'), hasPosition: false, degrees: false, synonyms: false};
  takePosition(names, meaning);
  takeGroup(names, kNormalWords, ['x', 'y', 'z'], 'nx', meaning);
  takeGroup(names, kColorWords, ['r', 'g', 'b'], 'r', meaning);
  if (!meaning.roles.includes('r')) takeGroup(names, kColorWords, ['red', 'green', 'blue'], 'r', meaning);
  return meaning;
}

/** Without units in brackets; an index such as `[0]` stays. */
export const withoutUnits = (line: string): string => line.replace(/\[(?![0-9]\])[^\]]{0,11}\]|\([^)]{0,11}\)/g, '');

/** Roles from `x,y,z,-,r,g,b`; none if the list is wrong. */
export function rolesNamed(list: string): Role[]|undefined {
  const roles = list.split(',') as Role[];
  if (roles.some((role) => role !== '-' && (!kRoles.includes(role) || roles.indexOf(role) !== roles.lastIndexOf(role))))
    return undefined;
  const count = (group: Role[]): number => group.filter((role) => roles.includes(role)).length;
  const whole = count(['x', 'y', 'z']) === 3 && count(['nx', 'ny', 'nz']) % 3 === 0 && count(['r', 'g', 'b']) % 3 === 0;
  return whole ? roles : undefined;
}
