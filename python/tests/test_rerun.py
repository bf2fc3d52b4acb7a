"""Recordings for the Rerun viewer, read back from their files."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from conftest import begin, run

import nextview

pytest.importorskip("rerun")


def entities(path: Path) -> str:
    """What a recording holds, as Rerun's own program prints it."""
    command = [sys.executable, "-m", "rerun", "rrd", "print", "-vv", str(path)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def test_scans_and_folders_become_recordings(tmp_path: Path) -> None:
    from nextview.rerun import log

    scan = begin(planner="most-surface", views=3)
    run(scan)
    log(scan, tmp_path / "live.rrd")
    done = nextview.scan("builtin:mug", views=2, voxel_size_m=0.02, candidates=20, out=tmp_path / "mug")
    log(done, tmp_path / "done.rrd")
    command = [sys.executable, "-m", "nextview.rerun", f"{tmp_path}/mug", "--out", f"{tmp_path}/folder.rrd"]
    subprocess.run(command, check=True)
    always = ["/world/map", "/world/cloud", "/world/mesh", "/world/camera", "/world/views/2", "/world/path"]
    framed = ["/world/camera/depth", "/world/candidates", "/world/rays"]
    for name, expected in [
        ("live", [*always, *framed, "/world/views/3", "/curves/estimated_completeness"]),
        ("done", [*always, *framed, "/curves/reachable_coverage"]),
        ("folder", [*always, "/curves/reachable_coverage"]),
    ]:
        found = entities(tmp_path / f"{name}.rrd")
        assert [each for each in expected if each not in found] == []


def test_a_folder_without_results_is_refused(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "nextview.rerun", str(tmp_path), "--out", f"{tmp_path}/none.rrd"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1 and "expected the folder of a scan's results" in done.stderr
