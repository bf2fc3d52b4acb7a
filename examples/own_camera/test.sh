#!/usr/bin/env bash
# Kills the program with SIGKILL after each of its views in turn, and checks that no view is asked for twice and that the
# views are those of a scan that nobody disturbed. Builds the program unless it is given.
set -euo pipefail
here=$(dirname "$(realpath "${BASH_SOURCE[0]}")")
program=${1:-}
if [ -z "$program" ]; then
    # Built as the tests of the workspace are, in their folder: what they have in common is compiled once.
    export CARGO_TARGET_DIR=$here/../../target
    cargo build --quiet --locked --manifest-path "$here/Cargo.toml"
    program=$CARGO_TARGET_DIR/debug/own_camera
fi
program=$(realpath "$program")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

"$program" >undisturbed.txt
for n_views in 1 2 3 5 8; do
    rm -rf own-scan
    # Emptied before the process starts: lines of the last round would be counted as its own.
    : >disturbed.txt
    "$program" >>disturbed.txt &
    pid=$!
    until [ "$(grep -c asked disturbed.txt)" -ge "$n_views" ]; do
        sleep 0.01
    done
    kill -KILL "$pid"
    wait "$pid" 2>/dev/null || true
    n_kept=$(grep -c asked disturbed.txt)
    if [ -e own-scan/scan.journal ]; then
        "$program" >>disturbed.txt
    fi
    # The last view may have been asked for without its frame having been kept: only that one may come again.
    uniq disturbed.txt | diff - undisturbed.txt
    echo "killed after $n_kept views: no old view was asked for again"
done
