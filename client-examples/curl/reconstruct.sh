#!/usr/bin/env bash
# Uploads a cloud as a job, waits for it, downloads the mesh and prints its quality.
set -euo pipefail

usage() {
  cat <<'END'
usage: reconstruct.sh CLOUD MESH.glb [name=value...]
Parameters of the method, and method=ID, follow as name=value.
SURFACED_URL is the server (default http://127.0.0.1:8080).
END
}

if [[ ${1:-} == --help || $# -lt 2 ]]; then
  usage
  [[ ${1:-} == --help ]] && exit 0 || exit 2
fi
server=${SURFACED_URL:-http://127.0.0.1:8080}
cloud=$1 mesh=$2
shift 2
query=$(IFS='&'; echo "$*")

# A refused request answers with a problem that says what to do: show it.
request() {
  local body status
  body=$(curl -sS --retry 3 --retry-connrefused -w '\n%{http_code}' "$@")
  status=${body##*$'\n'}
  body=${body%$'\n'*}
  if ((status >= 400)); then
    echo "$body" >&2
    return 1
  fi
  echo "$body"
}

# First string value of a field of a JSON object.
field() { grep -o "\"$1\": *\"[^\"]*\"" | head -n 1 | sed 's/.*: *"//; s/"$//'; }

# -T streams the file; --data-binary would hold it in memory.
job=$(request -X POST -T "$cloud" -H 'Expect:' -H 'Content-Type: application/octet-stream' "$server/v1/jobs?$query")
id=$(field id <<<"$job")
echo "job $id" >&2
while :; do
  job=$(request "$server/v1/jobs/$id?wait=20")
  case $(field status <<<"$job") in
    accepted | running) ;;
    successful) break ;;
    *) echo "$job" >&2; exit 1 ;;
  esac
done
curl -sS --fail --retry 3 -o "$mesh" "$server/v1/jobs/$id/outputs/mesh.glb"
request "$server/v1/jobs/$id/outputs/report.json"
