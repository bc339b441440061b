#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The half of prove.sh that runs in a network of its own: prove_run.sh PLACE, with root/, data/ and config in it.
set -euo pipefail
place=$1
mapfile -d '' -t words <"$place/config"
variables=() command=() rest=no
for word in "${words[@]}"; do
  if [[ -z $word ]]; then rest=yes; elif [[ $rest == no ]]; then variables+=(--setenv "${word%%=*}" "${word#*=}"); else command+=("$word"); fi
done

fail() { echo "prove: $*" >&2; cat "$place/log" >&2; exit 1; }

# As a container engine would: user 10001 without capabilities, the root file system read-only, data alone writable.
inside() (
  exec setpriv --reuid 10001 --regid 10001 --clear-groups --inh-caps=-all --bounding-set=-all --no-new-privs \
    bwrap --ro-bind "$place/root" / --bind "$place/data" /data --proc /proc --dev /dev --unshare-pid --unshare-ipc --unshare-uts \
    --die-with-parent --as-pid-1 --clearenv "${variables[@]}" "$@"
)

now() { date +%s%N; }
until_ready() { # until_ready SERVER: the milliseconds that it took
  local begin
  begin=$(now)
  until curl -fsS -o /dev/null http://127.0.0.1:8080/readyz 2>/dev/null; do
    kill -0 "$1" 2>/dev/null || fail "the server ended"
    (($(now) - begin < 10000000000)) || fail "not ready after 10 s"
    sleep 0.02
  done
  ready=$((($(now) - begin) / 1000000))
}
stop() { # stop SERVER: by a signal to its init
  local init=$1
  until [[ $(cat "/proc/$init/comm") == tini ]]; do init=$(pgrep -P "$init"); done
  kill -TERM "$init"
  wait "$1" || fail "told to stop, it ended with $?"
  grep -q stopped "$place/log" || fail "it did not stop in order"
}

inside "${command[@]}" 2>"$place/log" >"$place/out" &
server=$!
until_ready $server
echo "start to ready: $ready ms"
((ready < 2000)) || fail "it took $ready ms to be ready; the limit is 2000"

inside surfaced health || fail "the health check fails"
[[ $(inside id -u) == 10001 ]] || fail "it does not run as user 10001"
inside sh -c 'touch /usr/x' 2>/dev/null && fail "the root file system can be written"
grep -q 'surfaced keys add FILE' "$place/log" || fail "the log does not tell how to give it keys"

curl -fsS --data-binary @client-examples/samples/knot.ply -o "$place/knot.glb" 'http://127.0.0.1:8080/v1/reconstruct?output=glb'
[[ $(head -c 4 "$place/knot.glb") == glTF ]] || fail "the mesh is no GLB"
echo "mesh: $(stat -c %s "$place/knot.glb") bytes"
curl -fsS http://127.0.0.1:8080/v1/jobs | grep -q '"status":"successful"' || fail "no successful job"

stop $server
echo "stopped in order by SIGTERM"

# The lines of docker/README.md that give it keys, as they are written: `docker run` with the flags that they have.
docker() {
  local settings=() entry=("${command[@]}")
  unset 'entry[-1]'  # the default command, which other words replace
  shift
  while [[ $1 == -* ]]; do
    case $1 in
      --rm | --read-only) shift ;;
      -p | -v) shift 2 ;;
      -e) settings+=(--setenv "${2%%=*}" "${2#*=}"); shift 2 ;;
      *) fail "docker/README.md runs the image with $1, which this does not know" ;;
    esac
  done
  [[ $1 == surfaced ]] || fail "docker/README.md runs the image $1"
  shift
  if (($#)); then inside "${settings[@]}" "${entry[@]}" "$@"; else inside "${settings[@]}" "${command[@]}"; fi
}
mapfile -t lines < <(awk '/^\*\*Docker\.\*\*/ { here = 1 } /^\*\*systemd\.\*\*/ { here = 0 } here && /^docker run /' docker/README.md)
((${#lines[@]} == 3)) || fail "docker/README.md has ${#lines[@]} lines about keys for Docker"
key=$(eval "${lines[0]}" 2>"$place/log") || fail "the key of: ${lines[0]}"
scraper=$(eval "${lines[1]}" 2>"$place/log") || fail "the key of: ${lines[1]}"
eval "${lines[2]}" 2>"$place/log" >"$place/out" &
server=$!
until_ready $server
status() { curl -sS -o /dev/null -w '%{http_code}' "$@"; }
jobs=http://127.0.0.1:8080/v1/jobs metrics=http://127.0.0.1:8080/metrics
[[ $(status $jobs) == 401 ]] || fail "who has no key is admitted"
[[ $(status -H "Authorization: Bearer $key" $jobs) == 200 ]] || fail "the key is not taken"
[[ $(status $metrics) == 401 ]] || fail "/metrics is open"
[[ $(status -H "Authorization: Bearer $scraper" $metrics) == 200 ]] || fail "the scraper's key is not taken"
[[ $(status -H "Authorization: Bearer $scraper" $jobs) == 403 ]] || fail "the scraper's key opens more than /metrics"
stop $server
echo "keys: made and taken as docker/README.md says"
