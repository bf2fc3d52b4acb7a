"""A scan by your own camera."""

from __future__ import annotations

import os
import pickle
import threading
from pathlib import Path

import numpy as np
import pytest
from conftest import BOX, CAMERA, ball, begin, run

import nextview


def test_a_ball_is_scanned() -> None:
    scan = begin()
    run(scan)
    assert scan.stop_reason is not None and len(scan.steps) == scan.record["views"]
    cloud, mesh, grid = scan.cloud(), scan.mesh(), scan.map
    assert np.abs(np.linalg.norm(cloud.points, axis=1) - 0.1).max() < 1e-3
    assert cloud.colors is not None and (cloud.colors == [200, 10, 20]).all()
    assert mesh.triangles.dtype == np.uint32 and mesh.triangles.max() < len(mesh.vertices)
    assert grid is not None and (grid.occupancy == grid.OCCUPIED).sum() == scan.steps[-1]["occupied_voxels"]
    occupied = np.linalg.norm(grid.centers(), axis=1)
    assert np.abs(occupied - 0.1).max() < 0.02
    outside = grid.probability[grid.occupancy == grid.UNKNOWN]
    assert (outside == 0.5).all()


def test_a_view_says_where_why_and_how() -> None:
    scan = begin(planner="most-surface")
    first = scan.next_view()
    assert first is not None and (first.number, first.score, first.runner_up) == (0, None, None)
    scan.observe(ball(first.world_from_camera), first)
    view, again = scan.next_view(), scan.next_view()
    assert view is not None and again is not None and view.number == again.number
    assert view.world_from_camera.dtype == np.float64 and view.world_from_camera.shape == (4, 4)
    assert view.number is not None
    np.testing.assert_array_equal(scan.candidates[view.number], view.world_from_camera)
    assert view.score is not None and view.score > 0 and view.explanation
    assert view.expected_new_voxels is not None and view.expected_unseen_voxels is not None
    forecast = view.forecast_completeness
    assert forecast is not None and len(forecast) == 5 and forecast == sorted(forecast)
    assert view.estimated_completeness is not None and view.estimated_completeness < forecast[0]
    assert scan.completeness == view.estimated_completeness
    assert view.waypoints.shape == (len(view.waypoint_times_s), 4, 4)
    np.testing.assert_allclose(view.waypoints[-1], view.world_from_camera)
    assert (np.diff(view.waypoint_times_s) > 0).all() and view.trajectory_length_m > 0


def test_every_layout_and_unit_gives_the_same_map() -> None:
    def occupied(change: str) -> list[int]:
        scan = begin(views=3)
        while (view := scan.next_view()) is not None:
            depth = ball(view.world_from_camera)
            units = np.where(np.isinf(depth), 0, np.round(depth * 1e4)).astype(np.uint16)
            metres = (units * 1e-4).astype(np.float32)
            mask = np.zeros(depth.shape, dtype=bool)
            if change == "units":
                scan.observe(units, view, depth_scale_m=1e-4)
            elif change == "fortran":
                scan.observe(np.asfortranarray(metres), view, mask=mask)
            elif change == "strided":
                scan.observe(np.repeat(metres, 2, axis=1)[:, ::2], view.world_from_camera)
            elif change == "mask":
                noisy = metres.copy()
                noisy[:10], mask[:10] = 0.2, True
                scan.observe(noisy, view, mask=mask)
            else:
                readonly = metres.copy()
                readonly.flags.writeable = False
                scan.observe(readonly, view)
        return [step["hit_voxels"] for step in scan.steps]

    expected = occupied("nothing")
    for change in ["units", "fortran", "strided"]:
        assert occupied(change) == expected
    assert occupied("mask")[0] <= expected[0]


def test_a_matrix_and_its_view_are_the_same_place(mug: nextview.SimulatedScene) -> None:
    scan = begin()
    view = scan.next_view()
    assert view is not None
    step = scan.observe(ball(view.world_from_camera), view.world_from_camera)
    np.testing.assert_allclose(step["position_m"], view.world_from_camera[:3, 3], atol=1e-12)


def test_frames_can_be_had_again() -> None:
    scan = begin()
    with pytest.raises(nextview.InputError, match="a frame to be taken first"):
        scan.frame(0)
    first = scan.next_view()
    assert first is not None
    depth = ball(first.world_from_camera)
    scan.observe(depth, first)
    kept, pose = scan.frame(0)
    is_measured = np.isfinite(depth) & (depth > 0)
    np.testing.assert_array_equal(kept[is_measured], depth[is_measured])
    np.testing.assert_allclose(pose, first.world_from_camera, atol=1e-15)
    with pytest.raises(nextview.InputError, match="`step_idx` is 1, expected 0 to 0"):
        scan.frame(1)


def test_a_skipped_view_never_comes_again() -> None:
    scan = begin()
    seen = set()
    for _ in range(5):
        view = scan.next_view()
        assert view is not None and view.number is not None and view.number not in seen
        seen.add(view.number)
        scan.skip(view.number, "a test")
    with pytest.raises(nextview.InputError, match="`view` is 40, expected 0 to 39"):
        scan.skip(40)


def test_an_interrupted_scan_is_resumed(tmp_path: Path) -> None:
    undisturbed = begin()
    run(undisturbed)
    for n_steps in (1, 3):
        out = tmp_path / str(n_steps)
        scan = begin(out=out)
        run(scan, n_steps)
        scan.save()
        with pytest.raises(nextview.DataError, match="is in use by a running scan"):
            begin(out=out, force=True)
        del scan
        with pytest.raises(nextview.DataError, match="holds an interrupted scan"):
            begin(out=out, force=True)
        scan = nextview.resume(out)
        assert len(scan.steps) == n_steps and scan.camera == CAMERA
        run(scan)
        assert [step["view"] for step in scan.steps] == [step["view"] for step in undisturbed.steps]
        ours, theirs = scan.cloud(), undisturbed.cloud()
        np.testing.assert_array_equal(ours.points, theirs.points)
        assert ours.colors is not None and theirs.colors is not None
        np.testing.assert_array_equal(ours.colors, theirs.colors)
        scan.save()
        assert not (out / "scan.journal").exists() and (out / "report.html").exists()
        with pytest.raises(nextview.DataError, match="holds no interrupted scan"):
            nextview.resume(out)
        with pytest.raises(nextview.DataError, match="already holds results"):
            undisturbed.save(out)
        undisturbed.save(out, force=True)


def test_a_finished_scan_that_is_saved_takes_no_more_frames(tmp_path: Path) -> None:
    scan = begin(views=2, out=tmp_path / "own")
    first = scan.next_view()
    assert first is not None
    scan.observe(ball(first.world_from_camera), first)
    scan.save()  # not finished yet
    run(scan)
    assert scan.stop_reason is not None and len(scan.steps) == 2
    scan.save()
    with pytest.raises(nextview.InputError, match="the scan is finished and saved, and accepts no more frames"):
        scan.observe(ball(first.world_from_camera), first)
    assert len(scan.steps) == 2 and scan.next_view() is None
    scan.save()


def test_lost_frames_of_a_resumed_scan_are_warned_of(tmp_path: Path) -> None:
    run(begin(out=tmp_path), 2)
    journal = tmp_path / "scan.journal"
    content = bytearray(journal.read_bytes())
    content[-1] ^= 1
    journal.write_bytes(content)
    with pytest.warns(UserWarning, match="scan.journal: damaged from byte .* are now in .*damaged-1"):
        scan = nextview.resume(tmp_path)
    assert len(scan.steps) == 1 and (tmp_path / "scan.journal.damaged-1").exists()


def test_a_folder_stays_the_scans_where_the_program_changes_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    scan = begin(out="scan")
    run(scan, 1)
    os.chdir("elsewhere")
    scan.save()
    del scan
    os.chdir(tmp_path)
    scan = nextview.resume("scan")
    os.chdir("elsewhere")
    scan.save()
    assert (tmp_path / "scan" / "report.html").exists() and os.listdir() == []


def test_nothing_but_the_first_pose_need_be_known() -> None:
    sim = nextview.SimulatedScene("builtin:mug", object_box={"table": "known"}, voxel_size_m=0.01)
    scan = nextview.Scan(sim.camera, first_pose=sim.candidates[0], table="fit", views=4, voxel_size_m=0.01)
    assert scan.map is None
    with pytest.raises(nextview.DataError, match="no object"):
        scan.cloud()
    while (view := scan.next_view()) is not None:
        scan.observe(sim.capture(view), view)
    assert scan.record["box_rule"] == "grows" and scan.steps[-1]["occupied_voxels"] > 100
    height = scan.steps[-1]["table_offset_m"] / scan.steps[-1]["table_normal"][2]
    assert abs(height - sim.room_m[0][2]) < 0.002


def test_poses_of_ones_own_are_the_candidates(mug: nextview.SimulatedScene) -> None:
    scan = nextview.Scan(mug.camera, mug.box_m, poses=mug.candidates, voxel_size_m=0.01, views=2)
    np.testing.assert_allclose(scan.candidates, mug.candidates, atol=1e-12)


def test_scans_in_two_threads_do_not_mix() -> None:
    scans = [begin(), begin(planner="rse")]
    threads = [threading.Thread(target=run, args=(scan,)) for scan in scans]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for scan, planner in zip(scans, ["max-flow", "rse"], strict=True):
        alone = begin(planner=planner)
        run(alone)
        assert [step["view"] for step in scan.steps] == [step["view"] for step in alone.steps]


def test_what_is_plain_can_be_pickled() -> None:
    scan = begin()
    run(scan, 2)
    assert pickle.loads(pickle.dumps(scan.record))["views"] == 2
    assert pickle.loads(pickle.dumps(scan.config)) == scan.config
    assert pickle.loads(pickle.dumps(CAMERA)) == CAMERA
    d405 = nextview.Camera.sensor("d405")
    assert pickle.loads(pickle.dumps(d405)) == d405 != CAMERA and "width=848" in repr(d405)


def test_a_configuration_repeats_a_scan() -> None:
    scan = begin(stop={"entropy_share": 0.5}, reach={"base_m": [0.0, 0.0, 0.0], "max_radius_m": 5.0})
    assert scan.config["stop"]["entropy_share"] == 0.5 and scan.config["live"]["box_m"] == sum(BOX, [])


def test_an_arm_gets_joints_to_every_view() -> None:
    base = np.eye(4)
    base[:3, 3] = [-0.6, 0.0, -0.3]
    scan = begin(robot={"arm": "ur5e", "world_from_base": base}, views=3)
    seen = []
    while (view := scan.next_view()) is not None:
        assert view.joint_names is not None and len(view.joint_names) == 6
        assert view.joint_values is not None and view.joint_values.shape == (len(view.waypoint_times_s), 6)
        again = pickle.loads(pickle.dumps(view))
        assert (again.joint_values == view.joint_values).all()
        step = scan.observe(ball(view.world_from_camera), view)
        assert step["joint_values"] == list(view.joint_values[-1])
        seen.append(view.number)
    assert len(seen) == 3 and len(scan.candidates) < 1000


def test_poses_in_options_are_checked() -> None:
    with pytest.raises(nextview.InputError, match="world_from_base"):
        begin(robot={"arm": "ur5e", "world_from_base": np.zeros((4, 4))})
    with pytest.raises(nextview.InputError, match="ring"):
        begin(turntable={"table_from_camera": np.eye(4), "plate_radius_m": 0.1})
