#!/usr/bin/env bash
# Counts the instructions of every stage with callgrind, on the built-in teapot, and compares with benchmarks/instructions.csv.
#
#   benchmarks/instructions.sh [--record] [NAME]
#
# NAME is a part of the names of the stages to count. --record writes the file instead of comparing with it. Counts do not
# depend on what else the machine does, but on the compiler: the file says which made it. Callgrind knows no AVX-512, so the
# AVX2 code is counted. Exits with 1 if a count is more than 3 % above the record. Needs valgrind.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

is_recording=false
if [ "${1:-}" = --record ]; then
    is_recording=true
    shift
fi
name=${1:-}
programs=${CARGO_TARGET_DIR:-target}/release
scratch=${CARGO_TARGET_DIR:-target}/instructions
mkdir -p "$scratch"

cargo build --release --locked -p nextview-benchmarks >&2
rm -rf "$scratch/workload"
"$programs/workload" teapot "$scratch/workload" 2>/dev/null

echo "# $(rustc --version), $(uname -m)" >"$scratch/counts.csv"
"$programs/kernels" | { grep -F -- "$name" || true; } | while IFS= read -r stage; do
    valgrind --tool=callgrind --callgrind-out-file=/dev/null --collect-atstart=no --toggle-collect='kernels::counted' \
        "$programs/kernels" "$scratch/workload" "$stage" 2>"$scratch/log" || { cat "$scratch/log" >&2; exit 1; }
    echo "$stage;$(sed -n 's/.*Collected : *//p' "$scratch/log")" >>"$scratch/counts.csv"
done

if $is_recording; then
    cp "$scratch/counts.csv" benchmarks/instructions.csv
    cat benchmarks/instructions.csv
    exit
fi
head -n 1 "$scratch/counts.csv" | cmp -s - <(head -n 1 benchmarks/instructions.csv) ||
    echo "the compiler differs from that of the record: $(head -n 1 benchmarks/instructions.csv)" >&2
awk -F';' '
    /^#/ { next }
    { count = $NF; stage = substr($0, 1, length($0) - length(count) - 1) }
    FNR == NR { record[stage] = count; next }
    stage in record {
        change = 100 * (count / record[stage] - 1)
        printf "%-50s %14d %+8.2f %%\n", stage, count, change
        if (change > 3) worse++
        next
    }
    { printf "%-50s %14d   new\n", stage, count }
    END { if (worse) { printf "%d above the record by more than 3 %%\n", worse; exit 1 } }
' benchmarks/instructions.csv "$scratch/counts.csv"
