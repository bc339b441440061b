// SPDX-License-Identifier: GPL-3.0-or-later
// Words, numbers, commands, streams.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import path from 'node:path';
import {test} from 'node:test';

import {EventCutter} from '../../../server/web/src/api/follow';

import type {Report} from '../../../server/web/src/api/types';
import {shares} from '../../../server/web/src/ui/histogram';
import {coloursOf, scales} from '../../../server/web/src/view/colormap';
import {curlLine} from '../../../server/web/src/words/curl';
import {bytes, real, seconds} from '../../../server/web/src/words/numbers';
import {reportWords} from '../../../server/web/src/words/report_words';

const example = (name: string): Report =>
    JSON.parse(readFileSync(path.join(process.env.SURFACED_SOURCE ?? '.', 'proto/examples', name), 'utf8')) as Report;
const text = (report: Report): string =>
    reportWords(report).map((sentence) => `${sentence.mood}: ${sentence.text}`).join('\n');

test('the report of a closed mesh says watertight, its genus, its points and its certificate', () => {
  const words = text(example('report-intrinsic-delaunay.json'));
  assert.match(words, /good: Watertight/);
  assert.match(words, /One piece of genus 0: no handles/);
  assert.match(words, /Every one of the 642 distinct points is a vertex/);
  assert.match(words, /certificate of the sampling theorem holds for ε 0\.09506/);
});

test('where the theorem says nothing of the triangles, no bound is said to be kept', () => {
  const report = structuredClone(example('report-intrinsic-delaunay.json'));
  const certificate = report.certificate!;
  certificate.premises.epsilon_within_curvature.met = false;
  Object.assign(
      certificate, {premises_met: false, bounds_met: null, bounds_say_nothing_because: 'epsilon is 4.61 / kappa'});
  const words = text(report);
  assert.match(
      words,
      /fair: The certificate gives no guarantee here: the sampling is too coarse for the curvature .*; of its triangles the theorem says nothing/);
  assert.doesNotMatch(words, /keeps the bounds/);
});

test('openings, unused points, crossings and warnings are said with their numbers', () => {
  const report = structuredClone(example('report-advancing-front.json'));
  Object.assign(report.mesh, {closed: false, boundary_loops: 2, boundary_edges: 31, non_manifold_edges: 1, genus: 1});
  Object.assign(
      report.quality, {unused_points: 12, interior_vertices: null, self_intersections: 3, degenerate_triangles: 1});
  report.cloud = {...report.cloud!, points: 110, distinct_points: 100};
  report.warnings = ['something to know'];
  const words = text(report);
  for (const pattern
           of [/fair: Not watertight: 2 openings with 31 border edges/, /poor: 1 edge has more than two triangles/,
               /12 points are no vertex \(12 %\)/, /10 points of 110 occur/, /poor: 3 pairs of triangles cross\./,
               /poor: 1 triangle has no area/, /fair: Something to know/, /with its openings taken as filled/])
    assert.match(words, pattern);
});

test('numbers keep four digits, sizes and times their units', () => {
  assert.deepEqual(
      [real(1.23456), real(0), real(1234567), real(0.00012), real(97)], ['1.235', '0', '1.23e+6', '1.20e-4', '97']);
  assert.deepEqual([bytes(512), bytes(1536), bytes(5 << 20)], ['512 B', '1.5 KiB', '5.0 MiB']);
  assert.deepEqual([seconds(0.0123), seconds(12.34), seconds(75)], ['12 ms', '12.3 s', '1 min 15 s']);
});

test('the curl line quotes what a shell would take apart, and never shows the key', () => {
  const line = curlLine('http://h/', 'it\'s.ply', 'local-delaunay', {max_edge: 3}, true);
  assert.equal(
      line,
      `curl --fail -sS -H "Authorization: Bearer $SURFACED_KEY" --data-binary '@it'\\''s.ply' -o 'it'\\''s.glb' 'http://h/v1/reconstruct?method=local-delaunay&max_edge=3&output=glb'`);
});

test('events are cut out of a stream wherever it breaks', () => {
  const stream =
      'event: state\nid: 1.0.running\ndata: {"a":1}\n\n: comment\n\nevent: done\r\nid: 2\r\ndata: x\r\ndata: y\r\n\r\n';
  for (let at = 0; at < stream.length; at += 1) {
    const cutter = new EventCutter();
    const events = [...cutter.push(stream.slice(0, at)), ...cutter.push(stream.slice(at))];
    assert.deepEqual(
        events, [{event: 'state', id: '1.0.running', data: '{"a":1}'}, {event: 'done', id: '2', data: 'x\ny'}],
        `broken at ${at}`);
  }
});

test('the colour scales rise in lightness or fall, and hold their ends', () => {
  const light = ([r, g, b]: number[]): number => 0.2126 * r ** 2.2 + 0.7152 * g ** 2.2 + 0.0722 * b ** 2.2;
  for (const [name, sign] of [['quality', 1], ['distance', -1]] as const) {
    for (let i = 1; i <= 32; i += 1)
      assert.ok(sign * (light(scales[name](i / 32)) - light(scales[name]((i - 1) / 32))) > -1e-3, `${name} ${i}`);
  }
  const colours = coloursOf(Float32Array.from([0, 1, 9]), 1, 'quality');
  assert.deepEqual([...colours.subarray(3, 6)], [...colours.subarray(6, 9)], 'beyond the end it stays');
  assert.deepEqual(shares([1, 3]), [0.25, 0.75]);
  assert.deepEqual(shares([0, 0]), [0, 0]);
});
