#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Turns a point cloud into a mesh with a surfaced server. Needs bash and curl 7.71 or newer.
set -euo pipefail

usage() {
  cat <<'END'
usage: reconstruct.sh CLOUD MESH.glb [name=value...]

Uploads the cloud, follows the job, downloads the mesh and prints its quality.
name=value: method=ID and the method's parameters.
SURFACED_URL is the server (default http://127.0.0.1:8080), SURFACED_KEY the key, if it wants one.
END
}

fail() { echo "reconstruct.sh: $*" >&2; exit 1; }

case ${1:-} in
  -h | --help) usage; exit 0 ;;
esac
if (($# < 2)); then usage >&2; exit 2; fi

server=${SURFACED_URL:-http://127.0.0.1:8080}
cloud=$1 mesh=$2
shift 2
query=$(IFS='&'; echo "$*")
[[ -f $cloud ]] || fail "there is no file $cloud"
answer=$(mktemp)
trap 'rm -f "$answer" "$mesh.part"' EXIT

# curl itself tries again after 429, 502, 503 and 504, when Retry-After says so.
call() {
  curl --silent --show-error --retry 5 ${SURFACED_KEY:+-H "Authorization: Bearer $SURFACED_KEY"} "$@"
}

# The first string or number of a name in a JSON object.
field() {
  grep -Eo "\"$1\": *(\"([^\"\\\\]|\\\\.)*\"|[-0-9.e]+|true|false)" | head -n 1 | sed -E 's/^[^:]*: *//; s/^"(.*)"$/\1/; s/\\(.)/\1/g'
}

# request OUTPUT ARGUMENT...: a refused request answers with a problem that says what to do.
request() {
  local output=$1 status
  shift
  status=$(call --retry-all-errors -o "$output" -w '%{http_code}' "$@") || fail "no answer from $server"
  if ((status >= 400)); then
    fail "$(field title <"$output"): $(field detail <"$output"). $(field hint <"$output")"
  fi
}

# -T streams the file; --data-binary would hold it in memory. With the key a submission whose answer was lost can be
# repeated: it makes no second job.
once="reconstruct.sh-$$-$(date +%s%N)"
[[ ! -t 2 ]] || progress=--progress-bar
request "$answer" ${progress:+--no-silent "$progress"} -X POST -T "$cloud" -H 'Expect:' \
  -H 'Content-Type: application/octet-stream' -H "Idempotency-Key: $once" "$server/v1/jobs?$query"
job=$server/v1/jobs/$(field id <"$answer")
echo "job ${job##*/}" >&2

# Server-Sent Events: lines `event: NAME`, `id: ID`, `data: JSON`. A stream that breaks off goes on after its last id.
event='' last='' silent=0
while [[ $event != done ]]; do
  event=''
  while IFS=': ' read -r name value; do
    case $name in
      event) event=$value ;;
      id) last=$value ;;
      data)
        case $event in
          progress) phase=$(field phase <<<"$value" || true) && echo "${phase:-waiting} $(field progress <<<"$value")" >&2 ;;
          done) status=$(field status <<<"$value") detail=$(sed 's/.*"error"://' <<<"$value" | field detail || true) ;;
        esac ;;
    esac
  done < <(call --no-buffer ${last:+-H "Last-Event-ID: $last"} "$job/events")
  [[ -n $event ]] || ((++silent < 5)) || fail "no more events from $job"
  [[ $event == done ]] || sleep 0.5
done
[[ $status == successful ]] || fail "$status: ${detail:-the job was dismissed}"

request "$mesh.part" "$job/outputs/mesh.glb"
mv "$mesh.part" "$mesh"
request "$answer" "$job/outputs/report.json"

# Of a nested object, the part behind its name.
within() { tr -d '\n' <"$answer" | sed "s/.*\"$1\": *{/{/"; }
echo "$(within mesh | field vertices) vertices, $(within mesh | field triangles) triangles," \
  "genus $(within mesh | field genus), closed: $(within mesh | field closed)"
echo "shortest edge / circumradius: min $(within shortest_edge_to_circumradius | field min)," \
  "mean $(within shortest_edge_to_circumradius | field mean) (equilateral: 1.732)"
echo "unused points: $(within quality | field unused_points)"
