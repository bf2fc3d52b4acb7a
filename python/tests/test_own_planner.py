"""Planners and gains of one's own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import own_planners
import pytest
from conftest import ball, begin, interrupted_after, run
from own_planners import FromAbove, GainTold, OcclusionAware, Told, UnobservedVoxel

import nextview

OPTIONS: dict[str, Any] = {"views": 5, "candidates": 60, "voxel_size_m": 0.01, "baselines": False}


def views(planner: object, **options: Any) -> list[int]:
    """The views that a simulated scan takes."""
    record = nextview.scan("builtin:mug", planner=planner, **{**OPTIONS, **options}).record
    return [step["view"] for step in record["steps"]]


@pytest.mark.parametrize(
    ("own", "built_in"), [(UnobservedVoxel, "unobserved-voxel"), (OcclusionAware, "occlusion-aware")]
)
def test_a_gain_that_repeats_a_built_in_one_takes_the_same_views(own: object, built_in: str) -> None:
    assert views(own) == views(built_in)
    far = {"greedy": {"theta": 0.9, "ray_spacing": 3.0}}
    assert views(own, **far) == views(built_in, **far) != views(own)


def test_a_planner_may_be_a_class_or_its_name() -> None:
    scans = [begin(planner=planner) for planner in (FromAbove, "python:own_planners:FromAbove")]
    for scan in scans:
        run(scan)
        heights = [scan.candidates[step["view"]][2, 3] for step in scan.steps[1:]]
        assert heights == sorted(heights, reverse=True) and len(scan.steps) == 6
        assert scan.record["planner"] == "python:own_planners:FromAbove" == scan.config["planner"]
    inner = begin(planner=own_planners.Outer.Inner)
    run(inner)
    assert inner.steps[-1]["view"] == scans[0].steps[-1]["view"]


def test_a_planner_knows_the_situation() -> None:
    known: list[nextview.Situation] = []

    def answer(situation: nextview.Situation) -> tuple[np.int64, np.float64]:
        known.append(situation)
        return situation.open_views[3], np.float64(0.5)

    Told.answer = staticmethod(answer)
    scan = begin(planner=Told, views=3, seed=7)
    run(scan, 2)
    assert scan.steps[1]["score"] == 0.5 if "score" in scan.steps[1] else True
    now = known[-1]
    assert now.map.occupancy.shape == now.map.probability.shape and now.seed == 7
    assert (now.map.occupancy == nextview.Map.OCCUPIED).any()
    np.testing.assert_array_equal(now.candidates, scan.candidates)
    assert now.visited.tolist() == [0] and now.open_views.tolist() == list(range(1, 40))
    np.testing.assert_allclose(now.frame_poses[0], scan.candidates[0], atol=1e-12)
    assert now.camera == scan.camera
    view = scan.next_view()
    assert view is not None and view.number == 5 and view.score == 0.5


def test_a_gain_gets_all_rays_of_a_view_at_once() -> None:
    class Checks(nextview.Gain):
        n_views = 0

        def gain(self, situation: nextview.Situation, rays: nextview.Rays) -> float:
            type(self).n_views += 1
            state = situation.map.occupancy.ravel()
            n_rays = len(rays.ends)
            assert rays.offsets.shape == (n_rays + 1,) and rays.offsets[-1] == len(rays.voxels)
            assert rays.voxels.dtype == np.int64 and rays.visibilities.dtype == np.float32
            assert (state[rays.voxels] != nextview.Map.OCCUPIED).all()
            meets = rays.ends == nextview.Rays.OCCUPIED
            assert (state[rays.end_voxels[meets]] == nextview.Map.OCCUPIED).all()
            assert ((rays.end_voxels == -1) == ~meets).all() and (rays.end_visibilities[~meets] == 0).all()
            # Neighbours on a ray are neighbours in the map: their numbers are those of its arrays.
            index = np.stack(np.unravel_index(rays.voxels, situation.map.occupancy.shape))
            is_same_ray = np.ones(len(rays.voxels) - 1, dtype=bool)
            is_same_ray[rays.offsets[1:-1] - 1] = False
            assert (abs(np.diff(index)).sum(axis=0)[is_same_ray] == 1).all()
            # So they are where the view looks: before the camera.
            pose = situation.candidates[rays.view]
            centers = situation.map.origin_m + (index.T + 0.5) * situation.map.voxel_size_m
            assert ((centers - pose[:3, 3]) @ pose[:3, 2] > 0).all()
            return 1.0 + rays.view

    # A class needs a place in its module, to have a name.
    own_planners.Checks = Checks  # type: ignore[attr-defined]
    Checks.__qualname__, Checks.__module__ = "Checks", "own_planners"
    scan = begin(planner=Checks, views=3)
    run(scan)
    assert [step["view"] for step in scan.steps] == [0, 39, 38] and Checks.n_views == 39 + 38


def test_a_scan_is_resumed_by_a_planner_of_ones_own(tmp_path: Path) -> None:
    expected = begin(planner=UnobservedVoxel)
    run(expected)
    run(begin(planner=UnobservedVoxel, out=tmp_path / "ball"), 3)
    resumed = nextview.resume(tmp_path / "ball")
    assert len(resumed.steps) == 3
    run(resumed)
    assert [step["view"] for step in resumed.steps] == [step["view"] for step in expected.steps]


SPEC: dict[str, Any] = {
    "name": "own",
    "objects": ["builtin:mug", "builtin:teapot"],
    "seeds": [0, 1],
    "scan": {"views": 3, "candidates": 30, "voxel_size_m": 0.02},
    "variant": [
        {"scan": {"planner": "unobserved-voxel"}},
        {"sweep": {"planner": [UnobservedVoxel, "python:own_planners:Random"]}},
        {"label": "each its own", "scan": {"planner": "python:own_planners:Counts"}},
    ],
}


def test_planners_of_ones_own_appear_in_the_tables_of_a_campaign(tmp_path: Path) -> None:
    done = nextview.bench(SPEC, out=tmp_path / "study", jobs=2)
    own = "python:own_planners:UnobservedVoxel"
    names = ["each its own", own, "python:own_planners:Random", "unobserved-voxel"]
    assert sorted(set(done.runs["variant"])) == sorted(names) and not done.failed
    assert own in done.runs["config.planner"]
    assert own in (tmp_path / "study" / "runs.csv").read_text()

    def taken(variant: str) -> list[int]:
        rows = [i for i, name in enumerate(done.steps["variant"]) if name == variant]
        return [int(done.steps["view"][i]) for i in rows]

    assert taken(own) == taken("unobserved-voxel")
    # Two objects, two seeds, two planned views each.
    by_run = np.reshape(taken("python:own_planners:Random"), (4, 3))[:, 1:]
    assert len({tuple(row) for row in by_run}) == 4, "every run has a seed of its own"
    again = nextview.bench(SPEC, out=tmp_path / "study", resume=True)
    assert again.runs["variant"] == done.runs["variant"]
    spec = tmp_path / "spec.toml"
    spec.write_text('name = "x"\nobjects = ["builtin:mug"]\n[scan]\nviews = 2\ncandidates = 30\n'
                    'voxel_size_m = 0.02\nplanner = "python:own_planners:FromAbove"\n')  # fmt: skip
    assert nextview.bench(spec).runs["variant"] == ["python:own_planners:FromAbove"]


def test_a_run_that_fails_says_why_and_costs_no_other() -> None:
    names = ["python:own_planners:Raises", "random"]
    spec = {**SPEC, "seeds": [0], "variant": [{"scan": {"planner": name}} for name in names]}
    done = nextview.bench(spec)
    assert [name for name, _, _ in done.failed] == ["mug", "teapot"]
    reason = "the planner failed: Raises.plan raised ZeroDivisionError: no view at all (own_planners.py, line"
    assert done.failed[0][1].startswith(reason)
    assert done.runs["variant"].count("random") == 2


def test_an_exception_ends_the_scan_and_is_its_cause() -> None:
    with pytest.raises(nextview.InputError, match="Raises.plan raised ZeroDivisionError: no view") as raised:
        views(own_planners.Raises)
    assert isinstance(raised.value.__cause__, ZeroDivisionError)
    scan = begin(planner=own_planners.GainRaises)
    view = scan.next_view()
    assert view is not None
    scan.observe(ball(view.world_from_camera), view)
    for _ in range(2):
        with pytest.raises(nextview.InputError, match="GainRaises.gain raised LookupError: view 1") as raised:
            scan.next_view()
        assert isinstance(raised.value.__cause__, LookupError)
    assert scan.stop_reason is None and len(scan.steps) == 1
    with pytest.raises(nextview.InputError, match="'weights'") as raised:
        begin(planner=own_planners.CannotBegin)
    assert isinstance(raised.value.__cause__, TypeError)


@pytest.mark.parametrize(
    ("answer", "problem"),
    [
        ("best", "Told.plan returned 'best', of type str, expected a number of `situation.open_views`"),
        (1.5, "returned 1.5, of type float"),
        (True, "returned True, of type bool"),
        (-1, "returned -1, of type int, expected"),
        (2**80, "returned 1208925819614629174706176"),
        ((1, 2, 3), r"returned \(1, 2, 3\), of type tuple"),
        ((1, float("nan")), r"returned \(1, nan\), of type tuple"),
        ((1, "much"), "of type tuple"),
        (40, "returned view 40, but there are fewer candidates"),
        (0, "returned view 0, but it was already taken; expected one of `situation.open_views`"),
    ],
)
def test_a_wrong_view_is_named(answer: object, problem: str) -> None:
    Told.answer = answer
    with pytest.raises(nextview.InputError, match=problem):
        run(begin(planner=Told))


@pytest.mark.parametrize("answer", [None, "much", float("nan"), float("inf"), -1.0, np.ones(3), 1j])
def test_a_wrong_gain_is_named(answer: object) -> None:
    GainTold.answer = answer
    with pytest.raises(nextview.InputError, match="GainTold.gain returned .*, at least 0, for view 1"):
        run(begin(planner=GainTold))


def test_a_planner_may_be_done() -> None:
    Told.answer, GainTold.answer = None, np.float32(0)
    for planner in (Told, GainTold):
        scan = begin(planner=planner)
        run(scan)
        assert scan.stop_reason == "nothing-to-gain" and len(scan.steps) == 1


@pytest.mark.parametrize(
    ("planner", "problem"),
    [
        ("python:no_such_module:FromAbove", "No module named 'no_such_module'"),
        ("python:own_planners:Nobody", "no attribute 'Nobody'"),
        ("python:own_planners:no_class", "no_class is not a class .hint: it must be a class in an importable module"),
        ("python:own_planners:NoPlanner", "NoPlanner is neither a planner nor a gain"),
        ("python:own_planners:Unfinished", "Unfinished has no method `gain`"),
        ("python:own_planners:WrongRays", 'WrongRays.free_space is "open", expected clear or fades'),
        ("python:own_planners", "expected python:module:Class"),
        (dict, "dict is neither a planner nor a gain"),
        (FromAbove(), "of type FromAbove, expected a name, or a class: .*; pass the class, not an object of it"),
        (own_planners.no_class, "planner` is of type function, expected a name, or a class"),
        ("fastest", "expected one of most-surface"),
    ],
)
def test_what_makes_no_planner_is_refused_with_all_else_that_is_wrong(planner: Any, problem: str) -> None:
    with pytest.raises(nextview.InputError, match=problem):
        begin(planner=planner)
    if isinstance(planner, str | type):
        with pytest.raises(nextview.InputError, match=problem) as raised:
            nextview.scan("builtin:mug", planner=planner, voxel_size_m=-1.0)
        assert "`voxel_size_m` is -1" in str(raised.value)
    with pytest.raises(nextview.NextviewError, match=problem):
        nextview.bench({**SPEC, "variant": [{"scan": {"planner": planner}}]})


def test_ctrl_c_ends_a_gain_in_python_which_can_be_asked_again(mug: nextview.SimulatedScene) -> None:
    options: dict[str, Any] = {"candidates": 1500, "voxel_size_m": 0.004, "views": 3}
    scan = nextview.Scan(mug.camera, mug.box_m, planner=UnobservedVoxel, **options)
    view = scan.next_view()
    assert view is not None
    scan.observe(mug.capture(view), view)
    with interrupted_after(0.2):
        scan.next_view()
    assert scan.next_view() is not None


def test_a_class_in_a_function_has_no_name() -> None:
    class Local(FromAbove):
        pass

    with pytest.raises(nextview.InputError, match="Local is defined in a function"):
        begin(planner=Local)


def test_a_class_whose_name_another_one_took_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    class Later(FromAbove):
        pass

    Later.__qualname__, Later.__module__ = "FromAbove", "own_planners"
    monkeypatch.setattr(own_planners, "FromAbove", Later)
    with pytest.raises(nextview.InputError, match="python:own_planners:FromAbove, but that name refers"):
        begin(planner=FromAbove)
    begin(planner=Later)


@pytest.mark.parametrize("use", [lambda scan: scan.steps, repr, lambda scan: scan.next_view()])
def test_a_planner_cannot_use_the_scan_that_asks_it(use: Any) -> None:
    other = begin()

    def answer(situation: nextview.Situation) -> int:
        assert other.steps == []
        use(scan)
        return int(situation.open_views[0])

    Told.answer = staticmethod(answer)
    scan = begin(planner=Told)
    run(scan, 1)
    with pytest.raises(nextview.InputError, match="a planner cannot use the scan that asks it") as raised:
        scan.next_view()
    assert isinstance(raised.value.__cause__, nextview.InputError)
    Told.answer = 3
    assert scan.next_view() is not None
