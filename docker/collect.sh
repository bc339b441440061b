#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# What the image takes from the build, as it lies in the image: collect.sh SOURCE BINARY OUT
# Needs the packages of [build]; the list of those that are compiled in comes from packages.txt.
set -eu
source=$1 binary=$2 out=$3
doc=$out/usr/share/doc/surfaced
mkdir -p "$out/usr/local/bin" "$doc"
strip -o "$out/usr/local/bin/surfaced" "$binary"
cp "$source/LICENSE" "$source/NOTICE" "$source/README.md" "$source/docs/service.md" "$source/docs/operations.md" "$source/docker/sbom.sh" "$doc/"
linked=$(awk '/^\[/ { s = $0; next } s == "[build]" && /-dev$/' "$source/packages.txt")
"$source/docker/sbom.sh" packages $linked > "$doc/linked.json"
{
  echo "Licences of what surfaced stands on: first of what was compiled in, then of the image's packages."
  echo
  "$source/docker/sbom.sh" licences $linked
} > "$doc/licences.txt"
tar --sort=name --owner=0 --group=0 --numeric-owner --exclude=./build --exclude=./.git --exclude=node_modules \
  -C "$source" -cJf "$doc/source.tar.xz" .
