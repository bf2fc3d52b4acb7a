"""Scans of simulated objects and of recorded frames."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nextview import _native
from nextview._camera import Camera
from nextview._lists import listed
from nextview._model import Cloud, Map, Mesh, cloud_of, map_of, mesh_of
from nextview._page import Page
from nextview._scan import Pose
from nextview.errors import InputError


class SimulatedScene:
    """A simulated object in front of a simulated depth camera, in place of real ones.

    - `object`: a mesh file, or one of `nextview.builtin_objects`.
    - `camera`: the camera; by default an exact RealSense D435i.
    - `options`: keys of a configuration, such as `sensor="d405"` (a camera with its noise), `size_m=0.3`,
      `unit="mm"`, `object_box={"table": "known"}` (it stands on a table), `noise={"model": "d435i", "seed":
      1}`.

    Raises `InputError` or `DataError` if the object cannot be scanned with these options.

    >>> import nextview
    >>> sim = nextview.SimulatedScene("builtin:mug")
    >>> depth = sim.capture(sim.candidates[0])
    >>> depth.shape, depth.dtype
    ((480, 640), dtype('float32'))
    """

    def __init__(
        self,
        object: str | os.PathLike[str] = "builtin:teapot",
        *,
        camera: Camera | None = None,
        **options: Any,
    ) -> None:
        """Loads the object."""
        self._engine = _native.Scene({**options, "object": os.fspath(object)}, camera)

    def capture(self, world_from_camera: Pose) -> NDArray[np.float32]:
        """The depth image from a pose: height x width, float32, metres; NaN where nothing was measured,
        infinite where nothing came back.

        Raises `InputError` if the pose is invalid, and `DataError` if it is outside the room around the
        object.
        """
        return self._engine.capture(world_from_camera, False)[0]

    def frame(
        self, world_from_camera: Pose, *, is_first: bool = False
    ) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
        """The depth image from a pose, and the pose that the camera claims to have: another one where
        `noise.pose_error_mm` or `noise.pose_error_deg` of the options say so. `is_first` is for the first
        frame of a scan, whose pose `noise.first_pose_is_right` may keep right."""
        return self._engine.capture(world_from_camera, is_first)

    @property
    def camera(self) -> Camera:
        """The camera."""
        return Camera(*self._engine.camera())

    @property
    def candidates(self) -> NDArray[np.float64]:
        """Poses of the view candidates around the object: N x 4 x 4, `world_from_camera`."""
        return self._engine.candidates()

    def reachable_coverage(self, views: Sequence[int]) -> NDArray[np.float64]:
        """Share, 0 to 1, of the surface that any candidate sees which was seen after each of these
        candidates. The first call looks from all candidates, some milliseconds each.

        >>> import nextview
        >>> sim = nextview.SimulatedScene("builtin:mug", voxel_size_m=0.01, candidates=10)
        >>> float(sim.reachable_coverage(range(10))[-1])
        1.0
        """
        return self._engine.coverage_curve(listed("views", views))

    @property
    def box_m(self) -> tuple[list[float], list[float]]:
        """Lowest and highest corner of the box around the object that a scan plans in."""
        return self._engine.box_m()

    @property
    def room_m(self) -> tuple[list[float], list[float]]:
        """Lowest and highest corner of the room; its lowest z is the table's, where there is one."""
        return self._engine.room_m()

    @property
    def voxel_size_m(self) -> float:
        """The voxel size given in the options, or else one that suits the object."""
        return self._engine.voxel_size_m()

    def __repr__(self) -> str:
        """Name, size and number of triangles of the object."""
        return f"SimulatedScene({self._engine.description()})"


@dataclass(frozen=True, eq=False)
class ScanResult:
    """The results of a scan."""

    record: dict[str, Any]
    """All measures: what `record.json` holds."""
    config: dict[str, Any]
    """Everything that decides the scan: what `config.toml` holds."""
    cloud: Cloud | None
    """The measured points; None if no object was found."""
    mesh: Mesh | None
    """A surface through them; None if no object was found."""
    map: Map | None
    """The occupancy of the box around the object; None if no object was found."""
    notes: list[str]
    """Remarks, such as a unit that was guessed."""
    _engine: _native.Finished | None = field(default=None, repr=False)

    def show(self) -> Page:
        """The report of the scan, with its 3D view: for the last line of a notebook's cell. Raises
        `InputError` for a result that was pickled, which has no frames."""
        return Page(self._finished().page())

    def _finished(self) -> _native.Finished:
        if self._engine is None:
            raise InputError("this result was pickled, which drops its frames; show it before")
        return self._engine

    def __getstate__(self) -> dict[str, Any]:
        """Everything but the frames, which only pictures need."""
        return {**self.__dict__, "_engine": None}


def scan(
    object: str | os.PathLike[str] = "builtin:teapot",
    *,
    camera: Camera | None = None,
    out: str | os.PathLike[str] | None = None,
    force: bool = False,
    on_step: Callable[[dict[str, Any]], object] | None = None,
    **options: Any,
) -> ScanResult:
    """Scans a simulated object, as `nextview scan` does: with the same options, the same views and results.

    - `object`: a mesh file, or one of `nextview.builtin_objects`; with `recording={}` in the options, where
      recorded frames are.
    - `camera`: the camera; by default a RealSense D435i.
    - `out`: a folder for the results; by default nothing is written. Existing results are replaced only with
      `force`.
    - `on_step`: called with the record of every step. If it raises, the scan ends.
    - `options`: keys of a configuration, such as `planner="max-flow"` or a planner of your own, `views=12`,
      `voxel_size_m=0.005`, `noise={"model": "d435i"}`, `registration={"enabled": True}`. With
      `baselines=False`, what every candidate truly sees is not computed, which takes longer than the scan.

    Raises `InputError` or `DataError` if the object cannot be scanned with these options. Ctrl-C ends it.

    >>> import nextview
    >>> done = nextview.scan("builtin:mug", views=2, voxel_size_m=0.01, baselines=False)
    >>> done.record["views"], done.map.occupancy.ndim
    (2, 3)
    """
    config = {**options, "object": os.fspath(object)}
    path = None if out is None else os.fspath(out)
    done = _native.scan(config, camera, path, force, on_step)
    cloud, mesh, grid = done["cloud"], done["mesh"], done["map"]
    return ScanResult(
        record=done["record"],
        config=done["config"],
        cloud=None if cloud is None else cloud_of(cloud),
        mesh=None if mesh is None else mesh_of(mesh),
        map=None if grid is None else map_of(grid),
        notes=done["notes"],
        _engine=done["engine"],
    )
