#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# packaging_test.sh SOURCE BUILD. Each function is a claim.
set -euo pipefail
source=$1 build=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
fail() { echo "FAILED ${FUNCNAME[1]}: $*"; exit 1; }
# Sanitizers would have to be linked into the program outside too.
grep -q '^SURFACED_SANITIZE:STRING=$' "$build/CMakeCache.txt" || { echo "skipped: a build with sanitizers"; exit 77; }

a_program_outside_the_tree_links_the_installed_library() {
  cmake --install "$build" --component development --prefix "$scratch/prefix" >/dev/null
  cp -r "$source/client-examples/library" "$scratch/program"
  cmake -S "$scratch/program" -B "$scratch/program/build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$scratch/prefix" \
    -DCMAKE_DISABLE_FIND_PACKAGE_CGAL=ON -DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON \
    -DCMAKE_CXX_COMPILER_LAUNCHER="$(command -v ccache || true)" >"$scratch/log" 2>&1 || fail "$(cat "$scratch/log")"
  cmake --build "$scratch/program/build" >"$scratch/log" 2>&1 || fail "$(cat "$scratch/log")"
  local said
  said=$("$scratch/program/build/mesh_of_points" "$scratch/sphere.glb" 2>/dev/null)
  [[ $said == "2000 vertices, 3996 triangles, closed: true, genus 0" ]] || fail "it said: $said"
}

the_debian_package_has_the_daemon_its_unit_its_user_and_no_library() {
  cpack --config "$build/CPackConfig.cmake" -B "$scratch/deb" >"$scratch/log" 2>&1 || fail "$(cat "$scratch/log")"
  local package=("$scratch"/deb/surfaced_*.deb) file
  dpkg-deb -c "${package[0]}" >"$scratch/content"
  dpkg-deb -e "${package[0]}" "$scratch/control"
  for file in usr/bin/surfaced lib/systemd/system/surfaced.service etc/surfaced.json usr/share/man/man1/surfaced.1.gz \
    usr/share/doc/surfaced/copyright usr/share/doc/surfaced/changelog.gz usr/share/doc/surfaced/operations.md; do
    grep -q " ./$file$" "$scratch/content" || fail "$file is missing in: $(cat "$scratch/content")"
  done
  grep -vE ' root/root ' "$scratch/content" && fail "files that are not root's"
  grep -E '\.(a|hpp|cmake)$' "$scratch/content" && fail "parts of the library"
  grep -qx /etc/surfaced.json "$scratch/control/conffiles" || fail "the settings are no conffile"
  for file in postinst prerm postrm; do
    [[ -x $scratch/control/$file ]] || fail "$file cannot be executed"
    sh -n "$scratch/control/$file"
  done
  grep -q 'adduser --quiet --system --group .* surfaced$' "$scratch/control/postinst" || fail "no user is made"
  grep -qE '^Depends: .*libtbb12.*adduser|^Depends: adduser.*libtbb12' "$scratch/control/control" || fail "$(cat "$scratch/control/control")"
  dpkg-deb -x "${package[0]}" "$scratch/root"
  [[ $("$scratch/root/usr/bin/surfaced" --version) == 0.* ]] || fail "the binary does not run"
  "$scratch/root/usr/bin/surfaced" check-config "$scratch/root/etc/surfaced.json" --data "$scratch/data" >/dev/null || fail "its own settings are refused"
  grep -qx 'ExecStart=/usr/bin/surfaced serve' "$scratch/root/lib/systemd/system/surfaced.service" || fail "the unit starts something else"
  grep -qx 'User=surfaced' "$scratch/root/lib/systemd/system/surfaced.service" || fail "the unit has another user"
  ! command -v lintian >/dev/null || lintian --fail-on error "${package[0]}" || fail "lintian"
}

a_missing_library_ends_the_configuration_with_its_package() {
  cmake -S "$source" -B "$scratch/poor" -DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON >"$scratch/log" 2>&1 && fail "it went on"
  tr -s ' \n' ' ' <"$scratch/log" | grep -q 'Eigen3 was not found: install libeigen3-dev (or all that is needed with ./dev setup run build)' ||
    fail "$(cat "$scratch/log")"
}

for claim in a_program_outside_the_tree_links_the_installed_library \
  the_debian_package_has_the_daemon_its_unit_its_user_and_no_library \
  a_missing_library_ends_the_configuration_with_its_package; do
  $claim
  echo "ok $claim"
done
