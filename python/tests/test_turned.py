"""An object that is turned between two scans."""

from __future__ import annotations

from pathlib import Path

import nextview


def scan(scene: nextview.SimulatedScene, out: Path, **options: object) -> nextview.Scan:
    scan = nextview.Scan(
        scene.camera,
        box=scene.box_m,
        views=6,
        voxel_size_m=0.006,
        table=float(scene.room_m[0][2]),
        candidates=100,
        out=str(out),
        **options,
    )
    while (view := scan.next_view()) is not None:
        scan.observe(scene.capture(view), world_from_camera=view)
    scan.save()
    return scan


def test_a_scan_goes_on_after_its_object_was_turned(tmp_path: Path) -> None:
    on_table = {"voxel_size_m": 0.006, "object_box": {"table": "known"}, "candidates": 100}
    before = scan(nextview.SimulatedScene("builtin:mug", **on_table), tmp_path / "before")
    assert before.record["next_placement"]["down"][2] > 0.9
    after = str(tmp_path / "before")
    now = scan(nextview.SimulatedScene("builtin:mug", after=after, **on_table), tmp_path / "now", after=after)
    turn = now.record["turn"]
    assert "refusal" not in turn and turn["overlap"] > 0.5, turn
    assert len(now.cloud().points) > 1.1 * len(before.cloud().points)
