#!/usr/bin/env bash
# Runs nextview and its peers on the same input, in turn and on one core, and prints the table of ratios.
#
#   benchmarks/peers.sh [OBJECT]
#
# OBJECT is a mesh file or the name of a built-in object; default: the Stanford bunny of NEXTVIEW_DATA, else the built-in
# teapot. Needs g++ and the Debian packages liboctomap-dev, libembree-dev and liblemon-dev; a peer that cannot be built is
# named and left out. Bonxai has no package: BONXAI names a folder with include/ and src/ of its sources. WORKLOAD names a
# folder with a workload made before. ROUNDS (default 2) is how often everything runs, CORE (default 0) where.
# Exits with 1 if a target is missed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

data=${NEXTVIEW_DATA:-../shared/data}
bunny=$data/meshes/stanford/bunny.ply
object=${1:-$([ -e "$bunny" ] && echo "$bunny" || echo teapot)}
programs=${CARGO_TARGET_DIR:-target}/release
peers=${CARGO_TARGET_DIR:-target}/peers
workload=${WORKLOAD:-$peers/workload}
mkdir -p "$peers"

# Arguments: name of the peer, further arguments of the compiler.
build() {
    local name=$1
    shift
    if ! g++ -std=c++17 -O3 -march=native -DNDEBUG "benchmarks/peers/$name.cpp" -o "$peers/$name" "$@" 2>"$peers/$name.log"; then
        rm -f "$peers/$name"
        echo "cannot build the peer $name, left out: see $peers/$name.log" >&2
    fi
}

cargo build --release --locked -p nextview-benchmarks
build octomap -loctomap -loctomath
build embree -lembree3
build flow
if [ -n "${BONXAI:-}" ]; then
    build bonxai -I "$BONXAI/include" -I /usr/include/eigen3 "$BONXAI/src/probabilistic_map.cpp"
else
    rm -f "$peers/bonxai"
    echo "BONXAI names no sources: left out" >&2
fi

if [ -z "${WORKLOAD:-}" ]; then
    rm -rf "$workload"
fi
echo "workload around $object" >&2
"$programs/workload" "$object" "$workload"

results=$peers/results.csv
: >"$results"
for round in $(seq "${ROUNDS:-2}"); do
    echo "round $round" >&2
    taskset -c "${CORE:-0}" "$programs/stages" cpu "$workload" >>"$results"
    for peer in octomap bonxai embree flow; do
        if [ -x "$peers/$peer" ]; then
            taskset -c "${CORE:-0}" "$peers/$peer" "$workload" >>"$results"
        fi
    done
    "$programs/stages" wall "$workload" decision >>"$results"
    "$programs/stages" wall "$workload" scan >>"$results"
done
"$programs/ratios" <"$results"
