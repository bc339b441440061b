// SPDX-License-Identifier: GPL-3.0-or-later
// Clouds made here, the command that meshes them, and readers that share no code with it.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import draco3d from 'draco3d';
import validator from 'gltf-validator';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { OBJLoader } from 'three/addons/loaders/OBJLoader.js';
import { PLYLoader } from 'three/addons/loaders/PLYLoader.js';
import { STLLoader } from 'three/addons/loaders/STLLoader.js';

// three's FileLoader reports progress with it, even for data URIs; Node has none.
globalThis.ProgressEvent ??= class extends Event {};

/** Nearly even points on a sphere: a Fibonacci spiral. */
export function sphere(count, { centre = [0, 0, 0], radius = 1 } = {}) {
  const golden = Math.PI * (3 - Math.sqrt(5));
  return Array.from({ length: count }, (_, i) => {
    const z = 1 - (2 * i + 1) / count;
    const r = Math.sqrt(1 - z * z);
    return [r * Math.cos(golden * i), r * Math.sin(golden * i), z].map((x, axis) => centre[axis] + radius * x);
  });
}

/** A binary PLY of points; `real` is float or double; with normals and colours where `painted`. */
export function plyOf(points, { real = 'float', painted = false } = {}) {
  const properties = ['x', 'y', 'z'].map((name) => `property ${real} ${name}\n`);
  if (painted) {
    properties.push(...['nx', 'ny', 'nz'].map((name) => `property float ${name}\n`));
    properties.push(...['red', 'green', 'blue'].map((name) => `property uchar ${name}\n`));
  }
  const header = `ply\nformat binary_little_endian 1.0\nelement vertex ${points.length}\n${properties.join('')}end_header\n`;
  const row = (real === 'float' ? 12 : 24) + (painted ? 15 : 0);
  const body = Buffer.alloc(points.length * row);
  let at = 0;
  points.forEach((point, i) => {
    for (const x of point) at = real === 'float' ? body.writeFloatLE(x, at) : body.writeDoubleLE(x, at);
    if (!painted) return;
    for (const x of point) at = body.writeFloatLE(x / Math.hypot(...point), at);
    for (const c of [i % 256, (i >> 8) % 256, 77]) at = body.writeUInt8(c, at);
  });
  return Buffer.concat([Buffer.from(header), body]);
}

/** Runs the command on a cloud and returns the mesh file's bytes and the report. */
export function reconstruct(cloud, extension, flags = []) {
  const folder = mkdtempSync(path.join(tmpdir(), 'surfaced-readers-'));
  try {
    const [input, output, report] = ['cloud.ply', `mesh.${extension}`, 'report.json'].map((name) => path.join(folder, name));
    writeFileSync(input, cloud);
    execFileSync(process.env.SURFACED_BIN, [
      'reconstruct', input, '-o', output, '--method', 'advancing-front', '--report', report, ...flags,
    ]);
    return { bytes: readFileSync(output), report: JSON.parse(readFileSync(report, 'utf8')) };
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
}

/** What Khronos' validator says of a glTF or GLB. */
export const validate = (bytes) => validator.validateBytes(new Uint8Array(bytes), { maxIssues: 100 });

const toArrayBuffer = (bytes) => bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);

const fromGeometry = (geometry) => ({
  positions: geometry.getAttribute('position').array,
  normals: geometry.getAttribute('normal')?.array,
  colors: geometry.getAttribute('color')?.array,
  edgeRatios: geometry.getAttribute('_l_over_r')?.array,
  radiusRatios: geometry.getAttribute('_r_over_l')?.array,
  indices: Uint32Array.from(geometry.getIndex().array),
});

/** three.js' view of a glTF or GLB: the arrays of its mesh, and the node with its place in the world. */
export async function openWithThree(bytes) {
  const { scene, asset } = await new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).parseAsync(toArrayBuffer(bytes), '');
  const meshes = [];
  scene.updateMatrixWorld(true);
  scene.traverse((node) => node.isMesh && meshes.push(node));
  if (meshes.length !== 1) throw new Error(`${meshes.length} meshes`);
  return { ...fromGeometry(meshes[0].geometry), node: meshes[0], asset };
}

export const openPlyWithThree = (bytes) => fromGeometry(new PLYLoader().parse(toArrayBuffer(bytes)));

/** The corners of all triangles, nine numbers each, as three.js reads them. */
export const openStlWithThree = (bytes) => new STLLoader().parse(toArrayBuffer(bytes)).getAttribute('position').array;
export function openObjWithThree(bytes) {
  const meshes = [];
  new OBJLoader().parse(bytes.toString('latin1')).traverse((node) => node.isMesh && meshes.push(node));
  if (meshes.length !== 1) throw new Error(`${meshes.length} meshes`);
  return meshes[0].geometry.getAttribute('position').array;
}

/** A 3MF as Python's zipfile and XML parser read it: unit, and the corners of all triangles. */
export function open3mfWithPython(bytes) {
  const script = `
import io, json, sys, zipfile, xml.etree.ElementTree as tree
archive = zipfile.ZipFile(io.BytesIO(sys.stdin.buffer.read()))
assert archive.testzip() is None and archive.namelist()[0] == '[Content_Types].xml'
core = '{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}'
model = tree.fromstring(archive.read('3D/3dmodel.model'))
points = [[float(v.get(a)) for a in 'xyz'] for v in model.iter(core + 'vertex')]
corners = [points[int(t.get(k))] for t in model.iter(core + 'triangle') for k in ('v1', 'v2', 'v3')]
print(json.dumps({'unit': model.get('unit'), 'corners': corners}))
`;
  const text = execFileSync('python3', ['-c', script], { input: bytes, encoding: 'utf8', maxBuffer: 1 << 28 });
  const { unit, corners } = JSON.parse(text);
  return { unit, corners: Float32Array.from(corners.flat()) };
}

/** The JSON and the binary chunk of a GLB. */
export function takeApart(bytes) {
  const length = bytes.readUInt32LE(12);
  return { json: JSON.parse(bytes.subarray(20, 20 + length).toString('utf8')), binary: bytes.subarray(28 + length) };
}

/** What draco3d finds in a GLB with KHR_draco_mesh_compression, by the ids that the file gives. */
export async function openPackedWithDraco(bytes) {
  const { json, binary } = takeApart(bytes);
  const { bufferView, attributes } = json.meshes[0].primitives[0].extensions.KHR_draco_mesh_compression;
  const { byteOffset = 0, byteLength } = json.bufferViews[bufferView];
  return openWithDraco(binary.subarray(byteOffset, byteOffset + byteLength), attributes);
}

/** draco3d's view of a Draco mesh; attributes by the types, or by the ids of a glTF. */
export async function openWithDraco(bytes, ids) {
  const draco = await draco3d.createDecoderModule({});
  const decoder = new draco.Decoder();
  const mesh = new draco.Mesh();
  const status = decoder.DecodeArrayToMesh(new Int8Array(bytes), bytes.length, mesh);
  if (!status.ok()) throw new Error(status.error_msg());
  const attribute = (type, components, name) => {
    const id = ids ? ids[name] ?? -1 : decoder.GetAttributeId(mesh, type);
    if (id < 0) return undefined;
    const values = new draco.DracoFloat32Array();
    const found = ids ? decoder.GetAttributeByUniqueId(mesh, id) : decoder.GetAttribute(mesh, id);
    decoder.GetAttributeFloatForAllPoints(mesh, found, values);
    const array = Float32Array.from({ length: components * mesh.num_points() }, (_, i) => values.GetValue(i));
    draco.destroy(values);
    return array;
  };
  const face = new draco.DracoInt32Array();
  const indices = new Uint32Array(3 * mesh.num_faces());
  for (let f = 0; f < mesh.num_faces(); ++f) {
    decoder.GetFaceFromMesh(mesh, f, face);
    for (let k = 0; k < 3; ++k) indices[3 * f + k] = face.GetValue(k);
  }
  const result = {
    positions: attribute(draco.POSITION, 3, 'POSITION'),
    normals: attribute(draco.NORMAL, 3, 'NORMAL'),
    colors: attribute(draco.COLOR, 4, 'COLOR_0'),
    edgeRatios: ids && attribute(draco.GENERIC, 1, '_L_OVER_R'),
    indices,
  };
  draco.destroy(face);
  draco.destroy(mesh);
  draco.destroy(decoder);
  return result;
}

/** Points of an array of coordinates as sorted texts: equal for the same set of points, bit for bit. */
export function asSet(positions) {
  const texts = [];
  for (let i = 0; i < positions.length; i += 3) texts.push(positions.slice(i, i + 3).join(' '));
  return texts.sort();
}
