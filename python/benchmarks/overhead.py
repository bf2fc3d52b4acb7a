"""The extra cost of a call from Python over one from Rust: `observe` of 640 x 480 pixels, and `next_view`.

    cargo build --release -p nextview-benchmarks --bin live
    python python/benchmarks/overhead.py target/release/live [ROUNDS]

Both scan the same object with the same frames, alternating, so that other load on the machine affects both. A call's
time is the minimum over all rounds; the ratio is that of the sums over all views.
"""

from __future__ import annotations

import subprocess
import sys
import time

import numpy as np
from numpy.typing import NDArray

import nextview

VIEWS = 6


def main(program: str, n_rounds: int = 10) -> None:
    """Prints a line for each planner and call."""
    sim = nextview.SimulatedScene("builtin:mug", voxel_size_m=0.005)
    for planner in ("most-surface", "max-flow"):
        command = [program, planner, str(VIEWS)]
        with subprocess.Popen(command, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as rust:
            assert rust.stdin is not None and rust.stdout is not None
            ours, theirs = [], []
            for _ in range(n_rounds):
                rust.stdin.write("\n")
                rust.stdin.flush()
                theirs.append(np.array(rust.stdout.readline().split(), dtype=float).reshape(-1, 2))
                ours.append(times(sim, planner))
            rust.stdin.close()
        # The first view is given: nothing is planned.
        in_python, in_rust = np.min(ours, axis=0), np.min(theirs, axis=0)
        for call, column, first in (("next_view", 0, 1), ("observe", 1, 0)):
            a, b = in_python[first:, column].mean(), in_rust[first:, column].mean()
            more = 100 * (a / b - 1)
            print(f"{planner:<14} {call:<10} Python {a:8.3f} ms, Rust {b:8.3f} ms, {more:+.1f} %")


def times(sim: nextview.SimulatedScene, planner: str) -> NDArray[np.float64]:
    """The milliseconds of `next_view` and `observe` of a scan: views x 2."""
    scan = nextview.Scan(sim.camera, sim.box_m, planner=planner, views=VIEWS, voxel_size_m=0.005)
    found: list[tuple[float, float]] = []
    while True:
        start = time.perf_counter()
        view = scan.next_view()
        next_s = time.perf_counter() - start
        if view is None:
            return 1e3 * np.array(found)
        depth = sim.capture(view)
        start = time.perf_counter()
        scan.observe(depth, view)
        found.append((next_s, time.perf_counter() - start))


if __name__ == "__main__":
    main(sys.argv[1], *(int(number) for number in sys.argv[2:3]))
