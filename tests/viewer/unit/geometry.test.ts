// SPDX-License-Identifier: GPL-3.0-or-later
// The measuring parts of the viewer.
import assert from 'node:assert/strict';
import {test} from 'node:test';

import {distancesOfTriangles, encloses, toSurface, treeOf} from '../../../server/web/src/geometry/compare';
import {edgesOf} from '../../../server/web/src/geometry/edges';

import type {MeshData} from '../../../server/web/src/geometry/mesh_data';
import {NearestPoints} from '../../../server/web/src/geometry/nearest';
import {shapeOf, shapesOf, worstOf} from '../../../server/web/src/geometry/quality';
import {simplified} from '../../../server/web/src/geometry/simplify';

function random(seed: number): () => number {
  let state = seed;
  return () => ((state = (Math.imul(state, 1103515245) + 12345) & 0x7fffffff) >>> 8) / 2 ** 23;
}

const tetrahedron: MeshData = {
  positions: Float32Array.from([1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1]),
  index: Uint32Array.from([0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2]),
  origin: [0, 0, 0],
};

function sphere(rows: number): MeshData {
  const positions: number[] = [];
  const index: number[] = [];
  for (let i = 0; i <= rows; i += 1) {
    for (let j = 0; j < 2 * rows; j += 1) {
      const [a, b] = [(Math.PI * i) / rows, (Math.PI * j) / rows];
      positions.push(Math.sin(a) * Math.cos(b), Math.cos(a), Math.sin(a) * Math.sin(b));
      const [u, v] = [i * 2 * rows + j, i * 2 * rows + ((j + 1) % (2 * rows))];
      if (i < rows) index.push(u, v, u + 2 * rows, v, v + 2 * rows, u + 2 * rows);
    }
  }
  return {positions: Float32Array.from(positions), index: Uint32Array.from(index), origin: [0, 0, 0]};
}

test('an equilateral triangle has the largest ratios, a needle almost none, a line none', () => {
  const best = shapeOf(1, 1, 1);
  assert.ok(
      Math.abs(best.lR - Math.sqrt(3)) < 1e-12 && Math.abs(best.rL - Math.sqrt(3) / 6) < 1e-12 &&
      Math.abs(best.angle - 60) < 1e-9);
  const right = shapeOf(9, 16, 25);
  assert.ok(
      Math.abs(right.lR - 3 / 2.5) < 1e-12 && Math.abs(right.rL - 1 / 5) < 1e-12 &&
      Math.abs(right.angle - 36.8698976) < 1e-6);
  assert.deepEqual(shapeOf(1, 1, 4), {lR: 0, rL: 0, angle: 0});
  assert.ok(shapeOf(1e-6, 1, 1).angle < 0.06);
});

test('the worst triangles come first, as many as asked for', () => {
  assert.deepEqual(worstOf(Float32Array.from([0.5, 0.1, 0.9, 0.1, 0.3]), 3), [1, 3, 4]);
  assert.deepEqual(worstOf(Float32Array.from([2]), 3), [0]);
  assert.equal(shapesOf(tetrahedron).lR.every((value) => Math.abs(value - Math.sqrt(3)) < 1e-6), true);
});

test('edges are told by how many triangles they have', () => {
  const closed = edgesOf(tetrahedron);
  assert.deepEqual([closed.all.length, closed.boundary.length, closed.nonManifold.length], [12, 0, 0]);
  const open = edgesOf({...tetrahedron, index: tetrahedron.index.slice(3)});
  assert.equal(open.boundary.length, 6);
  const fan = edgesOf({...tetrahedron, index: Uint32Array.from([0, 1, 2, 0, 3, 1, 0, 1, 2])});
  assert.deepEqual([...fan.nonManifold], [0, 1]);
});

test('the nearest point is that of a search through all', () => {
  const next = random(7);
  const points = Float32Array.from({length: 3 * 500}, () => Math.round(20 * next()) / 20);
  const tree = new NearestPoints(points);
  for (let q = 0; q < 200; q += 1) {
    const [x, y, z] = [next() * 1.4 - 0.2, next() * 1.4 - 0.2, next() * 1.4 - 0.2];
    let least = Infinity;
    for (let i = 0; i < points.length; i += 3)
      least = Math.min(least, Math.hypot(points[i] - x, points[i + 1] - y, points[i + 2] - z));
    assert.ok(Math.abs(tree.distance(x, y, z) - least) < 1e-12);
  }
  assert.equal(new NearestPoints(new Float32Array()).distance(0, 0, 0), Infinity);
});

test('the coarse stand-in has about as few triangles as asked for, and keeps the extent', () => {
  const fine = sphere(200);
  const coarse = simplified(fine, 5000);
  assert.ok(coarse.length / 3 <= 5000 && coarse.length / 3 > 1200, `${coarse.length / 3}`);
  const reach = [...coarse].reduce((most, v) => Math.max(most, fine.positions[3 * v]), 0);
  assert.ok(reach > 0.95);
});

test('distances of triangles see what corners do not: a lid over points that both meshes share', () => {
  const box = (index: number[]): MeshData => ({
    positions: Float32Array.from([0, 0, 0, 4, 0, 0, 4, 4, 0, 0, 4, 0, 2, 2, -3]),
    index: Uint32Array.from(index),
    origin: [0, 0, 0]
  });
  const cup = box([0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0]);
  const lid = box([0, 1, 2, 0, 2, 3]);
  const values = distancesOfTriangles(lid, [0, 0, 0], toSurface(treeOf(cup)));
  assert.ok(values.every((value) => value > 1.2), String(values));
  assert.ok(distancesOfTriangles(lid, [0, 0, 1], toSurface(treeOf(lid))).every((value) => Math.abs(value - 1) < 1e-6));
});

test('distances to a surface and insides are those of the sphere', () => {
  const tree = treeOf(sphere(60));
  const distance = toSurface(tree);
  assert.ok(
      Math.abs(distance(2, 0, 0) - 1) < 2e-3 && Math.abs(distance(0, 0, 0) - 1) < 2e-3 && distance(0, 1, 0) < 1e-6);
  assert.ok(encloses(tree, 0.3, 0.2, -0.5));
  assert.ok(!encloses(tree, 0.9, 0.9, 0));
});
