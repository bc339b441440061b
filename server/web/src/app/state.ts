// SPDX-License-Identifier: GPL-3.0-or-later
// What the page knows. One object, changed by Session alone; whoever shows something of it is told of every change.
import type {ApiError} from '../api/client';
import type {Cloud, Job, Method, Report, Sample} from '../api/types';
import type {TableOptions} from '../clouds/table';
import type {Difference, LoadedCloud, LoadedMesh, UnusedPoints} from '../worker/protocol';
import type {Clip} from '../view/stage';
import type {Look} from '../view/layers';

export interface ChosenCloud {
  name: string;
  size: number;
  /** None if only the server has it: the page was opened by a link. */
  file?: File|undefined;
  data?: LoadedCloud|undefined;
  /** Why the points are not shown. */
  noPreview?: string|undefined;
  /** Once the server has stored it. */
  id?: string|undefined;
  /** What the server says of it, where this page cannot read it. */
  stored?: Cloud|undefined;
  /** It was cropped out of this one. */
  whole?: ChosenCloud|undefined;
}

/** A job whose mesh is shown. */
export interface Result {
  job: Job;
  report: Report;
  mesh: LoadedMesh;
  unused?: UnusedPoints|undefined;
  wireframe?: Uint32Array|undefined;
  distances?: Float32Array|undefined;
}

export interface Work {
  side: Side;
  what: 'upload'|'submit'|'queue'|'run'|'load';
  /** 0 to 1; none if nobody knows. */
  fraction?: number|undefined;
  detail: string;
  job?: Job|undefined;
  /** Stages that the job has been in, the present one last. */
  phases?: string[];
}

export type Side = 0|1;
/** The first line is of points and mesh, the second of the triangles. */
export type ColourBy = 'none'|'own'|'height'|'intensity'|'class'|'lR'|'rL'|'angle'|'distance'|'difference';

/** What the form of the method says, and the next job is going to be. */
export interface Run {
  method: string;
  /** Those that differ from their defaults. */
  parameters: Record<string, unknown>;
}

export interface State {
  methods: Method[];
  samples: Sample[];
  cloud?: ChosenCloud|undefined;
  /** Several files that came at once, until it is said what becomes of them. */
  dropped: File[];
  run?: Run|undefined;
  /** How a text is to be read. */
  table: TableOptions;
  results: [Result|undefined, Result|undefined];
  difference?: Difference|undefined;
  /** Sides of the triangle of the first mesh that was asked for last. */
  pointed?: Float32Array|undefined;
  work?: Work|undefined;
  error?: ApiError|undefined;
  /** Said politely; nothing is wrong. */
  notice: string;
  history: Job[];
  needsKey: boolean;
  /** Nothing can be drawn. */
  blind: boolean;
  /** Counts the pictures of results that were kept. */
  pictures: number;
  look: Look;
  clip: Clip;
  colour: ColourBy;
  up: 'y'|'z';
  theme: 'light'|'dark';
}

export function initialState(): State {
  const dark = matchMedia('(prefers-color-scheme: dark)').matches;
  const theme = localStorage.getItem('surfaced.theme') ?? (dark ? 'dark' : 'light');
  return {
    methods: [],
    samples: [],
    dropped: [],
    table: {},
    results: [undefined, undefined],
    notice: '',
    history: [],
    needsKey: false,
    blind: false,
    pictures: 0,
    look: {points: true, surface: true, wireframe: false, smooth: false, marks: true, shade: true},
    clip: {axis: 'none', place: 0.5, flip: false},
    colour: 'none',
    up: 'y',
    theme: theme === 'dark' ? 'dark' : 'light',
  };
}
