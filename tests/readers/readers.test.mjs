// SPDX-License-Identifier: GPL-3.0-or-later
// What readers of other people make of the meshes that `surfaced reconstruct` writes.
import assert from 'node:assert/strict';
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { before, describe, test } from 'node:test';
import { Vector3 } from 'three';
import { asSet, open3mfWithPython, openObjWithThree, openPlyWithThree, openPackedWithDraco, openStlWithThree, openWithDraco, openWithThree, plyOf, reconstruct, sphere, takeApart, validate } from './support.mjs';

const float32 = (points) => Float32Array.from(points.flat());

const clouds = [
  { name: 'bare points', points: sphere(500), options: {}, indexBytes: 2 },
  { name: 'points with normals and colours', points: sphere(800), options: { painted: true }, indexBytes: 2 },
  { name: 'more vertices than 16-bit indices reach', points: sphere(70000), options: {}, indexBytes: 4 },
];

for (const { name, points, options, indexBytes } of clouds) {
  describe(name, () => {
    const files = {};
    before(() => {
      const cloud = plyOf(points, options);
      for (const extension of ['glb', 'gltf', 'drc', 'ply', 'obj', 'stl']) files[extension] = reconstruct(cloud, extension);
      files['3mf'] = reconstruct(cloud, '3mf', ['--param', 'unit=in']);
    });

    for (const extension of ['glb', 'gltf']) {
      test(`${extension} passes the validator without errors and warnings`, async () => {
        const { issues, info } = await validate(files[extension].bytes);
        assert.deepEqual(issues.messages.filter(({ severity }) => severity <= 1), []);
        assert.equal(info.totalTriangleCount, files[extension].report.mesh.triangles);
        assert.equal(info.totalVertexCount, files[extension].report.mesh.vertices);
      });

      test(`three.js opens the ${extension} with every point bit for bit`, async () => {
        const mesh = await openWithThree(files[extension].bytes);
        assert.deepEqual(asSet(mesh.positions), asSet(float32(points)));
        assert.equal(mesh.indices.length, 3 * files[extension].report.mesh.triangles);
        assert.equal(mesh.node.geometry.getIndex().array.BYTES_PER_ELEMENT, indexBytes);
        assert.match(mesh.asset.generator, /^surfaced \d+\.\d+/);
        assert.equal(mesh.asset.extras.mesh.triangles, files[extension].report.mesh.triangles);
        assert.equal(mesh.node.material.side, 2, 'double-sided');
      });
    }

    test('draco3d decodes the drc to the same vertices and triangles as the glb', async () => {
      const glb = await openWithThree(files.glb.bytes);
      const drc = await openWithDraco(files.drc.bytes);
      assert.deepEqual(drc.positions, glb.positions);
      assert.deepEqual(drc.indices, glb.indices);
      assert.deepEqual(drc.normals, glb.normals);
    });

    test('three.js opens the ply with the same vertices and triangles as the glb', async () => {
      const glb = await openWithThree(files.glb.bytes);
      const ply = openPlyWithThree(files.ply.bytes);
      assert.deepEqual(ply.positions, glb.positions);
      assert.deepEqual(ply.indices, glb.indices);
      assert.deepEqual(ply.normals, glb.normals);
    });

    test('three.js opens obj and stl, and Python the 3mf, with the corners of the glb bit for bit', async () => {
      const glb = await openWithThree(files.glb.bytes);
      const corners = Float32Array.from(Array.from(glb.indices).flatMap((v) => [...glb.positions.slice(3 * v, 3 * v + 3)]));
      assert.deepEqual(openStlWithThree(files.stl.bytes), corners);
      assert.deepEqual(Float32Array.from(openObjWithThree(files.obj.bytes)), corners);
      const printed = open3mfWithPython(files['3mf'].bytes);
      assert.equal(printed.unit, 'inch');
      assert.deepEqual(printed.corners, corners);
    });

    test('colours are those of the points', async () => {
      const { positions, colors } = await openWithThree(files.glb.bytes);
      const drc = await openWithDraco(files.drc.bytes);
      assert.equal(colors !== undefined, options.painted === true);
      if (!colors) return;
      const numberOf = new Map(asSetInOrder(float32(points)).map((text, i) => [text, i]));
      asSetInOrder(positions).forEach((text, vertex) => {
        const i = numberOf.get(text);
        assert.deepEqual([...colors.slice(4 * vertex, 4 * vertex + 4)], [i % 256, (i >> 8) % 256, 77, 255]);
        const fractions = [...drc.colors.slice(4 * vertex, 4 * vertex + 4)];
        assert.deepEqual(fractions.map((c) => Math.round(255 * c)), [i % 256, (i >> 8) % 256, 77, 255]);
      });
    });
  });
}

function asSetInOrder(positions) {
  return Array.from({ length: positions.length / 3 }, (_, i) => positions.slice(3 * i, 3 * i + 3).join(' '));
}

describe('coordinates that float32 does not hold', () => {
  const centre = [412345.678, 5654321.123, 123.456];
  const points = sphere(600, { centre, radius: 50 });
  const step = 2 ** -18; // half a float32 step at 64, the least power of two above the radius

  for (const up of ['y', 'z']) {
    test(`stand in the node's translation, with up=${up}`, async () => {
      const { bytes, report } = reconstruct(plyOf(points, { real: 'double' }), 'glb', ['--param', `up=${up}`]);
      const { issues } = await validate(bytes);
      assert.deepEqual(issues.messages.filter(({ severity }) => severity <= 1), []);
      const { node, positions } = await openWithThree(bytes);
      const { origin } = node.userData;
      const distances = points.map((point) => {
        let best = Infinity;
        for (let i = 0; i < positions.length; i += 3) {
          best = Math.min(best, Math.max(...point.map((x, axis) => Math.abs(origin[axis] + positions[i + axis] - x))));
        }
        return best;
      });
      assert.ok(Math.max(...distances) <= step, `${Math.max(...distances)}`);
      assert.ok(report.encoding.max_error > 0 && report.encoding.max_error <= step * Math.sqrt(3), `${report.encoding.max_error}`);
      const turned = up === 'y' ? origin : [origin[0], origin[2], -origin[1]];
      assert.deepEqual(node.position.toArray(), turned);
      const upwards = new Vector3(0, up === 'y' ? 1 : 0, up === 'z' ? 1 : 0).applyQuaternion(node.quaternion);
      assert.ok(upwards.distanceTo(new Vector3(0, 1, 0)) < 1e-12, 'what points up in the cloud is y in the scene');
    });
  }
});

describe('quantised Draco', () => {
  const points = sphere(900);
  for (const bits of [8, 12, 16]) {
    test(`with ${bits} bits is decoded, off by no more than the report says`, async () => {
      const { bytes, report } = reconstruct(plyOf(points), 'drc', ['--param', `quantization=${bits}`]);
      const exact = await openWithThree(reconstruct(plyOf(points), 'glb').bytes);
      const { positions, indices } = await openWithDraco(bytes);
      assert.deepEqual(indices, exact.indices);
      let worst = 0;
      for (let i = 0; i < positions.length; i += 3) {
        worst = Math.max(worst, Math.hypot(...[0, 1, 2].map((axis) => positions[i + axis] - exact.positions[i + axis])));
      }
      assert.ok(Math.abs(worst - report.encoding.max_error) <= 1e-9, `${worst} and ${report.encoding.max_error}`);
      assert.ok(worst <= Math.sqrt(3) * 1.001 / (2 ** bits - 1), `${worst}`);
    });
  }
});

/** Triangles as texts that begin with their least vertex, in their order. */
function turned(indices) {
  return Array.from({ length: indices.length / 3 }, (_, t) => {
    const corners = [...indices.slice(3 * t, 3 * t + 3)];
    while (corners[0] !== Math.min(...corners)) corners.push(corners.shift());
    return corners.join(' ');
  });
}

describe('packed GLBs', () => {
  const cloud = plyOf(sphere(3000), { painted: true });
  const flags = (compression, more = []) => ['--param', `compression=${compression}`, '--param', 'vertex_quality=true', ...more];
  const open = { draco: openPackedWithDraco, meshopt: openWithThree };
  let plain;
  before(async () => {
    plain = await openWithThree(reconstruct(cloud, 'glb', ['--param', 'vertex_quality=true']).bytes);
  });

  test('the attributes of quality lie between 0 and their greatest possible values', () => {
    assert.equal(plain.edgeRatios.length, 3000);
    for (const ratio of plain.edgeRatios) assert.ok(ratio > 0 && ratio <= Math.fround(Math.sqrt(3)), `${ratio}`);
    for (const ratio of plain.radiusRatios) assert.ok(ratio > 0 && ratio <= Math.fround(Math.sqrt(3) / 6), `${ratio}`);
  });

  for (const compression of ['draco', 'meshopt']) {
    test(`${compression} passes the validator, and a decoder of other people finds the same mesh in it`, async () => {
      const { bytes, report } = reconstruct(cloud, 'glb', flags(compression));
      const { issues } = await validate(bytes);
      assert.deepEqual(issues.messages.filter(({ severity, code }) => severity <= 1 && code !== 'UNSUPPORTED_EXTENSION'), []);
      assert.equal(takeApart(bytes).json.extensionsRequired.length, 1);
      const packed = await open[compression](bytes);
      for (const name of ['positions', 'normals', 'edgeRatios']) assert.deepEqual(packed[name], plain[name], name);
      assert.deepEqual([...packed.colors].map((c) => Math.round(compression === 'draco' ? 255 * c : c)), [...plain.colors]);
      assert.deepEqual(turned(packed.indices), turned(plain.indices));
      assert.equal(report.encoding.compression, compression);
      assert.equal(report.encoding.max_error, 0);
    });

    test(`${compression} with 12 bits is off by what the report says`, async () => {
      const { bytes, report } = reconstruct(cloud, 'glb', flags(compression, ['--param', 'quantization=12']));
      const { positions } = await open[compression](bytes);
      let worst = 0;
      for (let i = 0; i < positions.length; i += 3) {
        worst = Math.max(worst, Math.hypot(...[0, 1, 2].map((axis) => positions[i + axis] - plain.positions[i + axis])));
      }
      assert.ok(worst > 0 && Math.abs(worst - report.encoding.max_error) <= 1e-9, `${worst} and ${report.encoding.max_error}`);
    });
  }
});

describe('the clouds that ./dev data fetches', () => {
  const folder = process.env.SURFACED_SHARED_DATA ?? '';
  const names = existsSync(folder) ? readdirSync(folder).filter((name) => /\.(ply|drc)$/.test(name)) : [];

  test('are there', { skip: names.length === 0 && './dev data fetches them' }, () => assert.ok(names.length > 0));

  for (const name of names) {
    test(`${name} becomes a GLB that the validator passes and three.js counts as the report does`, async () => {
      const { bytes, report } = reconstruct(readFileSync(path.join(folder, name)), 'glb');
      const { issues } = await validate(bytes);
      assert.deepEqual(issues.messages.filter(({ severity }) => severity <= 1), []);
      const { positions, indices } = await openWithThree(bytes);
      assert.equal(positions.length, 3 * report.mesh.vertices);
      assert.equal(indices.length, 3 * report.mesh.triangles);
    });
  }
});
