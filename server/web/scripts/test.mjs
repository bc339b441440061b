// SPDX-License-Identifier: GPL-3.0-or-later
// Bundles the tests of a folder, which are TypeScript, and runs them under Node.
//
// usage: test.mjs FOLDER OUTPUT
import {build} from 'esbuild';
import {spawnSync} from 'node:child_process';
import {readdirSync} from 'node:fs';
import path from 'node:path';

const [folder, output] = process.argv.slice(2);
const files = readdirSync(folder).filter((name) => name.endsWith('.test.ts'));
await build({
  entryPoints: files.map((name) => path.join(folder, name)),
  bundle: true,
  platform: 'node',
  format: 'esm',
  outdir: output,
  outExtension: {'.js': '.mjs'},
  nodePaths: [path.join(import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname), '../node_modules')],
  logLevel: 'warning',
});
const run = spawnSync(
    process.execPath, ['--test', ...files.map((name) => path.join(output, name.replace(/\.ts$/, '.mjs')))],
    {stdio: 'inherit'});
process.exit(run.status ?? 1);
