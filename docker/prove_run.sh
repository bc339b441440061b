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
begin=$(now)
inside "${command[@]}" 2>"$place/log" >"$place/out" &
server=$!
until curl -fsS -o /dev/null http://127.0.0.1:8080/readyz 2>/dev/null; do
  kill -0 $server 2>/dev/null || fail "the server ended"
  (($(now) - begin < 10000000000)) || fail "not ready after 10 s"
  sleep 0.02
done
ready=$((($(now) - begin) / 1000000))
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

init=$server
until [[ $(cat "/proc/$init/comm") == tini ]]; do init=$(pgrep -P "$init"); done
kill -TERM "$init"
wait $server || fail "told to stop, it ended with $?"
grep -q stopped "$place/log" || fail "it did not stop in order"
echo "stopped in order by SIGTERM"
