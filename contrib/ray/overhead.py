#!/usr/bin/env python3
"""Measures the cost of shards and Ray compared with one process, on this machine: medians over repetitions.

Usage: overhead.py PROGRAM [REPETITIONS]. Needs the package `nextview` and Ray. Almost empty runs show the cost of
each; longer runs show how well workers are used. Every run has one thread.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

os.environ.update(RAY_USAGE_STATS_ENABLED="0", RAYON_NUM_THREADS="1")
import ray

import nextview
from nextview.ray import bench

N_SHARDS = 4
EMPTY = """
name = "empty"
objects = ["builtin:random-1"]
seeds = {seeds}
[scan]
planner = "random"
baselines = false
candidates = 4
views = 1
voxel_size_m = 0.05
camera = {{ width = 16, height = 12, fx = 15, fy = 15, cx = 8, cy = 6 }}
"""
LONG = """
name = "long"
objects = ["builtin:random-1", "builtin:random-2", "builtin:random-3", "builtin:random-4"]
seeds = {seeds}
[scan]
planner = "max-flow"
candidates = 100
views = 5
voxel_size_m = 0.01
stop.entropy_share = 0
"""


class Ways:
    """Ways to do a campaign, in folders of their own."""

    def __init__(self, program: str, work: Path) -> None:
        self.program, self.work, self.n_outs = program, work, 0

    def spec(self, text: str, n_seeds: int) -> Path:
        path = self.work / f"{len(text)}-{n_seeds}.toml"
        path.write_text(text.format(seeds=list(range(n_seeds))))
        return path

    def out(self) -> Path:
        self.n_outs += 1
        return self.work / str(self.n_outs)

    def nextview(self, *arguments: object) -> None:
        subprocess.run([self.program, *map(str, arguments)], check=True, capture_output=True)

    def alone(self, spec: Path) -> None:
        nextview.bench(spec, out=self.out(), jobs=1)

    def by_program(self, spec: Path) -> None:
        self.nextview("bench", spec, "--jobs", 1, "--out", self.out())

    def by_shards(self, spec: Path) -> None:
        shards = [self.out() for _ in range(N_SHARDS)]
        for k, shard in enumerate(shards, 1):
            self.nextview("bench", spec, "--shard", f"{k}/{N_SHARDS}", "--jobs", 1, "--out", shard)
        self.nextview("merge", *shards, "--out", self.out())

    def by_ray(self, spec: Path) -> None:
        bench(spec, out=self.out())

    def cluster(self, n_cpus: int) -> None:
        """Begins a cluster whose workers are there before anything is measured."""
        ray.shutdown()
        ray.init(address="local", num_cpus=n_cpus, include_dashboard=False, logging_level="error")
        self.by_ray(self.spec(EMPTY, 20 * n_cpus))


def seconds(way: Callable[[Path], None], spec: Path) -> float:
    start = time.perf_counter()
    way(spec)
    return time.perf_counter() - start


def main() -> None:
    n_times = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    work = Path(tempfile.mkdtemp(prefix="nextview-overhead-"))
    ways, n_runs = Ways(sys.argv[1], work), 400
    empty, long = ways.spec(EMPTY, n_runs), ways.spec(LONG, 6)
    more: dict[str, list[float]] = {"ray": [], "shards": []}
    took: dict[str, list[float]] = {"alone": [], "1 worker": [], "2 workers": []}
    for _ in range(n_times):
        ways.cluster(1)
        more["ray"].append(seconds(ways.by_ray, empty) - seconds(ways.alone, empty))
        more["shards"].append(seconds(ways.by_shards, empty) - seconds(ways.by_program, empty))
        took["alone"].append(seconds(ways.alone, long))
        took["1 worker"].append(seconds(ways.by_ray, long))
        ways.cluster(2)
        took["2 workers"].append(seconds(ways.by_ray, long))
        print(f"load {os.getloadavg()[0]:.1f}", more, took, file=sys.stderr)
    for name, differences in more.items():
        print(f"{name}: {1e3 * statistics.median(differences) / n_runs:+.1f} ms more for each of {n_runs} runs")
    alone = statistics.median(took["alone"])
    for name, n_workers in [("alone", 1), ("1 worker", 1), ("2 workers", 2)]:
        time_s, ideal_s = statistics.median(took[name]), alone / n_workers
        print(f"{name}: {time_s:.1f} s, ideal {ideal_s:.1f} s, efficiency {100 * ideal_s / time_s:.0f} %")
    ray.shutdown()
    subprocess.run(["rm", "-r", str(work)], check=True)


if __name__ == "__main__":
    main()
