#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The README's first command and the line that it prints: `./dev run` configures and builds without any package of section
# [test], serves, and answers that very line with a mesh. Uses build/release, so that the tests compile nothing twice.
#   tests/first_run.sh
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
server=
finish() {
  if [[ -n $server ]]; then kill "$server" 2>/dev/null || true; wait "$server" 2>/dev/null || true; fi
  rm -rf "$folder"
}
trap finish EXIT
fail() { echo "first run: $*" >&2; tail -n 40 "$folder/log" >&2; exit 1; }

# One that nothing listens on; a bare machine has no Python to ask for one.
port=$((20000 + RANDOM % 10000))
while (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null; do port=$((port + 1)); done
# What CMake would find of [test] is not to be found; none of the programs of [test] is on the path either.
hidden=()
for package in GTest benchmark GMock Clang LLVM; do hidden+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON"); done
mkdir "$folder/bin"
for program in chromium clang-14 clang++-14 clang-format-14 clang-tidy-14 codespell openssl dpkg-deb; do
  printf '#!/bin/sh\necho "first run: %s is of section [test]" >&2\nexit 127\n' "$program" >"$folder/bin/$program"
done
chmod +x "$folder"/bin/*
# What a build before this one switched on goes back to what a newcomer gets.
if [[ -e build/release/CMakeCache.txt ]]; then cmake -USURFACED_TESTS -USURFACED_BENCHMARKS build/release >/dev/null; fi
PATH=$folder/bin:$PATH CMAKE_ARGS="${hidden[*]}" ./dev run --listen "127.0.0.1:$port" --data "$folder/data" >"$folder/log" 2>&1 &
server=$!
# Whoever reads along sees each step.
tail -n +1 -f --pid=$server "$folder/log" &
until grep -q "^  curl " "$folder/log"; do
  kill -0 "$server" 2>/dev/null || fail "./dev run ended before it served"
  sleep 0.5
done
line=$(grep -m 1 "^  curl " "$folder/log" | sed "s| -o knot.glb | -o $folder/knot.glb |")
eval "$line" || fail "the line that ./dev run prints fails: $line"
[[ $(head -c 4 "$folder/knot.glb") == glTF ]] || fail "what came is no GLB"
kill "$server"
wait "$server" || fail "the server did not end in order"
server=
! grep -q "first run: .* of section" "$folder/log" || fail "a program of section [test] was asked for"
# The tests' configuration starts with these packages found again.
cmake build/release $(printf -- '-U%s ' "CMAKE_DISABLE_FIND_PACKAGE_*") >/dev/null
echo "first run: served, and answered the README's line with a mesh"
