#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Builds docker/Dockerfile with buildah, which needs no Docker engine, and proves what docker/README.md says of the image.
#   docker/prove.sh [--compile] [BINARY]
# Without --compile the stage `build` is taken as done: BINARY (build/release/surfaced) stands in for what it compiles, and
# docker/collect.sh runs outside. Needs root, and the sections [build] and [proof] of packages.txt. Work is in build/image.
set -euo pipefail
cd "$(dirname "$0")/.."
work=$PWD/build/image
compile=no
if [[ ${1:-} == --compile ]]; then compile=yes; shift; fi
binary=${1:-build/release/surfaced}
tag=localhost/surfaced:proof

fail() { echo "prove: $*" >&2; exit 1; }
((EUID == 0)) || fail "run it as root: it makes a root file system and mounts it"
for tool in mmdebstrap buildah bwrap curl git xz dpkg-shlibdeps; do
  command -v $tool >/dev/null || fail "$tool is missing; ./dev setup proof installs it"
done
[[ $compile == yes || -x $binary ]] || fail "$binary is missing; ./dev build makes it"
mkdir -p "$work"
builder() { buildah --root "$work/storage" --runroot "$work/run" --storage-driver vfs "$@"; }

# Debian's slim image, from the archive: minbase less documentation, translations and manuals.
base() {
  [[ -e $work/base.tar ]] || mmdebstrap --quiet --variant=minbase \
    --dpkgopt='path-exclude=/usr/share/doc/*' --dpkgopt='path-include=/usr/share/doc/*/copyright' \
    --dpkgopt='path-exclude=/usr/share/locale/*' --dpkgopt='path-exclude=/usr/share/man/*' bookworm "$work/base.tar.new"
  [[ -e $work/base.tar ]] || mv "$work/base.tar.new" "$work/base.tar"
  local container
  builder inspect --type image docker.io/library/debian:12-slim >/dev/null 2>&1 && return
  container=$(builder from scratch)
  builder add -q "$container" "$work/base.tar" / >/dev/null
  builder config --env PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin "$container"
  builder commit -q --rm "$container" docker.io/library/debian:12-slim >/dev/null
}

build() {
  local file=docker/Dockerfile context=()
  if [[ $compile == no ]]; then
    rm -rf "$work/build" "$work/source"
    mkdir -p "$work/source" "$work/build"
    git ls-files -z --cached --others --exclude-standard | xargs -0 cp --parents -t "$work/source"
    docker/collect.sh "$work/source" "$binary" "$work/build/out"
    file=$work/Dockerfile
    awk '/^FROM/ { skipped = / AS build$/ } !skipped' docker/Dockerfile >"$file"
    context=(--build-context "build=$work/build")
  fi
  if [[ $compile == yes ]]; then
    mkdir -p "$work/machine/ccache"
    cp /etc/ssl/certs/ca-certificates.crt "$work/machine/"
    printf 'registry=%s\ncafile=/mnt/ca-certificates.crt\n' "$(npm config get registry)" >"$work/machine/npmrc"
    context=(--volume "$work/machine:/mnt" --build-arg NPM_CONFIG_USERCONFIG=/mnt/npmrc --build-arg CCACHE_DIR=/mnt/ccache)
  fi
  # The registries of this machine may need a proxy or a certificate; the image gets none of it.
  builder bud --format docker --isolation chroot --pull-never --no-cache "${context[@]}" --volume /etc/apt/apt.conf.d:/etc/apt/apt.conf.d:ro \
    -f "$file" -t $tag . >"$work/build.log" 2>&1 || { tail -n 40 "$work/build.log" >&2; fail "the build failed; all it printed is in $work/build.log"; }
}

prove() {
  local root mebibytes container
  container=$(builder from --pull-never $tag)
  root=$(builder mount "$container")
  mebibytes=$(du -sxm "$root" | cut -f 1)
  echo "root file system: $mebibytes MiB, of which the binary $(du -sm "$root/usr/local/bin/surfaced" | cut -f 1) MiB"
  ((mebibytes < 250)) || fail "the root file system has $mebibytes MiB; the limit is 250"
  [[ $(builder inspect --type image --format '{{.OCIv1.Config.User}}' $tag) == 10001:10001 ]] || fail "the image's user is not 10001:10001"
  [[ $(builder inspect --type image --format '{{.Docker.Config.Healthcheck.Test}}' $tag) == '[CMD surfaced health]' ]] || fail "the health check is missing"
  python3 - "$root/usr/share/doc/surfaced/sbom.spdx.json" <<'END'
import json, re, sys
document = json.load(open(sys.argv[1]))
ids = [package["SPDXID"] for package in document["packages"]]
assert len(set(ids)) == len(ids) and all(re.fullmatch(r"SPDXRef-[A-Za-z0-9.-]+", each) for each in ids), ids
names = {package["name"] for package in document["packages"]}
assert {"surfaced", "libc6", "libtbb12", "libcgal-dev", "tini"} <= names, names
print(f"bill of materials: {len(ids)} packages")
END
  grep -q '==== libcgal-dev ====' "$root/usr/share/doc/surfaced/licences.txt" || fail "CGAL's licence is missing"
  tar -tJf "$root/usr/share/doc/surfaced/source.tar.xz" ./CMakeLists.txt ./LICENSE >/dev/null || fail "no source in the image"
  # A plain copy that user 10001 can reach; a network of its own, so that 0.0.0.0 is not the machine's.
  local place
  place=$(mktemp -d)
  # Expanded now, because the names are local.
  trap "umount '$place/root'; rm -rf --one-file-system '$place'; buildah --root '$work/storage' --runroot '$work/run' --storage-driver vfs rm '$container' >/dev/null" EXIT
  chmod 755 "$place"
  mkdir "$place/root" "$place/data"
  mount --bind "$root" "$place/root"
  chown 10001:10001 "$place/data"
  builder inspect --type image $tag | python3 -c '
import json, sys
config = json.load(sys.stdin)["OCIv1"]["config"]
print("\0".join(config["Env"]), end="\0\0\0")
print("\0".join(config["Entrypoint"] + config["Cmd"]), end="\0")' >"$place/config"
  bwrap --dev-bind / / --unshare-net --die-with-parent bash docker/prove_run.sh "$place"
}

# The Debian package, installed and purged in a system of its own.
package() {
  local container
  cpack --config build/release/CPackConfig.cmake -B "$work/deb" >/dev/null
  container=$(builder from --pull-never docker.io/library/debian:12-slim)
  builder copy -q "$container" "$work"/deb/surfaced_*.deb /tmp/ >/dev/null
  builder run --isolation chroot --volume /etc/apt/apt.conf.d:/etc/apt/apt.conf.d:ro "$container" -- sh -ec '
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends /tmp/surfaced_*.deb >/tmp/log 2>&1 || { cat /tmp/log; exit 1; }
    test "$(stat -c %U:%a /var/lib/surfaced)" = surfaced:750
    test -e /etc/systemd/system/multi-user.target.wants/surfaced.service
    setpriv --reuid surfaced --regid surfaced --clear-groups surfaced check-config /etc/surfaced.json --data /var/lib/surfaced >/dev/null
    echo "Debian package: surfaced $(surfaced --version) is installed"
    apt-get purge -y -qq surfaced >/tmp/log 2>&1 || { cat /tmp/log; exit 1; }
    test ! -e /var/lib/surfaced && test ! -e /usr/bin/surfaced && test ! -e /etc/surfaced.json' ||
    fail "the Debian package"
  builder rm "$container" >/dev/null
}

base
build
builder rmi --prune >/dev/null 2>&1 || true
prove
[[ ! -e build/release/CPackConfig.cmake ]] || package
echo "prove: passed"
