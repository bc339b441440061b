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

the_library_is_installed() { # once, by somebody whose umask keeps others out
  [[ -e $scratch/prefix ]] || (umask 077 && cmake --install "$build" --component development --prefix "$scratch/prefix" >/dev/null)
}

what_is_installed_is_for_everybody_whatever_the_umask() {
  the_library_is_installed
  (umask 077 && cmake --install "$build" --component daemon --prefix "$scratch/prefix" >/dev/null)
  mkdir -p "$scratch/c++/share" && chmod 700 "$scratch/c++/share"
  (umask 077 && cmake --install "$build" --component daemon --prefix "$scratch/c++" >/dev/null)
  [[ $(stat -c %a "$scratch/c++/share") == 700 ]] || fail "a folder that was there before was opened"
  [[ $(stat -c %a "$scratch/c++/bin") == 755 ]] || fail "bin is closed below a prefix with a + in it"
  local closed
  closed=$(find "$scratch/prefix" -type d ! -perm -0755 -o -type f ! -perm -0644)
  [[ -z $closed ]] || fail "closed to others: $closed"
  [[ $(stat -c %a "$scratch/prefix/bin/surfaced") == 755 ]] || fail "the binary cannot be run by others"
}

a_fresh_project_that_sets_no_standard_takes_the_package_of_cmake() {
  the_library_is_installed
  mkdir "$scratch/fresh"
  cp "$source/tests/packaging/consumer/"* "$scratch/fresh"
  cmake -S "$scratch/fresh" -B "$scratch/fresh/build" -DCMAKE_PREFIX_PATH="$scratch/prefix" \
    -DCMAKE_CXX_COMPILER_LAUNCHER="$(command -v ccache || true)" >"$scratch/log" 2>&1 || fail "$(cat "$scratch/log")"
  cmake --build "$scratch/fresh/build" >"$scratch/log" 2>&1 || fail "$(cat "$scratch/log")"
  "$scratch/fresh/build/consumer" || fail "the program says that its mesh is wrong"
}

a_compiler_and_pkg_config_are_enough() {
  the_library_is_installed
  local pc flags
  pc=$(find "$scratch/prefix" -name surfaced.pc -printf '%h')
  for flags in "--cflags --libs" "--static --cflags --libs"; do
    # shellcheck disable=SC2046,SC2086 # words on purpose
    c++ "$source/tests/packaging/consumer/consumer.cpp" $(PKG_CONFIG_PATH=$pc pkg-config $flags surfaced) -o "$scratch/consumer" \
      >"$scratch/log" 2>&1 || fail "$flags: $(cat "$scratch/log")"
    "$scratch/consumer" || fail "$flags: the program says that its mesh is wrong"
  done
}

a_missing_library_is_named_to_the_program_that_links() {
  the_library_is_installed
  cmake -S "$source/tests/packaging/consumer" -B "$scratch/lacking" -DCMAKE_PREFIX_PATH="$scratch/prefix" \
    -Dsurfaced_draco_LIBRARY=OFF >"$scratch/log" 2>&1 && fail "it went on"
  tr -s ' \n' ' ' <"$scratch/log" | grep -q 'surfaced needs draco: install libdraco-dev' || fail "$(cat "$scratch/log")"
}

the_installed_headers_do_not_take_those_of_the_program_for_their_own() {
  the_library_is_installed
  mkdir -p "$scratch/mine/io" "$scratch/mine/mesh"
  echo '#error "the program'"'"'s own io/io.hpp"' | tee "$scratch/mine/io/io.hpp" >"$scratch/mine/mesh/mesh.hpp"
  c++ -std=c++20 -fsyntax-only -I"$scratch/mine" -I"$scratch/prefix/include" "$source/tests/packaging/consumer/consumer.cpp" \
    >"$scratch/log" 2>&1 || fail "$(cat "$scratch/log")"
}

a_program_outside_the_tree_links_the_installed_library() {
  the_library_is_installed
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
  for file in usr/bin/surfaced lib/systemd/system/surfaced.service etc/surfaced.json usr/share/doc/surfaced/examples/surfaced-keys.conf usr/share/man/man1/surfaced.1.gz \
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

the_manual_lists_every_setting_as_the_program_does() {
  local manual=$scratch/root/usr/share/man/man1/surfaced.1.gz name
  [[ -e $manual ]] || fail "there is no manual"
  gzip -dc "$manual" >"$scratch/surfaced.1"
  "$build/surfaced" check-config --json --data "$scratch/data" | sed -n 's/^ *"name": "\(.*\)",$/\1/p' >"$scratch/names"
  (($(wc -l <"$scratch/names") > 40)) || fail "the program lists $(wc -l <"$scratch/names") settings"
  while read -r name; do
    grep -qF -- "\\-\\-${name//-/\\-} " "$scratch/surfaced.1" || fail "--$name is missing"
    name=SURFACED_${name^^}
    grep -qF "Variable: ${name//-/_}." "$scratch/surfaced.1" || fail "$name is missing"
  done <"$scratch/names"
  if command -v man >/dev/null; then
    man --warnings -l "$scratch/surfaced.1" 2>"$scratch/log" >/dev/null || fail "man fails: $(cat "$scratch/log")"
    [[ ! -s $scratch/log ]] || fail "man warns: $(cat "$scratch/log")"
  fi
  ! grep -qE '@|\.invalid' "$scratch/surfaced.1" || fail "it has words that the build was to replace"
}

a_missing_library_ends_the_configuration_with_its_package() {
  cmake -S "$source" -B "$scratch/poor" -DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON >"$scratch/log" 2>&1 && fail "it went on"
  tr -s ' \n' ' ' <"$scratch/log" | grep -q 'Eigen3 was not found: install libeigen3-dev (or all that is needed with ./dev setup run build)' ||
    fail "$(cat "$scratch/log")"
}

for claim in what_is_installed_is_for_everybody_whatever_the_umask \
  a_fresh_project_that_sets_no_standard_takes_the_package_of_cmake a_compiler_and_pkg_config_are_enough \
  a_missing_library_is_named_to_the_program_that_links the_installed_headers_do_not_take_those_of_the_program_for_their_own \
  a_program_outside_the_tree_links_the_installed_library \
  the_debian_package_has_the_daemon_its_unit_its_user_and_no_library \
  the_manual_lists_every_setting_as_the_program_does a_missing_library_ends_the_configuration_with_its_package; do
  $claim
  echo "ok $claim"
done
