#!/usr/bin/env bash
# Runs nextview and its peers on the same input, in turn and on one core, and prints the table of ratios.
#
#   benchmarks/peers.sh [OBJECT]
#
# OBJECT is a mesh file or the name of a built-in object; default: the Stanford bunny of NEXTVIEW_DATA, else the
# built-in teapot. Needs g++ and the Debian packages liboctomap-dev, libembree-dev and liblemon-dev; a peer that cannot
# be built is named and left out. Bonxai has no package: BONXAI names a folder with include/ and src/ of its sources,
# which need Eigen (Debian package libeigen3-dev; EIGEN names another folder that holds Eigen/). PYTHON (default
# python3) names a Python with open3d, small_gicp and numpy. WORKLOAD names a folder with a workload made before. ROUNDS
# (default 2) is how often everything runs, CORE (default 0) where. PROGRAMS names a folder with our programs, which are
# built otherwise. With QUICK=1 the workload is tiny, each of our stages runs once, and no target is judged: that
# everything runs. Exits with 1 if a target is missed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

data=${NEXTVIEW_DATA:-../shared/data}
bunny=$data/meshes/stanford/bunny.ply
object=${1:-$([ -e "$bunny" ] && echo "$bunny" || echo teapot)}
programs=${PROGRAMS:-${CARGO_TARGET_DIR:-target}/release}
peers=${CARGO_TARGET_DIR:-target}/peers
workload=${WORKLOAD:-$peers/workload}
eigen=${EIGEN:-/usr/include/eigen3}
python=${PYTHON:-python3}
mkdir -p "$peers"

# Arguments: name of the peer, further arguments of the compiler.
build() {
    local name=$1
    shift
    if ! g++ -std=c++17 -O3 -march=native -DNDEBUG "benchmarks/peers/$name.cpp" -o "$peers/$name" "$@" 2>"$peers/$name.log"; then
        leave_out "$name" "it cannot be built: see $peers/$name.log"
    fi
}

# Arguments: name of the peer, reason.
leave_out() {
    rm -f "$peers/$1"
    echo "skipped: $1, $2" >&2
}

# Runs a command on one core, where the system can do that.
on_one_core() {
    if command -v taskset >/dev/null; then
        taskset -c "${CORE:-0}" "$@"
    else
        "$@"
    fi
}

if [ -z "${PROGRAMS:-}" ]; then
    cargo build --release --locked -p nextview-benchmarks
fi
build octomap -loctomap -loctomath &
build embree -lembree3 &
build flow &
if [ -z "${BONXAI:-}" ]; then
    leave_out bonxai "BONXAI names no sources"
elif [ ! -d "$eigen/Eigen" ]; then
    leave_out bonxai "it needs Eigen, which is not in $eigen: install libeigen3-dev, or name its folder as EIGEN"
else
    build bonxai -I "$BONXAI/include" -I "$eigen" "$BONXAI/src/probabilistic_map.cpp" &
fi
wait

packages=()
for package in open3d small_gicp; do
    if "$python" -c "import numpy, $package" 2>"$peers/$package.log"; then
        packages+=("$package")
    else
        leave_out "$package" "$python cannot import it and numpy: see $peers/$package.log"
    fi
done

if [ -z "${WORKLOAD:-}" ]; then
    rm -rf "$workload"
fi
echo "workload around $object" >&2
"$programs/workload" "$object" "$workload"

results=$peers/results.csv
: >"$results"
for round in $(seq "${ROUNDS:-2}"); do
    echo "round $round" >&2
    on_one_core "$programs/stages" cpu "$workload" >>"$results"
    for peer in octomap bonxai embree flow; do
        if [ -x "$peers/$peer" ]; then
            on_one_core "$peers/$peer" "$workload" >>"$results"
        fi
    done
    for package in "${packages[@]}"; do
        on_one_core "$python" benchmarks/peers/packages.py "$workload" "$package" >>"$results"
    done
    "$programs/stages" wall "$workload" decision >>"$results"
    "$programs/stages" wall "$workload" scan >>"$results"
done
"$programs/ratios" <"$results"
