"""A simulated mug, and a ball whose depth images need no renderer."""

from __future__ import annotations

import os
import re
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from numpy.typing import NDArray

import nextview

CAMERA = nextview.Camera(80, 60, fx=75.0, fy=75.0, cx=39.5, cy=29.5, depth_range_m=(0.0, 2.0))
BOX = [[-0.12, -0.12, -0.12], [0.12, 0.12, 0.12]]


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Lists skipped tests as `.ci/skipped` does, and fails if what they need is required."""
    required = os.environ.get("NEXTVIEW_REQUIRE_ALL", "").split(",")
    for report in session.config.pluginmanager.get_plugin("terminalreporter").stats.get("skipped", []):
        why = str(report.longrepr[2])
        missing = re.search(r"could not import '([^'.]+)", why)
        needs = missing[1] if missing else "nextview"
        if path := os.environ.get("NEXTVIEW_SKIPPED"):
            with open(path, "a") as file:
                file.write(f"{needs}\tpython: {report.nodeid}\t{why}\n")
        if {"1", needs} & set(required):
            session.exitstatus = pytest.ExitCode.TESTS_FAILED


@pytest.fixture(scope="session")
def mug() -> nextview.SimulatedScene:
    """The built-in mug before an exact camera."""
    return nextview.SimulatedScene("builtin:mug", voxel_size_m=0.01, candidates=40)


@contextmanager
def interrupted_after(seconds: float) -> Iterator[None]:
    """What is done here is interrupted, as by Ctrl-C, and must end with a KeyboardInterrupt."""
    timer = threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT))
    with heeding_ctrl_c():
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            yield
        timer.join()


@contextmanager
def heeding_ctrl_c() -> Iterator[None]:
    """A shell starts jobs in the background with Ctrl-C ignored, and Python then leaves it so."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def ball(world_from_camera: NDArray[np.float64]) -> NDArray[np.float32]:
    """The depth image of a ball of 0.2 m around the origin."""
    v, u = np.mgrid[0:60, 0:80]
    in_camera = np.stack([(u - 39.5) / 75.0, (v - 29.5) / 75.0, np.ones_like(u, dtype=float)], axis=-1)
    ray, eye = in_camera @ world_from_camera[:3, :3].T, world_from_camera[:3, 3]
    a, b, c = (ray**2).sum(-1), ray @ eye, eye @ eye - 0.01
    root = b * b - a * c
    depth = np.where(root > 0, (-b - np.sqrt(np.maximum(root, 0))) / a, np.inf)
    return depth.astype(np.float32)


def begin(**options: object) -> nextview.Scan:
    """A scan of the ball."""
    given = {"planner": "max-flow", "views": 6, "candidates": 40, "voxel_size_m": 0.02}
    return nextview.Scan(CAMERA, BOX, **{**given, **options})  # type: ignore[arg-type]


def run(scan: nextview.Scan, n_steps: int = 99) -> None:
    """Takes so many views of the ball, with colours."""
    color = np.full((60, 80, 3), [200, 10, 20], dtype=np.uint8)
    for _ in range(n_steps):
        view = scan.next_view()
        if view is None:
            return
        scan.observe(ball(view.world_from_camera), view, color)
