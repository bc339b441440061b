// SPDX-License-Identifier: GPL-3.0-or-later
// The shapes of the API, from the contract.
import type {components} from '../../generated/contract';

type Schemas = components['schemas'];

export type Job = Omit<Schemas['job'], 'parameters'>&{parameters: Record<string, unknown>};
export type Cloud = Schemas['cloud'];
export type Report = Omit<Schemas['report'], 'parameters'>&{parameters?: Record<string, unknown>};
export type Distribution = Schemas['report']['$defs']['distribution'];
export type Problem = Schemas['problem'];
export type Submission = Omit<Schemas['submission'], 'parameters'>&{parameters?: Record<string, unknown>};
export type Method = Omit<Schemas['method'], 'parameters'>&{parameters: {properties: Record<string, ParameterSchema>}};

/** What of JSON Schema the parameters of methods use. */
export interface ParameterSchema {
  enum?: string[];
  type?: 'integer'|'number'|'boolean'|'string';
  const ?: unknown;
  oneOf?: ParameterSchema[];
  minimum?: number;
  maximum?: number;
  exclusiveMinimum?: number;
  default?: unknown;
  title?: string;
  description?: string;
  'x-unit'?: string;
}

export interface Sample {
  name: string;
  title: string;
  description: string;
  points: number;
  /** The one that suits it, if not the default. */
  method?: string;
}

export const isEnded = (job: Job): boolean => job.status !== 'accepted' && job.status !== 'running';
