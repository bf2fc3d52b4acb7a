"""Simulated scenes, whole scans and campaigns."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nextview


def test_an_own_camera_that_is_simulated_scans_as_the_simulation_does(mug: nextview.SimulatedScene) -> None:
    options: dict[str, Any] = {"planner": "max-flow", "views": 4, "voxel_size_m": 0.01}
    expected = nextview.scan("builtin:mug", candidates=40, baselines=False, **options)
    scan = nextview.Scan(mug.camera, mug.box_m, poses=mug.candidates, **options)
    while (view := scan.next_view()) is not None:
        scan.observe(mug.capture(view), view)
    views = [[step["view"] for step in record["steps"]] for record in (scan.record, expected.record)]
    assert views[0] == views[1]
    assert scan.map is not None and expected.map is not None
    # Matrices of poses lose their last bits.
    assert (scan.map.occupancy != expected.map.occupancy).mean() < 1e-3


def test_a_simulated_camera_has_the_errors_of_its_sensor() -> None:
    exact = nextview.SimulatedScene("builtin:mug", candidates=5)
    noisy = nextview.SimulatedScene("builtin:mug", candidates=5, sensor="d405", noise={"pose_error_mm": 2.0})
    assert noisy.camera.width == 848 and noisy.camera.depth_range_m[1] == 0.5
    pose = noisy.candidates[0]
    depth, claimed = noisy.frame(pose)
    assert depth.shape == (480, 848) and 0 < np.linalg.norm(claimed[:3, 3] - pose[:3, 3]) < 0.02
    _, right = exact.frame(pose)
    np.testing.assert_allclose(right, pose, atol=1e-12)
    assert np.isfinite(exact.capture(pose)).any() and "mug" in repr(exact)
    with pytest.raises(nextview.NextviewError):
        exact.capture(np.eye(4) + 1e6 * np.eye(4, k=3))


def test_a_whole_scan_is_measured_and_reported() -> None:
    steps: list[dict[str, Any]] = []
    options: dict[str, Any] = {"views": 3, "candidates": 30, "voxel_size_m": 0.01}
    done = nextview.scan("builtin:mug", on_step=steps.append, **options)
    assert [step["step"] for step in steps] == [1, 2, 3] and done.record["skill"] is not None
    assert done.cloud is not None and done.mesh is not None and done.map is not None
    assert done.config["views"] == 3 and done.notes == []

    def fail(step: dict[str, Any]) -> None:
        raise RuntimeError(f"after step {step['step']}")

    with pytest.raises(RuntimeError, match="after step 1"):
        nextview.scan("builtin:mug", on_step=fail, **options)


SPEC: dict[str, Any] = {
    "name": "two",
    "objects": ["builtin:mug"],
    "scan": {"views": 2, "candidates": 20, "voxel_size_m": 0.02},
    "variant": [{"scan": {"planner": "random"}}, {"scan": {"planner": "max-flow"}}],
}


def test_a_campaign_gives_columns(tmp_path: Path) -> None:
    events: list[dict[str, Any]] = []
    done = nextview.bench(SPEC, out=tmp_path / "study", on_event=events.append)
    assert done.runs["variant"] == ["random", "max-flow"] and done.failed == []
    assert done.runs["skill"].dtype == np.float64 and done.steps["step"].dtype == np.int64
    assert len({len(column) for column in done.steps.values()}) == 1 and len(done.steps["step"]) == 4
    assert sum("run-finished" in event for event in events) == 2
    again = nextview.bench(SPEC, out=tmp_path / "study", resume=True)
    np.testing.assert_array_equal(again.runs["skill"], done.runs["skill"])
    with pytest.raises(nextview.DataError, match="resume"):
        nextview.bench(SPEC, out=tmp_path / "study")


def test_a_wrong_campaign_is_refused() -> None:
    wrongs: list[dict[Any, Any]] = [{"variants": []}, {"scan": {"live": {}}}, {3: 4}]
    for wrong in wrongs:
        with pytest.raises(nextview.InputError):
            nextview.bench({**SPEC, **wrong})
    with pytest.raises(nextview.NextviewError, match="jobs"):
        nextview.bench(SPEC, jobs=0)
    with pytest.raises(nextview.DataError):
        nextview.bench("no-such-study")


def test_an_exception_of_the_listener_ends_a_campaign() -> None:
    def fail(event: dict[str, Any]) -> None:
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        nextview.bench(SPEC, on_event=fail)
