"""The same as the program: same views, same bytes of map and cloud."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

import nextview

PROGRAM = os.environ.get("NEXTVIEW_PROGRAM") or shutil.which("nextview")
COMMON: dict[str, Any] = {"views": 4, "candidates": 60, "voxel_size_m": 0.01, "seed": 3}
CASES: list[dict[str, Any]] = [
    *({"planner": planner} for planner in ["most-surface", "max-flow", "rse", "batch", "random"]),
    {"planner": "most-surface", "noise": {"model": "d435i", "seed": 5}},
    {"planner": "max-flow", "noise": {"pose_error_mm": 2.0}, "registration": {"enabled": True}},
]


@pytest.mark.skipif(PROGRAM is None, reason="NEXTVIEW_PROGRAM names no program")
@pytest.mark.parametrize("case", CASES, ids=lambda case: "-".join(case))
def test_program_and_package_agree(case: dict[str, Any], tmp_path: Path) -> None:
    ours, theirs = tmp_path / "ours", tmp_path / "theirs"
    done = nextview.scan("builtin:mug", out=ours, **COMMON, **case)
    command = [str(PROGRAM), "scan", "--config", str(ours / "config.toml"), "--out", str(theirs), "--json"]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    record = json.loads(printed)
    assert [step["view"] for step in record["steps"]] == [step["view"] for step in done.record["steps"]]
    for name in ["map.ot", "map.bt", "cloud.ply", "mesh.ply", "views.csv", "waypoints.csv", "config.toml"]:
        assert (ours / name).read_bytes() == (theirs / name).read_bytes(), name
    assert timeless(record) == timeless(done.record)


def timeless(value: Any) -> Any:
    """The record without times and memory."""
    if isinstance(value, list):
        return [timeless(each) for each in value]
    if not isinstance(value, dict):
        return value
    return {
        key: timeless(each)
        for key, each in value.items()
        if not key.endswith("_time_ms") and key != "peak_memory_mb"
    }


@pytest.mark.skipif(PROGRAM is None, reason="NEXTVIEW_PROGRAM names no program")
def test_the_program_says_who_resumes_a_scan_by_an_own_camera(tmp_path: Path) -> None:
    from conftest import begin, run

    scan = begin(out=tmp_path / "scan")
    run(scan, 1)
    del scan
    command = [str(PROGRAM), "scan", "--resume", str(tmp_path / "scan")]
    ended = subprocess.run(command, capture_output=True, text=True)
    assert ended.returncode == 2 and "nextview.resume(dir)" in ended.stderr
