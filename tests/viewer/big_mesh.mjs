// SPDX-License-Identifier: GPL-3.0-or-later
// A sphere with bumps as GLB, of any size, without a reconstruction.
export function bumpySphere(rows) {
  const columns = 2 * rows;
  const positions = new Float32Array(3 * (rows + 1) * columns);
  for (let i = 0, at = 0; i <= rows; i += 1) {
    for (let j = 0; j < columns; j += 1) {
      const [a, b] = [(Math.PI * i) / rows, (2 * Math.PI * j) / columns];
      const r = 1 + 0.03 * Math.sin(9 * a) * Math.sin(8 * b);
      positions[at++] = r * Math.sin(a) * Math.cos(b);
      positions[at++] = r * Math.cos(a);
      positions[at++] = r * Math.sin(a) * Math.sin(b);
    }
  }
  const index = new Uint32Array(6 * rows * columns);
  for (let i = 0, at = 0; i < rows; i += 1) {
    for (let j = 0; j < columns; j += 1) {
      const [u, v] = [i * columns + j, i * columns + ((j + 1) % columns)];
      for (const corner of [u, v, u + columns, v, v + columns, u + columns]) index[at++] = corner;
    }
  }
  return {positions, index};
}

export function glb({positions, index}) {
  const views = [
    {buffer: 0, byteOffset: 0, byteLength: positions.byteLength},
    {buffer: 0, byteOffset: positions.byteLength, byteLength: index.byteLength}
  ];
  const json = {
    asset: {version: '2.0'},
    scene: 0,
    scenes: [{nodes: [0]}],
    nodes: [{mesh: 0}],
    meshes: [{primitives: [{attributes: {POSITION: 0}, indices: 1}]}],
    accessors: [
      {bufferView: 0, componentType: 5126, count: positions.length / 3, type: 'VEC3'},
      {bufferView: 1, componentType: 5125, count: index.length, type: 'SCALAR'}
    ],
    bufferViews: views,
    buffers: [{byteLength: positions.byteLength + index.byteLength}],
  };
  const text = JSON.stringify(json).padEnd(Math.ceil(JSON.stringify(json).length / 4) * 4);
  const head = Buffer.alloc(20);
  const size = positions.byteLength + index.byteLength;
  [0x46546c67, 2, 28 + text.length + size, text.length, 0x4e4f534a].forEach(
      (word, i) => head.writeUInt32LE(word, 4 * i));
  const chunk = Buffer.alloc(8);
  chunk.writeUInt32LE(size, 0);
  chunk.writeUInt32LE(0x004e4942, 4);
  return Buffer.concat([head, Buffer.from(text), chunk, Buffer.from(positions.buffer), Buffer.from(index.buffer)]);
}
