"""A scan by your own camera."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nextview import _native
from nextview._camera import Camera
from nextview._lists import listed
from nextview._model import Cloud, Map, Mesh, cloud_of, map_of, mesh_of
from nextview._page import Page
from nextview._planner import Gain, Planner
from nextview.errors import InputError

Pose = NDArray[np.float64] | _native.View
"""The pose of a camera: a 4 x 4 array of float64, or a `View`."""


class Scan:
    """A scan of an unknown object by your own camera.

    It never drives a camera: ask for the `next_view`, take a depth image there, and let the scan `observe`
    it.

    - `camera`: the depth camera.
    - `box`: where the object is: its lowest and its highest corner, metres. Without it, the box grows from
      the first image, which must then show some of the object.
    - `first_pose`: the pose of the first view, needed where the box grows and `poses` are not given: for
      example where the camera is now.
    - `poses`: the view candidates; by default a rule makes `candidates` of them around the object:
      `view_space`, "shell", "sphere", "hemisphere" or "ring".
    - `planner`: one of `nextview.planners`, or one of your own: a subclass of `nextview.Planner` or
      `nextview.Gain`, or its name "python:module:Class".
    - `views`: the maximum number of views; by default 10.
    - `voxel_size_m`: edge of a voxel; by default about a fortieth of the longest side of the box, rounded
      to 1, 2 or 5 times a power of ten; 0.005 where the box grows.
    - `table`: what the object stands on: "none", "fit" (it is found in the first image), or its height z,
      metres.
    - `name`: of the object, for records and reports.
    - `out`: a folder. Every frame is on the disk there before it counts; after an interruption,
      `nextview.resume` resumes the scan. `save` writes the results there. If it holds results of another
      scan, `force` must be true, which replaces them.
    - `after`: the folder with the results of an earlier scan of the same object, which has been turned since,
      as their `record.next_placement` requests. As soon as the turn is found, the frames of that scan are
      added to map and model. Both scans need a `table`.
    - `options`: any other key of a configuration, such as `registration={"enabled": True}`,
      `stop={"completeness": 0.98}`, or `robot={"arm": "ur5e", "world_from_base": pose}`. Poses are 4 x 4
      arrays of float64.

    Raises `InputError` if a value is invalid, and `DataError` if the folder cannot be used.

    One object serves one scan. Calls from several threads take turns; several scans can run in parallel.

    >>> import nextview
    >>> sim = nextview.SimulatedScene("builtin:mug", voxel_size_m=0.01)
    >>> scan = nextview.Scan(sim.camera, box=sim.box_m, views=3, voxel_size_m=0.01)
    >>> while (view := scan.next_view()) is not None:
    ...     step = scan.observe(sim.capture(view), world_from_camera=view)
    >>> len(scan.steps), scan.stop_reason
    (3, 'view-limit')
    """

    _engine: _native.LiveScan
    _out: str | None
    _force: bool
    _completeness: float | None
    _model: tuple[int, Cloud, Mesh] | None

    def __init__(
        self,
        camera: Camera,
        box: Sequence[Sequence[float]] | NDArray[np.float64] | None = None,
        *,
        first_pose: Pose | None = None,
        poses: Iterable[Pose] | None = None,
        planner: str | type[Planner] | type[Gain] = "most-surface",
        views: int | None = None,
        voxel_size_m: float | None = None,
        table: str | float = "none",
        name: str = "object",
        out: str | os.PathLike[str] | None = None,
        force: bool = False,
        **options: Any,
    ) -> None:
        """Begins a scan; nothing is observed yet."""
        if not isinstance(camera, Camera):
            raise InputError(f"`camera` is of type {type(camera).__name__}, expected nextview.Camera")
        for key, instead in _ARGUMENTS.items():
            if options.get(key) is not None:
                raise InputError(f"`{key}` is not an option of a scan by your own camera, use {instead}")
        live: dict[str, Any] = {}
        given_box = options.pop("object_box", None)
        if not isinstance(given_box, dict | None):
            raise InputError(f"`object_box` is of type {type(given_box).__name__}, expected a dict")
        # Its own entries, whatever a subclass has.
        object_box = {} if given_box is None else dict(dict.items(given_box))
        if object_box.get("table") is not None:
            raise InputError("`object_box.table` is not an option of a scan by your own camera, use `table`")
        if isinstance(table, str):
            object_box["table"] = table
        else:
            live["table_z_m"] = table
        given = {"planner": planner, "views": views, "voxel_size_m": voxel_size_m, "object": name}
        config = {**options, **given, "live": live, "object_box": object_box}
        candidates = None if poses is None else listed("poses", poses)
        # A program may change its folder while it scans.
        path = None if out is None else os.path.abspath(out)
        engine = _native.LiveScan(config, camera, box, first_pose, candidates, path, force)
        self._begin(engine, path, force)

    def _begin(self, scan: _native.LiveScan, out: str | None, force: bool) -> None:
        self._engine, self._out, self._force = scan, out, force
        self._completeness, self._model = None, None

    def next_view(self) -> _native.View | None:
        """The view to take next; None if the scan is over, see `stop_reason`.

        Further calls return the same view until a frame is observed or a view is skipped. Ctrl-C ends the
        computation, which can then be repeated.
        """
        view = self._engine.next_view()
        if view is not None and view.estimated_completeness is not None:
            self._completeness = view.estimated_completeness
        return view

    def turntable_pose(self, angle_deg: float) -> NDArray[np.float64]:
        """Where the camera is, seen from the object, after the plate was turned by this angle: 4 x 4 float64.

        Raises `InputError` without a turntable.
        """
        return self._engine.turntable_pose(angle_deg)

    def observe(
        self,
        depth: NDArray[np.float32] | NDArray[np.uint16],
        world_from_camera: Pose | None,
        color: NDArray[np.uint8] | None = None,
        *,
        depth_scale_m: float | None = None,
        mask: NDArray[np.bool_] | None = None,
    ) -> dict[str, Any]:
        """Adds a depth image; the requested view counts as taken. Returns the step's record.

        - `depth`: height x width; float32 in metres, where 0, negative numbers and NaN mean "not measured"
          and infinity means "nothing there"; or uint16 in units of `depth_scale_m`, where 0 means "not
          measured".
        - `world_from_camera`: where the camera truly was, 4 x 4 float64; or the view, if it was there
          exactly. A rotation may be off by 1e-3. None if it is unknown: it is then found as by `locate`.
        - `color`: height x width x 3, uint8, aligned with the depth image; for cloud and mesh.
        - `mask`: height x width, bool; pixels where it is true count as not measured.

        Arrays of any memory layout are accepted. A scan keeps its frames, so that depths are copied once.
        """
        return self._engine.observe(depth, world_from_camera, color, depth_scale_m, mask)

    def locate(
        self,
        depth: NDArray[np.float32] | NDArray[np.uint16],
        *,
        depth_scale_m: float | None = None,
        mask: NDArray[np.bool_] | None = None,
    ) -> Pose:
        """Returns where a depth image was taken, by the surface known so far. The image is not added.

        For hand-held cameras: the camera must have moved by no more than some centimetres and degrees since
        the last image. The scan must have been created with `registration={"enabled": True, "given_poses":
        "tracked"}`. Raises an error if the camera is lost.
        """
        return self._engine.locate(depth, depth_scale_m, mask)

    def guidance(self, world_from_camera: Pose) -> dict[str, Any] | None:
        """How to move the camera from this pose to the next view, or None if the scan is over.

        `arrow_m` leads to the view, in the frame of the camera (right, down, forward), and is `distance_m`
        long; `turn_deg` says how far to turn right and then down, `angle_deg` how far off the camera looks,
        and `reached` whether it is near enough.
        """
        return self._engine.guidance(world_from_camera)

    def skip(self, view: int, reason: str = "out of reach") -> None:
        """Excludes this candidate for the rest of the scan, for example because the robot cannot go there."""
        self._engine.skip(view, reason)

    @property
    def record(self) -> dict[str, Any]:
        """Everything about the scan so far: what `record.json` holds."""
        return self._engine.record()

    @property
    def steps(self) -> list[dict[str, Any]]:
        """The record of each frame so far: what `steps.jsonl` holds."""
        return self._engine.steps()

    def frame(self, step_idx: int) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
        """The depth image of a step, counted from 0, and its pose: the aligned one where frames are aligned.
        Depths are height x width, float32, metres; NaN where nothing was measured."""
        return self._engine.frame(step_idx)

    @property
    def stop_reason(self) -> str | None:
        """Why the scan is over, such as "view-limit"; None while it is under way."""
        return self._engine.stop_reason()

    @property
    def completeness(self) -> float | None:
        """Estimated share, 0 to 1, of the visible surface that was seen when the last view was chosen; None
        before, or if the planner does not estimate it."""
        return self._completeness

    @property
    def config(self) -> dict[str, Any]:
        """Everything that decides the scan: what `config.toml` holds."""
        return self._engine.config()

    @property
    def camera(self) -> Camera:
        """The camera."""
        return Camera(*self._engine.camera())

    @property
    def candidates(self) -> NDArray[np.float64]:
        """Poses of the current view candidates: N x 4 x 4, `world_from_camera`."""
        return self._engine.candidates()

    @property
    def map(self) -> Map | None:
        """The occupancy of the box around the object; None before an object was found."""
        arrays = self._engine.map()
        return None if arrays is None else map_of(arrays)

    def cloud(self) -> Cloud:
        """The measured points. Raises `DataError` if no object was found yet."""
        return self._models()[1]

    def mesh(self) -> Mesh:
        """A surface through the measured points. Raises `DataError` if no object was found yet."""
        return self._models()[2]

    def _models(self) -> tuple[int, Cloud, Mesh]:
        n_steps = self._engine.n_steps()
        if self._model is None or self._model[0] != n_steps:
            cloud, mesh = self._engine.model()
            self._model = (n_steps, cloud_of(cloud), mesh_of(mesh))
        return self._model

    def show(self) -> Page:
        """The report of the scan so far, with its 3D view: for the last line of a notebook's cell."""
        return Page(self._engine.page())

    def save(self, out: str | os.PathLike[str] | None = None, *, force: bool = False) -> None:
        """Writes the results into a folder, as the program does: map, cloud, mesh, records, `report.html`.

        Without `out`, the results go into the folder with which the scan was started. A scan that is over is
        then finished: it cannot be resumed and accepts no more frames. Results of another scan are replaced
        only with `force`.
        """
        path = self._out if out is None else os.fspath(out)
        if path is None:
            raise InputError("`out` is missing, expected a folder: the scan was started without one")
        is_own = self._out is not None and os.path.abspath(path) == os.path.abspath(self._out)
        self._engine.save(path, force or (is_own and self._force), is_own)

    def __repr__(self) -> str:
        """The number of frames and the state."""
        return f"Scan(steps={self._engine.n_steps()}, stop_reason={self.stop_reason!r})"


def resume(out: str | os.PathLike[str]) -> Scan:
    """Resumes the interrupted scan in this folder: it continues after the stored frames, with the views that
    it would have chosen without the interruption.

    Frames at the end that cannot be read, as after a power failure, are lost: a warning says so. Raises
    `DataError` if the folder holds no interrupted scan by your own camera.
    """
    path = os.path.abspath(out)
    engine = _native.LiveScan.resume(path)
    damage = engine.damage()
    if damage is not None:
        warnings.warn(f"{os.path.join(path, 'scan.journal')}: {damage}", stacklevel=2)
    scan = Scan.__new__(Scan)
    # The folder was the scan's when it began.
    scan._begin(engine, path, True)
    return scan


_ARGUMENTS = {"object": "`name`", "live": "`box`, `table`, `first_pose` and `poses`"}
"""Keys of the configuration that arguments make, and those arguments."""
