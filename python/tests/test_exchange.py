"""Maps as OctoMap files, and values that are pickled."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
from conftest import CAMERA, ball, begin, run

import nextview


@pytest.fixture(scope="module")
def scanned() -> nextview.Scan:
    """A scan of the ball."""
    scan = begin(planner="most-surface")
    run(scan)
    return scan


def states(grid: nextview.Map) -> dict[bytes, int]:
    """The measured voxels by place."""
    keys = np.round(grid.origin_m / grid.voxel_size_m).astype(int) + np.argwhere(grid.occupancy > 0)
    values = grid.occupancy[grid.occupancy > 0]
    return {key.tobytes(): int(value) for key, value in zip(keys, values, strict=True)}


def test_a_map_is_written_and_read(scanned: nextview.Scan, tmp_path: Path) -> None:
    grid = scanned.map
    assert grid is not None
    for extension in ("ot", "bt"):
        path = tmp_path / f"map.{extension}"
        grid.save(path)
        read = nextview.Map.load(path)
        assert read.voxel_size_m == grid.voxel_size_m and states(read) == states(grid)
        with pytest.raises(nextview.DataError, match="exists"):
            grid.save(path)
        grid.save(path, force=True)
    precise = nextview.Map.load(tmp_path / "map.ot")
    for state in (grid.FREE, grid.OCCUPIED):
        expected = np.sort(grid.probability[grid.occupancy == state])
        found = np.sort(precise.probability[precise.occupancy == state])
        np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_the_map_of_the_results_is_that_of_the_scan(scanned: nextview.Scan, tmp_path: Path) -> None:
    scanned.save(tmp_path / "ball")
    assert scanned.map is not None
    for name in ("map.ot", "map.bt"):
        assert states(nextview.Map.load(tmp_path / "ball" / name)) == states(scanned.map)


def test_a_wrong_map_is_refused(tmp_path: Path) -> None:
    grid = np.full((2, 3, 4), 2, dtype=np.uint8)
    p = np.full(grid.shape, 0.7, dtype=np.float32)

    def save(name: str = "map.ot", **changed: object) -> None:
        given = {"occupancy": grid, "probability": p, "origin_m": np.zeros(3), "voxel_size_m": 0.1}
        nextview.Map(**{**given, **changed}).save(tmp_path / name)  # type: ignore[arg-type]

    wrongs: list[tuple[str, dict[str, object]]] = [
        ("expected multiples of the voxel size", {"origin_m": np.array([0.05, 0, 0])}),
        ("expected multiples of the voxel size", {"origin_m": np.array([np.nan, 0, 0])}),
        ("voxel_size_m is 0, expected", {"voxel_size_m": 0.0}),
        ("`probability` is 1, expected above 0 and below 1", {"probability": p / 0.7}),
        ("have the shapes", {"probability": p[1:]}),
        ("expected a grid of X x Y x Z of float32", {"probability": p.astype(float)}),
        ("expected a grid of X x Y x Z of uint8", {"occupancy": [1]}),
        ("expected a name that ends in .ot or .bt", {"name": "map.ply"}),
    ]
    for message, changed in wrongs:
        with pytest.raises(nextview.InputError, match=message):
            save(**changed)  # type: ignore[arg-type]
    save()
    assert (nextview.Map.load(tmp_path / "map.ot").occupancy == 2).all()
    (tmp_path / "text.ot").write_text("no map")
    for path in ("text.ot", "missing.ot"):
        with pytest.raises(nextview.DataError, match=path):
            nextview.Map.load(tmp_path / path)
    save("empty.ot", occupancy=np.zeros_like(grid))
    with pytest.raises(nextview.DataError, match="contains no measured voxel"):
        nextview.Map.load(tmp_path / "empty.ot")
    far = np.zeros((60_000, 2, 1), dtype=np.uint8)
    far[0, 0, 0] = far[-1, 1, 0] = 2
    save("thin.ot", occupancy=far, probability=np.full(far.shape, 0.7, np.float32))
    assert nextview.Map.load(tmp_path / "thin.ot").occupancy.shape == far.shape


def test_views_cameras_and_results_are_pickled(tmp_path: Path) -> None:
    scan, other = begin(planner="most-surface"), begin(planner="most-surface")
    for _ in range(2):
        view = scan.next_view()
        assert view is not None and other.next_view() is not None
        same = pickle.loads(pickle.dumps(view))
        assert (same.number, same.score, same.explanation) == (view.number, view.score, view.explanation)
        assert same.estimated_completeness == view.estimated_completeness
        np.testing.assert_array_equal(same.waypoints, view.waypoints)
        np.testing.assert_array_equal(same.waypoint_times_s, view.waypoint_times_s)
        assert same.trajectory_length_m == view.trajectory_length_m
        scan.observe(ball(view.world_from_camera), view)
        other.observe(ball(view.world_from_camera), same)
    # The pose has all its bits.
    assert scan.steps[-1]["position_m"] == other.steps[-1]["position_m"]
    assert scan.steps[-1]["quaternion_xyzw"] == other.steps[-1]["quaternion_xyzw"]
    assert pickle.loads(pickle.dumps(CAMERA)) == copy.deepcopy(CAMERA) == CAMERA
    done = nextview.scan("builtin:mug", views=2, voxel_size_m=0.02, candidates=20, baselines=False)
    read = pickle.loads(pickle.dumps(done))
    assert read.record == done.record and done.cloud is not None
    np.testing.assert_array_equal(read.cloud.points, done.cloud.points)
    with pytest.raises(nextview.InputError, match="was pickled, which drops its frames"):
        read.show()


def test_a_notebook_shows_a_scan(scanned: nextview.Scan) -> None:
    begun = begin()
    done = nextview.scan("builtin:mug", views=2, voxel_size_m=0.02, candidates=20, baselines=False)
    for page in (begun.show(), scanned.show(), done.show()):
        cell = page._repr_html_()
        assert cell.startswith("<iframe srcdoc=") and cell.count('"') == 4
        assert page.html.startswith("<!DOCTYPE html>") or page.html.startswith("<!doctype html>")
    assert "under way" in begun.show().html
