// SPDX-License-Identifier: GPL-3.0-or-later
// The page /licenses: NOTICE, and the licence texts of all that is in the binary or that it is linked with, as they lie
// in node_modules and in Debian's /usr/share/doc.
import {existsSync, readdirSync, readFileSync} from 'node:fs';
import path from 'node:path';

/**
 * Debian's packages whose code is compiled into the binary; those of section [run] of packages.txt are linked with it.
 */
const compiledIn = [
  'libcgal-dev', 'libtinygltf-dev', 'nlohmann-json3-dev', 'libcli11-dev', 'libeigen3-dev', 'libnanoflann-dev',
  'libboost-dev'
];
const data = new Set(['ca-certificates']);
/** Texts that the packages name instead of quoting them. */
const common = ['Apache-2.0', 'GPL-2', 'GPL-3', 'LGPL-2', 'LGPL-2.1', 'LGPL-3', 'MPL-1.1', 'MPL-2.0'];

const escape = (text) => text.replaceAll('&', '&amp;').replaceAll('<', '&lt;').replaceAll('>', '&gt;');
const entry = (title, text) => `<details><summary>${escape(title)}</summary><pre>${escape(text)}</pre></details>`;

function linkedPackages(source) {
  const lines = readFileSync(path.join(source, 'packages.txt'), 'utf8').split('\n');
  const from = lines.indexOf('[run]') + 1;
  const to = lines.findIndex((line, at) => at > from && line.startsWith('['));
  return lines.slice(from, to).filter((line) => line && !line.startsWith('#') && !data.has(line)).map((line) => {
    const names = line.split('|').map((name) => name.trim());
    return names.find((name) => existsSync(`/usr/share/doc/${name}/copyright`)) ?? names[0];
  });
}

function debianEntries(source) {
  return [...compiledIn, ...linkedPackages(source)].sort().map((name) => {
    const file = `/usr/share/doc/${name}/copyright`;
    const text = existsSync(file) ? readFileSync(file, 'utf8') :
                                    `The package ${name} of the system that this was built on brings its licence.`;
    return entry(name, text);
  });
}

/** What the bundle contains: the dependencies of package.json, and theirs. */
function bundledPackages(web) {
  const seen = new Map();
  const visit = (name) => {
    if (seen.has(name)) return;
    const folder = path.join(web, 'node_modules', name);
    const about = JSON.parse(readFileSync(path.join(folder, 'package.json'), 'utf8'));
    const file = readdirSync(folder).find((each) => /^licen[cs]e/i.test(each));
    const text = file ? readFileSync(path.join(folder, file), 'utf8') : `Licence: ${about.license}`;
    seen.set(name, entry(`${name} ${about.version} (${about.license})`, text));
    Object.keys(about.dependencies ?? {}).forEach(visit);
  };
  Object.keys(JSON.parse(readFileSync(path.join(web, 'package.json'), 'utf8')).dependencies).forEach(visit);
  return [...seen].sort().map(([, text]) => text);
}

export function licensesPage(source, version, sourceUrl) {
  const web = path.join(source, 'server/web');
  const notice = readFileSync(path.join(source, 'NOTICE'), 'utf8');
  const draco = readFileSync(path.join(web, 'node_modules/three/examples/jsm/libs/draco/README.md'), 'utf8');
  const meshopt = readFileSync(path.join(web, 'node_modules/meshoptimizer/LICENSE.md'), 'utf8');
  const texts = common.filter((name) => existsSync(`/usr/share/common-licenses/${name}`))
                    .map((name) => entry(name, readFileSync(`/usr/share/common-licenses/${name}`, 'utf8')));
  const where = sourceUrl ?
      `<p>The source of this version: <a href="${escape(sourceUrl)}">${escape(sourceUrl)}</a></p>` :
      '<p>Whoever gave you this program owes you its source on request: ask the operator of this server for that of the version above.</p>';
  return `<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width"><meta name="color-scheme" content="light dark">
<title>Licences of surfaced</title></head><body>
<main><h1>Licences of surfaced ${escape(version)}</h1>
<p><a href="./">Back to the viewer</a></p>
<h2 id="source">Source</h2>${where}
<h2>Notice</h2><pre>${escape(notice)}</pre>
${entry('surfaced: GNU General Public License, version 3', readFileSync(path.join(source, 'LICENSE'), 'utf8'))}
<h2>In the page</h2>${bundledPackages(web).join('\n')}
${entry('Draco decoder (Apache-2.0)', draco)}
${entry('meshoptimizer decoder (MIT)', meshopt)}
<h2>In the daemon, or linked with it</h2>${debianEntries(source).join('\n')}
<h2>Licences that the texts above refer to</h2>${texts.join('\n')}
</main></body></html>
`;
}
