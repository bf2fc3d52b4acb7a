"""Ctrl-C ends long computations at once, and other threads go on meanwhile."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import heeding_ctrl_c, interrupted_after

import nextview

BOX = [[-0.1, -0.1, -0.1], [0.1, 0.1, 0.1]]


@pytest.fixture(autouse=True)
def _heeds_ctrl_c() -> Iterator[None]:
    with heeding_ctrl_c():
        yield


def test_ctrl_c_works_within_100_ms() -> None:
    """A scan that would take a minute."""
    sent: list[float] = []

    def send() -> None:
        time.sleep(1.5)
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=send)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        nextview.scan("builtin:teapot", candidates=3000, voxel_size_m=0.002)
    took = time.monotonic() - sent[0]
    thread.join()
    print(f"interrupted after {1e3 * took:.0f} ms")
    assert took < 0.1


def test_after_ctrl_c_a_view_can_be_asked_for_again(mug: nextview.SimulatedScene) -> None:
    def begin() -> nextview.Scan:
        options = {"candidates": 1500, "voxel_size_m": 0.003, "views": 3}
        scan = nextview.Scan(mug.camera, mug.box_m, planner="max-flow", **options)  # type: ignore[arg-type]
        view = scan.next_view()
        assert view is not None
        scan.observe(mug.capture(view), view)
        return scan

    scan, undisturbed = begin(), begin()
    with interrupted_after(0.1):
        scan.next_view()
    view, expected = scan.next_view(), undisturbed.next_view()
    assert view is not None and expected is not None and view.number == expected.number


def test_other_threads_go_on_meanwhile() -> None:
    done = threading.Event()
    counts: list[int] = []

    def count() -> None:
        n = 0
        while not done.is_set():
            n += 1
            time.sleep(0.001)
        counts.append(n)

    thread = threading.Thread(target=count)
    thread.start()
    start = time.monotonic()
    nextview.scan("builtin:teapot", candidates=300, views=2, voxel_size_m=0.005)
    elapsed = time.monotonic() - start
    done.set()
    thread.join()
    assert counts[0] > 100 * elapsed


def test_ctrl_c_leaves_no_part_of_the_results(mug: nextview.SimulatedScene, tmp_path: Path) -> None:
    scan = nextview.Scan(mug.camera, mug.box_m, voxel_size_m=0.002, candidates=40, views=2, out=tmp_path)
    while (view := scan.next_view()) is not None:
        scan.observe(mug.capture(view), view)
    with interrupted_after(0.05):
        scan.save()
    assert (tmp_path / "record.json").exists() == (tmp_path / "mesh.ply").exists()
    scan.save()
    assert (tmp_path / "mesh.ply").exists()


FORKS = """
import multiprocessing
import nextview

def use() -> None:
    try:
        nextview.SimulatedScene("builtin:mug")
    except nextview.InputError as error:
        print(error, flush=True)

nextview.scan("builtin:mug", views=2, candidates=20, voxel_size_m=0.02, baselines=False)
process = multiprocessing.get_context("fork").Process(target=use)
process.start()
process.join(30)
if process.is_alive():
    process.kill()
    print("hangs")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="nothing forks there")
def test_a_forked_process_says_that_it_cannot_compute() -> None:
    ended = subprocess.run([sys.executable, "-c", FORKS], capture_output=True, text=True, timeout=120)
    assert ended.stdout.startswith("this process was forked from one that had already used nextview"), ended
