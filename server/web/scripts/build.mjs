// SPDX-License-Identifier: GPL-3.0-or-later
// Builds the viewer: types from the contract, type check, bundle, licences; then packs everything into assets.bin,
// which assets.cpp puts into the binary.
//
// usage: build.mjs OUTPUT SOURCE OPENAPI_JSON VERSION SOURCE_URL
import {execFileSync} from 'node:child_process';
import {mkdirSync, readdirSync, readFileSync, writeFileSync} from 'node:fs';
import path from 'node:path';
import {build} from 'vite';

import {licensesPage} from './licenses.mjs';
import {packAssets} from './pack.mjs';

const [output, source, contract, version, sourceUrl = ''] = process.argv.slice(2);
const web = path.join(source, 'server/web');
const bin = (name) => path.join(web, 'node_modules/.bin', name);

mkdirSync(path.join(web, 'generated'), {recursive: true});
execFileSync(
    bin('openapi-typescript'), [contract, '-o', path.join(web, 'generated/contract.d.ts')],
    {stdio: ['ignore', 'ignore', 'inherit']});
execFileSync(bin('tsc'), ['--noEmit', '-p', web], {stdio: ['ignore', 'inherit', 'inherit']});
const dist = path.join(output, 'dist');
await build({
  root: web,
  logLevel: 'warn',
  define: {__VERSION__: JSON.stringify(version), __SOURCE_URL__: JSON.stringify(sourceUrl)},
  build: {outDir: dist, emptyOutDir: true},
});

const files = [];
const addFolder = (folder, prefix, immutable) => {
  for (const name of readdirSync(folder))
    files.push({path: prefix + name, bytes: readFileSync(path.join(folder, name)), immutable});
};
addFolder(path.join(dist, 'assets'), 'assets/', true);
files.push({path: 'index.html', bytes: readFileSync(path.join(dist, 'index.html')), immutable: false});
files.push({path: 'licenses.html', bytes: Buffer.from(licensesPage(source, version, sourceUrl)), immutable: false});
const samples = path.join(source, 'client-examples/samples');
const list = JSON.parse(readFileSync(path.join(samples, 'samples.json'), 'utf8'));
files.push({path: 'samples/samples.json', bytes: Buffer.from(JSON.stringify(list)), immutable: false});
for (const {name} of list.samples)
  files.push({path: `samples/${name}`, bytes: readFileSync(path.join(samples, name)), immutable: false});

packAssets(files, output);
