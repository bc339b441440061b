// SPDX-License-Identifier: GPL-3.0-or-later
// The report of a reconstruction in sentences.
import type {Report} from '../api/types';
import {bytes, count, countOf, real, seconds} from './numbers';

/** good: as one hopes; fair: worth knowing; poor: something a user will stumble over. */
export interface Sentence {
  mood: 'good'|'fair'|'poor';
  text: string;
}

const good = (text: string): Sentence => ({mood: 'good', text});
const fair = (text: string): Sentence => ({mood: 'fair', text});
const poor = (text: string): Sentence => ({mood: 'poor', text});

function closedness({mesh}: Report): Sentence {
  if (mesh.closed && mesh.edge_manifold && mesh.vertex_manifold)
    return good('Watertight: every edge has exactly two triangles, and every vertex one umbrella of them.');
  if (mesh.closed)
    return fair('Closed: every edge has exactly two triangles, but some vertices have more than one umbrella of them.');
  if (mesh.boundary_edges > 0) {
    return fair(`Not watertight: ${countOf(mesh.boundary_loops, 'opening')} with ${
        countOf(mesh.boundary_edges, 'border edge')}, drawn in pink.`);
  }
  return poor('Not watertight.');
}

function manifoldness({mesh}: Report): Sentence[] {
  const sentences: Sentence[] = [];
  if (mesh.non_manifold_edges > 0)
    sentences.push(
        poor(`${countOf(mesh.non_manifold_edges, 'edge has', 'edges have')} more than two triangles, drawn in green.`));
  if (mesh.non_manifold_vertices > 0) {
    sentences.push(poor(
        `${countOf(mesh.non_manifold_vertices, 'vertex has', 'vertices have')} more than one umbrella of triangles.`));
  }
  if (!mesh.oriented) sentences.push(poor('The triangles do not all face the same way.'));
  return sentences;
}

function shape({mesh}: Report): Sentence {
  const parts = mesh.components === 1 ? 'One piece' : countOf(mesh.components, 'piece');
  if (mesh.genus === null) return fair(`${parts}; a genus has no meaning here.`);
  const handles = mesh.genus === 0 ? 'no handles' : countOf(mesh.genus, 'handle');
  return good(
      `${parts} of genus ${mesh.genus}: ${handles}${mesh.closed ? '' : ', with its openings taken as filled'}.`);
}

function points({cloud, quality, mesh}: Report): Sentence[] {
  if (!cloud || quality.unused_points === null)
    return [fair('The vertices are new points: this method approximates the cloud.')];
  const sentences: Sentence[] = [];
  const doubles = cloud.points - cloud.distinct_points;
  if (doubles > 0) sentences.push(fair(`${countOf(doubles, 'point')} of ${count(cloud.points)} occur more than once.`));
  if (quality.unused_points === 0)
    return [good(`Every one of the ${count(cloud.distinct_points)} distinct points is a vertex.`), ...sentences];
  const share = ((100 * quality.unused_points) / cloud.distinct_points).toPrecision(2);
  const inside = quality.interior_vertices === null ?
      '' :
      quality.interior_vertices === 0 ?
      '; none of them lies inside' :
      `; ${count(quality.interior_vertices)} of them ${quality.interior_vertices === 1 ? 'lies' : 'lie'} inside`;
  const what = `${countOf(quality.unused_points, 'point is', 'points are')} no vertex (${share} %)${
      mesh.closed ? inside : ''}; marked.`;
  return [fair(what), ...sentences];
}

function triangles({quality}: Report): Sentence[] {
  const sentences: Sentence[] = [];
  const lR = quality.shortest_edge_to_circumradius;
  if (lR)
    sentences.push(fair(`Half of the triangles have l/R above ${
        real(lR.p50)}; an equilateral one has 1.732. The worst has ${real(lR.min)}.`));
  if (quality.degenerate_triangles > 0)
    sentences.push(poor(`${countOf(quality.degenerate_triangles, 'triangle has', 'triangles have')} no area.`));
  if (quality.self_intersections)
    sentences.push(poor(`${countOf(quality.self_intersections, 'pair')} of triangles cross each other.`));
  return sentences;
}

function certificate({certificate: found}: Report): Sentence[] {
  if (!found) return [];
  const bounds = found.bounds_met === null ? 'of its triangles the theorem says nothing' :
      found.bounds_met                     ? 'every triangle keeps the bounds of the theorem' :
                                             'some triangles break the bounds of the theorem';
  if (found.premises_met === false) {
    const open = Object.entries(found.premises)
                     .filter(([, premise]) => premise.met === false)
                     .map(([name]) => name.replaceAll('_', ' '));
    return [fair(`The certificate gives no guarantee here: ${open.join(', ')} ${
        open.length === 1 ? 'is' : 'are'} not met (ε ${real(found.epsilon)}); ${bounds}.`)];
  }
  const what = `The certificate of the sampling theorem holds for ε ${real(found.epsilon)}: the surface is within ${
      real(found.hausdorff_bound)} of the mesh; ${bounds}.`;
  return [found.bounds_met ? good(what) : poor(what)];
}

function cost({resources, encoding}: Report): Sentence[] {
  const sentences: Sentence[] = [];
  if (resources) {
    sentences.push(good(`Made in ${seconds(resources.wall_seconds)} on ${
        countOf(resources.threads, 'thread')}, with at most ${bytes(resources.peak_rss_bytes)} of memory.`));
  }
  if (encoding && encoding.merged_vertices > 0)
    sentences.push(fair(`Writing float32 merged ${countOf(encoding.merged_vertices, 'vertex', 'vertices')}.`));
  return sentences;
}

export function reportWords(report: Report): Sentence[] {
  return [
    closedness(report), ...manifoldness(report), shape(report), ...points(report), ...triangles(report),
    ...certificate(report), ...cost(report), ...report.warnings.map((warning) => fair(warning))
  ];
}
