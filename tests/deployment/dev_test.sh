#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What `./dev run` says where it cannot go on: one sentence with what is wrong and the way out. The machine around it is made of
# stand-ins on the path. dev_test.sh SOURCE
set -euo pipefail
source=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
chmod 755 "$folder"
mkdir "$folder/bin" "$folder/checkout"
cp "$source/dev" "$source/packages.txt" "$folder/checkout/"
chmod 755 "$folder/checkout" "$folder/checkout/dev"
chmod 644 "$folder/checkout/packages.txt"

stand_in() { # stand_in PROGRAM BODY
  printf '#!/bin/sh\n%s\n' "$2" >"$folder/bin/$1"
  chmod 755 "$folder/bin/$1"
}
failed=0
expect() { # expect CLAIM PATTERN COMMAND...: it fails, and the last line of what it says is this sentence
  local claim=$1 pattern=$2 said status=0
  shift 2
  said=$("$@" 2>&1) || status=$?
  if ((status == 0)) || ! grep -Eq "^dev: .*$pattern" <<<"$(tail -n 1 <<<"$said")"; then
    echo "FAILED: $claim (exit $status): $said"
    failed=1
  fi
}
dev() { PATH=$folder/bin:/usr/bin:/bin "$folder/checkout/dev" "$@"; }

port=$(python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')

# A listener for as long as the test needs one, and no longer than two minutes.
python3 -c '
import socket, time
s = socket.socket(); s.bind(("127.0.0.1", 0)); s.listen(8)
print(s.getsockname()[1], flush=True)
time.sleep(120)' >"$folder/taken" &
listener=$!
until [[ -s $folder/taken ]]; do kill -0 $listener; sleep 0.05; done
taken=$(<"$folder/taken")
expect "a taken port is named before anything is installed or built" \
  "something listens on 127.0.0.1:$taken already; stop it, or take another port: ./dev run --listen 127.0.0.1:$((taken + 1))" dev run --listen "127.0.0.1:$taken"
kill $listener

stand_in dpkg-query 'echo "installed bash"'
stand_in apt-cache 'exit 1'
stand_in df 'printf "Filesystem 1048576-blocks Used Available Capacity Mounted on\nroot 9000 1000 8000 12%% /\n"'
stand_in apt-get 'echo "E: Failed to fetch" >&2; exit 100'
expect "without a network, apt's lists are what is missing" \
  "package lists could not be fetched: check the network.*by hand: apt-get install --no-install-recommends .*libcgal-dev" dev run --listen "127.0.0.1:$port"
stand_in apt-get 'test "$1" = update'
expect "what apt cannot install is given to be installed by hand" \
  "apt-get could not install the packages.*By hand: apt-get install .*libcgal-dev" dev run --listen "127.0.0.1:$port"
stand_in df 'printf "Filesystem 1048576-blocks Used Available Capacity Mounted on\nroot 9000 8990 10 99%% /\n"'
expect "a full disk is named with what is needed" \
  "need 1500 MiB and the file system of /var has 10 MiB left; free some" dev run --listen "127.0.0.1:$port"
if ((EUID == 0)); then
  # Nothing but the stand-ins and a few programs: no sudo.
  for program in bash awk sed tr dirname env cat id; do ln -s "$(command -v $program)" "$folder/bin/$program"; done
  expect "without root and sudo, an administrator is given the line" \
    "neither root nor is there sudo; an administrator installs them with: apt-get install --no-install-recommends .*libcgal-dev" \
    setpriv --reuid 65534 --clear-groups env "PATH=$folder/bin" "$folder/checkout/dev" run --listen "127.0.0.1:$port"
fi
exit $failed
