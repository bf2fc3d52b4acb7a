#!/usr/bin/env bash
# Compares all planners on a folder of meshes: benchmarks/planners.sh SETTING OUT MESH ...
#
# SETTING is a file of benchmarks/planners without its extension. The meshes are split in two halves, by whether the first byte of the
# SHA-256 of the file's name without extension is even (dev: what the planner most-surface was developed and trained on) or odd (test).
# Each half is a campaign of its own: OUT/SETTING-dev and OUT/SETTING-test. HALF=test runs one of them alone.
set -euo pipefail
here="$(dirname "${BASH_SOURCE[0]}")"
if [ $# -lt 3 ]; then
    echo "usage: benchmarks/planners.sh SETTING OUT MESH ..." >&2
    exit 2
fi
setting="$1" out="$2"
shift 2

half_of() {
    local name byte
    name="$(basename "$1")"
    byte="$(printf '%s' "${name%.*}" | sha256sum | cut -c1-2)"
    if ((16#$byte % 2)); then echo test; else echo dev; fi
}

mkdir -p "$out"
for half in ${HALF:-dev test}; do
    meshes=()
    for mesh in "$@"; do
        if [ "$(half_of "$mesh")" = "$half" ]; then meshes+=("$mesh"); fi
    done
    if [ ${#meshes[@]} -gt 0 ]; then
        "${NEXTVIEW:-nextview}" bench "$here/planners/$setting.toml" "${meshes[@]}" --out "$out/$setting-$half"
    fi
done
