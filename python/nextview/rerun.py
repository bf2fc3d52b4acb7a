"""Scans for the Rerun viewer (extra `rerun`).

`nextview.rerun.log(scan, "scan.rrd")` writes a recording, and `nextview.rerun.log(scan)` logs to the one that
`rerun.init` began. `python -m nextview.rerun DIR --out FILE.rrd` turns a folder of results into a recording,
without depth images, candidates and earlier maps.

The timeline `view` counts views from 1. At each of them there are, in metres: the map as it was then, the
camera with its depth image and some of its rays, the views so far, the view candidates, and curves. Cloud and
mesh are there at the last one. The colours of the candidates, from blue to yellow, are their order by gain at
that time: the entropy of the visible unobserved voxels, whatever the planner's own gain is. The orange one is
taken next.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nextview import _native
from nextview._model import Cloud, Map, Mesh
from nextview._ply import read_cloud, read_mesh
from nextview._scan import Scan
from nextview._simulated import ScanResult
from nextview.errors import DataError, InputError, NextviewError

try:
    import rerun as rr
    import rerun.blueprint as rrb
except ImportError as missing:
    raise ImportError("the package rerun-sdk is not installed: pip install 'nextview[rerun]'") from missing

CURVES = {
    "reachable_coverage": [60, 140, 255],
    "estimated_completeness": [66, 190, 110],
    "entropy_share": [170, 170, 180],
}
"""Quantities of a step, shares from 0 to 1, that are drawn as curves, and their colours."""

_CHOSEN = [255, 120, 20]


def log(scan: Scan | ScanResult, out: str | os.PathLike[str] | None = None) -> None:
    """Logs all views of a scan so far to a file, or to the recording that `rerun.init` began.

    Raises `InputError` for a result that was pickled, which has no frames.
    """
    if isinstance(scan, Scan):
        has_object = scan.map is not None
        cloud, mesh = (scan.cloud(), scan.mesh()) if has_object else (None, None)
        engine: _native.LiveScan | _native.Finished = scan._engine
    else:
        cloud, mesh, engine = scan.cloud, scan.mesh, scan._finished()
    moments = {step_idx: (occupied, gains) for step_idx, occupied, gains in engine.moments()}
    candidates = engine.candidates()[:, :3, 3]
    _log(_Story(scan.record, scan.config, cloud, mesh, candidates, moments, engine.frame), out)


def log_folder(folder: str | os.PathLike[str], out: str | os.PathLike[str] | None = None) -> None:
    """Logs the results in a folder: the views, the final map, cloud and mesh, and curves.

    Raises `DataError` if the folder holds no results.
    """
    path = Path(folder)
    try:
        record = json.loads((path / "record.json").read_text())
    except (OSError, ValueError) as error:
        raise DataError(f"{path}: {error}; expected the folder of a scan's results") from error
    config = _native.read_config(path / "config.toml")
    has_object = (path / "cloud.ply").exists()
    cloud = read_cloud(path / "cloud.ply") if has_object else None
    mesh = read_mesh(path / "mesh.ply") if has_object else None
    moments = {}
    if has_object and record["steps"]:
        grid = Map.load(path / "map.ot")
        moments[len(record["steps"]) - 1] = (grid.centers().astype(np.float32), None)
    _log(_Story(record, config, cloud, mesh, None, moments, None), out)


@dataclass(frozen=True)
class _Story:
    """The data to show."""

    record: dict[str, Any]
    config: dict[str, Any]
    cloud: Cloud | None
    mesh: Mesh | None
    candidates: NDArray[np.float64] | None
    moments: Mapping[int, tuple[NDArray[np.float32], NDArray[np.float64] | None]]
    frame: Callable[[int], tuple[NDArray[np.float32], NDArray[np.float64]]] | None


def _log(story: _Story, out: str | os.PathLike[str] | None) -> None:
    if out is None:
        recording = rr.get_global_data_recording()
        if recording is None:
            raise InputError("`out` is missing, expected a file, or a recording that `rerun.init` began")
    else:
        recording = rr.RecordingStream(f"nextview: {story.record['object']}")
        recording.save(os.fspath(out))
    recording.send_blueprint(_blueprint(has_frames=story.frame is not None))
    recording.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    for name, color in CURVES.items():
        line = rr.SeriesLines(names=name.replace("_", " "), colors=color)
        recording.log(f"curves/{name}", line, static=True)
    for step_idx, step in enumerate(story.record["steps"]):
        recording.set_time("view", sequence=step_idx + 1)
        _log_camera(recording, story, step_idx)
        if step_idx in story.moments:
            _log_knowledge(recording, story, step_idx)
        for name in CURVES:
            if step.get(name) is not None:
                recording.log(f"curves/{name}", rr.Scalars(step[name]))
    _log_model(recording, story)
    if out is not None:
        recording.disconnect()


def _blueprint(*, has_frames: bool) -> rrb.Blueprint:
    # In space, the points of the depth image would hide the map, and the mesh the cloud.
    hidden = rrb.EntityBehavior(visible=False)
    space = rrb.Spatial3DView(
        origin="world", name="Scan", overrides={"world/camera/depth": hidden, "world/mesh": hidden}
    )
    curves = rrb.TimeSeriesView(origin="curves", name="Curves")
    depth = [rrb.Spatial2DView(origin="world/camera", name="Depth")] if has_frames else []
    views = rrb.Horizontal(space, rrb.Vertical(*depth, curves), column_shares=[2, 1])
    return rrb.Blueprint(views, collapse_panels=True)


def _log_camera(recording: rr.RecordingStream, story: _Story, step_idx: int) -> None:
    steps, camera = story.record["steps"], story.config["camera"]
    step = steps[step_idx]
    pose = rr.Transform3D(
        translation=step["position_m"], quaternion=rr.Quaternion(xyzw=step["quaternion_xyzw"])
    )
    size = 0.3 * float(np.linalg.norm(np.ptp([each["position_m"] for each in steps], axis=0))) or 0.1

    def frustum(size_m: float, color: Sequence[int]) -> rr.Pinhole:
        return rr.Pinhole(
            focal_length=[camera["fx"], camera["fy"]],
            principal_point=[camera["cx"], camera["cy"]],
            resolution=[camera["width"], camera["height"]],
            camera_xyz=rr.ViewCoordinates.RDF,
            image_plane_distance=size_m,
            color=color,
        )

    recording.log("world/camera", pose, frustum(0.3 * size, _CHOSEN))
    recording.log(f"world/views/{step_idx + 1}", pose, frustum(0.15 * size, [110, 110, 120]))
    path = [each["position_m"] for each in steps[: step_idx + 1]]
    line = rr.LineStrips3D([path], colors=[110, 110, 120], radii=rr.Radius.ui_points(1.0))
    recording.log("world/path", line)
    if story.frame is not None:
        depth, world_from_camera = story.frame(step_idx)
        measured = np.where(np.isfinite(depth), depth, 0)
        recording.log("world/camera/depth", rr.DepthImage(measured, meter=1.0))
        recording.log("world/rays", _rays(measured, world_from_camera, camera, step))


def _rays(
    depth: NDArray[np.float32],
    world_from_camera: NDArray[np.float64],
    camera: dict[str, Any],
    step: dict[str, Any],
) -> rr.LineStrips3D:
    """Some rays of the camera to the surface that they met in the box, without the distortion of the lens."""
    pitch = max(depth.shape[0] // 24, 1)
    v, u = np.mgrid[pitch // 2 : depth.shape[0] : pitch, pitch // 2 : depth.shape[1] : pitch]
    z = depth[v, u].astype(np.float64)
    x, y = (u - camera["cx"]) / camera["fx"] * z, (v - camera["cy"]) / camera["fy"] * z
    ends = np.stack([x, y, z], axis=-1)[z > 0] @ world_from_camera[:3, :3].T + world_from_camera[:3, 3]
    if "box_min_m" in step:
        ends = ends[((ends > step["box_min_m"]) & (ends < step["box_max_m"])).all(axis=1)]
    strips = np.stack([np.broadcast_to(world_from_camera[:3, 3], ends.shape), ends], axis=1)
    return rr.LineStrips3D(strips, colors=[*_CHOSEN, 90], radii=rr.Radius.ui_points(0.4))


def _log_knowledge(recording: rr.RecordingStream, story: _Story, step_idx: int) -> None:
    occupied, gains = story.moments[step_idx]
    steps = story.record["steps"]
    half = np.full((len(occupied), 3), 0.5 * story.record["voxel_size_m"], dtype=np.float32)
    heights = _shares(occupied[:, 2])
    recording.log(
        "world/map", rr.Boxes3D(centers=occupied, half_sizes=half, colors=_colors(heights), fill_mode="solid")
    )
    if gains is None or story.candidates is None:
        return
    colors = _colors(_shares(np.argsort(np.argsort(gains, kind="stable"))))
    radii = np.full(len(colors), 0.004 * float(np.ptp(story.candidates, axis=0).max()))
    next_view = steps[step_idx + 1].get("view") if step_idx + 1 < len(steps) else None
    if next_view is not None:
        colors[next_view], radii[next_view] = _CHOSEN, 2.5 * radii[next_view]
    recording.log("world/candidates", rr.Points3D(story.candidates, colors=colors, radii=radii))


def _log_model(recording: rr.RecordingStream, story: _Story) -> None:
    cloud, mesh = story.cloud, story.mesh
    if cloud is not None:
        colors = _colors(_shares(cloud.points[:, 2])) if cloud.colors is None else cloud.colors
        recording.log("world/cloud", rr.Points3D(cloud.points, colors=colors))
    if mesh is not None:
        recording.log(
            "world/mesh",
            rr.Mesh3D(
                vertex_positions=mesh.vertices,
                triangle_indices=mesh.triangles,
                vertex_normals=mesh.normals,
                vertex_colors=mesh.colors,
            ),
        )


def _shares(values: NDArray[Any]) -> NDArray[np.float64]:
    """The values from 0, the least, to 1, the largest."""
    numbers = np.asarray(values, dtype=np.float64)
    if numbers.size == 0:
        return numbers
    shares: NDArray[np.float64] = (numbers - numbers.min()) / max(float(np.ptp(numbers)), 1e-12)
    return shares


def _colors(shares: NDArray[np.float64]) -> NDArray[np.uint8]:
    """From dark blue over green to yellow."""
    stops = np.array([[49, 37, 110], [33, 122, 140], [66, 180, 110], [250, 230, 60]], dtype=np.float64)
    places = np.linspace(0, 1, len(stops))
    channels = [np.interp(shares, places, stops[:, i]) for i in range(3)]
    return np.stack(channels, axis=-1).astype(np.uint8)


def _main() -> None:
    parser = argparse.ArgumentParser(prog="python -m nextview.rerun", description=log_folder.__doc__)
    parser.add_argument("folder", metavar="DIR", help="the results of a scan")
    parser.add_argument("--out", required=True, metavar="FILE.rrd", help="the recording to write")
    args = parser.parse_args()
    try:
        log_folder(args.folder, args.out)
    except NextviewError as error:
        parser.exit(1, f"error: {error}\n")


if __name__ == "__main__":
    _main()
