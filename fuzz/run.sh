#!/usr/bin/env bash
# Builds all targets and runs them one after the other, ten minutes in all: fuzz/run.sh [SECONDS] [TARGET...]
# Needs stable Rust and a C++ compiler. What a run finds new goes to target/corpus, where the next one begins; a crash,
# a unit of more than 20 s or one of more than 2 GB goes to target/crashes, and fails the run after all other targets.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
seconds=${1:-600}
shift || true
command -v g++ >/dev/null || ../.ci/debian.sh g++

# As cargo-fuzz does it, but without a sanitizer, which needs nightly Rust: nothing here is `unsafe`.
RUSTFLAGS="--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=3"
for kind in inline-8bit-counters pc-table trace-compares; do
    RUSTFLAGS+=" -Cllvm-args=-sanitizer-coverage-$kind"
done
export RUSTFLAGS
# With a target, these flags are not those of build scripts.
host=$(rustc -vV | sed -n 's/^host: //p')
export CARGO_TARGET_DIR=target
cargo build --quiet --release --locked --bins --target "$host"

targets=("$@")
[ $# -gt 0 ] || targets=($(basename -s .rs -a targets/*.rs))
share=$((seconds / ${#targets[@]}))
# One thread: the fuzzer counts what is reached by the order in which it is.
export RAYON_NUM_THREADS=1
mkdir -p target/crashes target/logs
all_runs=0
crashed=()
row() { printf '| %-16s | %12s | %8s | %7s |\n' "$@"; }
row target runs runs/s crashes
row ---------------- -----------: -------: ------:
for target in "${targets[@]}"; do
    log=target/logs/$target.txt
    mkdir -p "target/corpus/$target"
    n_crashes=0
    "target/$host/release/$target" "target/corpus/$target" "seeds/$target" -max_total_time=$((share > 0 ? share : 1)) \
        -max_len=8192 -timeout=20 -rss_limit_mb=2048 -print_final_stats=1 -artifact_prefix="target/crashes/$target-" \
        >"$log" 2>&1 || n_crashes=1
    # The last numbers: a target that could not even start has none.
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log" | tail -1)
    rate=$(sed -n 's/^stat::average_exec_per_sec: *//p' "$log" | tail -1)
    all_runs=$((all_runs + ${runs:-0}))
    row "$target" "${runs:-0}" "${rate:-0}" "$n_crashes"
    [ $n_crashes -eq 0 ] || crashed+=("$target")
done
row all "$all_runs" "" "${#crashed[@]}"
for target in ${crashed+"${crashed[@]}"}; do
    log=target/logs/$target.txt
    echo
    grep -m1 -A1 -E "panicked at|ERROR: libFuzzer" "$log" || tail -5 "$log"
    sed -n "s|.*Test unit written to |again: fuzz/target/$host/release/$target fuzz/|p" "$log"
done
[ ${#crashed[@]} -eq 0 ]
