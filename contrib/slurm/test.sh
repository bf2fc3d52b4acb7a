#!/usr/bin/env bash
# Runs a campaign on a Slurm of its own on this machine, with three node daemons, and compares the tables with
# those of one process. Usage: test.sh PROGRAM [SPEC]. Needs root and Debian's slurm-wlm.
set -euo pipefail
program=$(realpath "$1")
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
if ! command -v slurmctld slurmd munged >/dev/null || [ "$(id -u)" -ne 0 ]; then
    exec "$here/../../.ci/skipped" slurm slurm-wlm "needs root and slurm-wlm"
fi
work=$(mktemp -d)
chmod 755 "$work"
spec=${2:-$here/test.toml}
n_shards=16
daemons=()
end() {
    kill "${daemons[@]}" 2>/dev/null || true
    wait "${daemons[@]}" 2>/dev/null || true
    rm -rf "$work"
}
trap end EXIT

dd if=/dev/urandom of="$work/key" bs=1024 count=1 status=none
chmod 600 "$work/key"
munged --foreground --force --key-file="$work/key" --socket="$work/munge" --pid-file="$work/munge.pid" \
    --log-file="$work/munge.log" --seed-file="$work/munge.seed" >>"$work/daemons.txt" 2>&1 &
daemons+=($!)
host=$(hostname -s)
cat >"$work/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=16817
SlurmUser=root
AuthInfo=socket=$work/munge
StateSaveLocation=$work/state
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd-%n.pid
SlurmdSpoolDir=$work/spool-%n
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
SchedulerParameters=sched_interval=2,batch_sched_delay=0
MinJobAge=300
NodeName=n[1-3] NodeHostname=$host NodeAddr=127.0.0.1 Port=[17001-17003] CPUs=1 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$work/slurm.conf
mkdir "$work/state"
slurmctld -D >>"$work/daemons.txt" 2>&1 &
daemons+=($!)
for node in n1 n2 n3; do
    mkdir "$work/spool-$node"
    slurmd -D -N "$node" >>"$work/daemons.txt" 2>&1 &
    daemons+=($!)
done
for _ in $(seq 60); do
    [ "$(sinfo --noheader -o '%D' --states=idle 2>/dev/null)" != 3 ] || break
    sleep 1
done
sinfo

cd "$work"
NEXTVIEW=$program "$here/submit.sh" "$spec" out "$n_shards" --cpus-per-task=1
# Three tasks are killed in the middle and queued again.
for _ in 1 2 3; do
    sleep 2
    running=$(squeue --noheader --states=running --name=nextview -o %A | head -1)
    [ -z "$running" ] || { echo "requeue $running"; scontrol requeue "$running"; }
done
for _ in $(seq 900); do
    [ -n "$(squeue --noheader)" ] || break
    # Without this, a task that was queued again waits for two minutes.
    for job in $(squeue --noheader --states=pending --name=nextview -o %A); do
        scontrol update JobId="$job" StartTime=now 2>/dev/null || true
    done
    sleep 1
done
cat out/logs/merge.txt
"$program" bench "$spec" --out alone >alone.txt
for table in runs.csv runs.parquet steps.csv steps.parquet; do
    cmp "alone/$table" "out/campaign/$table"
done
echo "Slurm: $(wc -l <out/campaign/runs.jsonl) runs in $n_shards shards, the same tables as with one process"
