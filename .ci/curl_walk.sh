#!/usr/bin/env bash
# Does the scan of docs/server.md as it is written there, and checks the description of the routes.
# Usage: curl_walk.sh PROGRAM TAKE_FRAME PYTHON; the Python needs openapi-spec-validator.
set -euo pipefail
program=$(realpath "$1")
take_frame=$(realpath "$2")
python=$(realpath -s "$3")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
page=$PWD/docs/server.md
work=$(mktemp -d)
cd "$work"
mkdir bin
touch printed
ln -s "$take_frame" bin/take_frame
"$program" serve --listen 127.0.0.1:0 --dir scans >printed &
server=$!
trap 'kill $server 2>/dev/null || true; rm -rf "$work"' EXIT
until grep -q '^page: ' printed; do
    kill -0 $server
    sleep 0.05
done
address=$(sed -n 's/^listening on //p' printed)

curl --fail -s "$address/openapi.json" -o openapi.json
"$python" -m openapi_spec_validator openapi.json

awk '/^```bash$/ { on = 1; next } /^```$/ { on = 0 } on' "$page" | sed "s|http://127.0.0.1:7878|$address|" >walk.sh
PATH="$work/bin:$PATH" bash -euo pipefail walk.sh >answers
n_frames=$(grep -o '"duplicate":false' answers | wc -l)
[ "$n_frames" -eq 6 ] || { echo "$n_frames frames, expected 6" >&2; exit 1; }
head -c 3 mesh.ply | grep -q ply
kill -TERM $server
wait $server
echo "docs/server.md: $n_frames frames, $(wc -c <mesh.ply) bytes of mesh; openapi.json is valid"
