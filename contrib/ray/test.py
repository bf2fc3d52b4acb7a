#!/usr/bin/env python3
"""Runs a campaign on a Ray of four nodes on this machine, kills one of them in the middle, then the driver,
starts the driver again, and compares the tables with those of one process.

Usage: test.py [SPEC]. Needs the package `nextview` and Ray. With a program of the same build in
NEXTVIEW_PROGRAM, its tables are compared, too.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
try:
    import ray
    from ray.cluster_utils import Cluster
except ImportError:
    skipped = Path(__file__).parents[2] / ".ci/skipped"
    sys.exit(subprocess.run([skipped, "ray", "ray", "needs the package ray"]).returncode)
import nextview

TABLES = ["runs.csv", "runs.parquet", "steps.csv", "steps.parquet"]
N_NODES = 3
"""Nodes of one CPU each, beside the head, which has none."""


def n_lines(path: Path) -> int:
    return path.read_bytes().count(b"\n") if path.exists() else 0


def begin(spec: Path, out: Path, address: str, log: Path) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "nextview.ray", "bench", str(spec), "--out", str(out), "--address", address]
    with log.open("ab") as file:
        return subprocess.Popen(command, stderr=file, stdout=file)


def wait_for(n: int, runs: Path, driver: subprocess.Popen[bytes]) -> None:
    while n_lines(runs) < n:
        assert driver.poll() is None, "the driver ended too early"
        time.sleep(0.02)


def main() -> None:
    spec = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent / "slurm" / "test.toml").resolve()
    work = Path(tempfile.mkdtemp(prefix="nextview-ray-"))
    start = time.monotonic()
    n_runs = len(nextview.bench(spec, out=work / "alone").runs["object"])
    print(f"one process: {n_runs} runs in {time.monotonic() - start:.1f} s")

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, "include_dashboard": False})
    nodes = [cluster.add_node(num_cpus=1) for _ in range(N_NODES)]
    out, log = work / "out", work / "log.txt"
    runs = out / "runs.jsonl"
    start = time.monotonic()
    driver = begin(spec, out, cluster.address, log)
    wait_for(n_runs // 5, runs, driver)
    cluster.remove_node(nodes[0], allow_graceful=False)
    print(f"one of {N_NODES} nodes killed after {n_lines(runs)} runs")
    wait_for(3 * n_runs // 5, runs, driver)
    driver.send_signal(signal.SIGKILL)
    driver.wait()
    print(f"driver killed after {n_lines(runs)} runs")
    ended = begin(spec, out, cluster.address, log).wait()
    print(f"ended with {ended} after {time.monotonic() - start:.1f} s")
    print(log.read_text(), end="")
    assert ended == 0 and n_lines(runs) == n_runs, n_lines(runs)
    for table in TABLES:
        assert (work / "alone" / table).read_bytes() == (out / table).read_bytes(), table
    print(f"Ray: {n_runs} runs on {N_NODES} nodes, the same tables as with one process")
    if program := os.environ.get("NEXTVIEW_PROGRAM"):
        command = [program, "bench", str(spec), "--out", str(work / "program")]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        for table in TABLES:
            assert (work / "program" / table).read_bytes() == (out / table).read_bytes(), table
        print("and of the program")
    cluster.shutdown()
    subprocess.run(["rm", "-r", str(work)], check=True)


if __name__ == "__main__":
    main()
