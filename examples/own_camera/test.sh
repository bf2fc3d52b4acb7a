#!/usr/bin/env bash
# Kills the program with SIGKILL after each of its views in turn, and checks that no view is asked for twice and that the
# views are those of a scan that nobody disturbed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
cargo build --release --quiet
program=$PWD/target/release/own_camera
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

"$program" >undisturbed.txt
for n_views in 1 2 3 5 8; do
    rm -rf own-scan
    coproc "$program"
    for _ in $(seq "$n_views"); do
        read -r line <&"${COPROC[0]}"
        echo "$line"
    done >disturbed.txt
    kill -KILL "$COPROC_PID" 2>/dev/null || true
    # What it printed before it died counts, too.
    cat <&"${COPROC[0]}" >>disturbed.txt || true
    wait "$COPROC_PID" 2>/dev/null || true
    n_kept=$(grep -c asked disturbed.txt)
    if [ -e own-scan/scan.journal ]; then
        "$program" >>disturbed.txt
    fi
    # The last view may have been asked for without its frame having been kept: only that one may come again.
    uniq disturbed.txt | diff - undisturbed.txt
    echo "killed after $n_kept views: no old view was asked for again"
done
