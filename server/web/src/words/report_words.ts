// SPDX-License-Identifier: GPL-3.0-or-later
// The report of a reconstruction in sentences.
import type {Report} from '../api/types';
import {bytes, count, percent, real, seconds} from './numbers';
import {t} from './words';

/** good: as one hopes; fair: worth knowing; poor: something a user will stumble over. */
export interface Sentence {
  mood: 'good'|'fair'|'poor';
  text: string;
}

const good = (text: string): Sentence => ({mood: 'good', text});
const fair = (text: string): Sentence => ({mood: 'fair', text});
const poor = (text: string): Sentence => ({mood: 'poor', text});

const words = t.report;
/** More than this share of the points is no vertex: to mark each would hide the mesh. */
const kFew = 0.2;
/** More than this share: the vertices are no points of the cloud, but for chance. */
const kApproximates = 0.9;

function shareUnused({cloud, quality}: Report): number {
  if (!cloud || quality.unused_points === null) return 1;
  return quality.unused_points / cloud.distinct_points;
}

const approximates = (report: Report): boolean => shareUnused(report) >= kApproximates;

/** Whether the points that are no vertex are few, and worth a mark each. */
export const marksUnused = (report: Report): boolean => {
  const share = shareUnused(report);
  return share > 0 && share <= kFew;
};

function closedness({mesh}: Report): Sentence {
  if (mesh.closed && mesh.edge_manifold && mesh.vertex_manifold) return good(words.watertight);
  if (mesh.closed) return fair(words.closed);
  const {boundary_loops: loops, boundary_edges: edges} = mesh;
  return edges > 0 ? fair(words.open(loops, count(loops), edges, count(edges))) : poor(words.notWatertight);
}

function manifoldness({mesh}: Report): Sentence[] {
  const {non_manifold_edges: edges, non_manifold_vertices: vertices} = mesh;
  const sentences: Sentence[] = [];
  if (edges > 0) sentences.push(poor(words.nonManifoldEdges(edges, count(edges))));
  if (vertices > 0) sentences.push(poor(words.nonManifoldVertices(vertices, count(vertices))));
  if (!mesh.oriented) sentences.push(poor(words.notOriented));
  return sentences;
}

/** Several pieces are seldom what one hopes for. */
function shape({mesh}: Report): Sentence {
  const one = mesh.components === 1;
  const parts = one ? words.onePiece : words.pieces(count(mesh.components));
  if (mesh.genus === null) return fair(words.noGenus(parts));
  const handles = mesh.genus === 0 ? words.noHandles : words.handles(mesh.genus, count(mesh.genus));
  const text = (one ? words.genus : words.genusMany)(parts, mesh.genus, handles, !mesh.closed);
  return one ? good(text) : fair(text);
}

function points(report: Report): Sentence[] {
  const {cloud, quality, mesh} = report;
  if (!cloud || approximates(report)) return [fair(words.approximates)];
  const sentences: Sentence[] = [];
  const unused = quality.unused_points ?? 0;
  const doubles = cloud.points - cloud.distinct_points - (cloud.missing_points ?? 0);
  if (doubles > 0) sentences.push(fair(words.doubles(doubles, count(doubles), count(cloud.points))));
  if (unused === 0) return [good(words.allUsed(cloud.distinct_points, count(cloud.distinct_points))), ...sentences];
  const {interior_vertices: interior} = quality;
  const inside = mesh.closed && interior !== null ? words.inside(interior, count(interior)) : '';
  const marked = marksUnused(report) ? words.marked : '';
  const what = words.unused(unused, count(unused), percent(unused, cloud.distinct_points));
  return [fair(`${what}${inside}${marked}.`), ...sentences];
}

function triangles({quality}: Report): Sentence[] {
  const {shortest_edge_to_circumradius: lR, degenerate_triangles: degenerate, self_intersections: crossing} = quality;
  const sentences: Sentence[] = [];
  if (lR) sentences.push(fair(words.lR(real(lR.p50), real(lR.min))));
  if (degenerate > 0) sentences.push(poor(words.degenerate(degenerate, count(degenerate))));
  if (crossing) sentences.push(poor(words.crossing(crossing, count(crossing))));
  return sentences;
}

/** Where the certificate says null, nothing is promised. */
function certificate({certificate: found}: Report): Sentence[] {
  if (!found) return [];
  const {bounds_met: met, epsilon} = found;
  const bounds = met === null ? words.boundsNull : met ? words.boundsMet : words.boundsBroken;
  if (found.premises_met === false) {
    const broken = Object.entries(found.premises).filter(([, premise]) => premise.met === false);
    const why = broken.map(([name]) => words.premises[name] ?? name.replaceAll('_', ' ')).join(', ');
    return [fair(words.noGuarantee(why, real(epsilon), bounds))];
  }
  if (met === null) return [fair(words.nothingSaid(real(epsilon)))];
  const what = words.certified(real(epsilon), real(found.hausdorff_bound), bounds);
  return [met ? good(what) : poor(what)];
}

function cost({resources, encoding}: Report): Sentence[] {
  const sentences: Sentence[] = [];
  if (resources) {
    const {wall_seconds: time, threads, peak_rss_bytes: memory} = resources;
    sentences.push(good(words.made(seconds(time), threads, count(threads), bytes(memory))));
  }
  const merged = encoding?.merged_vertices ?? 0;
  if (merged > 0) sentences.push(fair(words.merged(merged, count(merged))));
  return sentences;
}

/** Warnings that say again what a sentence here says. */
const isTold = (warning: string, {mesh}: Report): boolean =>
    (!mesh.closed && warning.startsWith('the mesh is open')) || /^\d+ duplicate points? merged/.test(warning);

/** A warning for people: without the code that stands before it for programs. */
function warningText(warning: string): string {
  const text = warning.replace(/^[a-z]+(_[a-z]+)+: /, '');
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}${/[.!?]$/.test(text) ? '' : '.'}`;
}

export function reportWords(report: Report): Sentence[] {
  return [
    closedness(report),
    ...manifoldness(report),
    shape(report),
    ...points(report),
    ...triangles(report),
    ...certificate(report),
    ...cost(report),
    ...report.warnings.filter((warning) => !isTold(warning, report)).map((warning) => fair(warningText(warning))),
  ];
}
