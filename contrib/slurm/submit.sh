#!/usr/bin/env bash
# Runs a campaign as an array of Slurm jobs, and merges its shards into OUT/campaign when they have ended.
# Usage: submit.sh SPEC OUT N_SHARDS [OPTION OF SBATCH]...
# NEXTVIEW names the program; it and all paths must be the same on every node.
set -euo pipefail
[ $# -ge 3 ] || { sed -n '2,4s/^# //p' "$0" >&2; exit 2; }
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
spec=$1 out=$2 n_shards=$3
shift 3
# A built-in specification is a name and no file.
[ ! -e "$spec" ] || spec=$(realpath "$spec")
mkdir -p "$out/logs"
out=$(realpath "$out")
export NEXTVIEW=${NEXTVIEW:-nextview}

shards=$(sbatch --parsable --array="1-$n_shards" --output="$out/logs/%a.txt" "$@" \
    "$here/shard.sbatch" "$spec" "$out" "$n_shards")
# After any end: a shard whose runs failed has ended well, and the merge reports what is missing.
merge=$(sbatch --parsable --dependency="afterany:$shards" --output="$out/logs/merge.txt" "$@" \
    "$here/merge.sbatch" "$out" "$n_shards")
echo "shards $shards, merge $merge; results will be in $out/campaign"
