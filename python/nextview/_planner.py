"""Planners and gains of your own."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nextview._camera import Camera
from nextview._model import Map, map_of


@dataclass(frozen=True, eq=False)
class Situation:
    """Everything that a planner or a gain may use to choose the next view."""

    map: Map
    """The occupancy of the box around the object. If planning goes from coarse to fine voxels, its voxels are
    coarse at first."""
    candidates: NDArray[np.float64]
    """Poses of all view candidates, `world_from_camera`: N x 4 x 4."""
    open_views: NDArray[np.int64]
    """Numbers of the candidates to choose from, those within reach and not yet taken, in increasing order."""
    visited: NDArray[np.int64]
    """Numbers of the candidates that were taken, in order."""
    frame_poses: NDArray[np.float64]
    """Poses of the frames that the map was made from, `world_from_camera`, oldest first: M x 4 x 4. With
    registration, the aligned ones."""
    camera: Camera
    """Optics and range of the camera."""
    seed: int
    """Seed of the scan, for random draws; each run of a campaign has its own."""


@dataclass(frozen=True, eq=False)
class Rays:
    """All planning rays of a view, one after the other.

    A ray crosses free and unknown voxels, from the camera on. Voxels are numbered as in the flattened arrays
    of the map: `situation.map.probability.ravel()[rays.voxels]` are the probabilities on all rays. For values
    of whole rays, such as sums over their crossings, use `offsets`: `np.add.reduceat(values,
    rays.offsets[:-1])`.
    """

    LEFT_BOX = 0
    """In `ends`: the ray leaves the box."""
    OCCUPIED = 1
    """In `ends`: the ray meets an occupied voxel."""
    FADED = 2
    """In `ends`: the ray ends because almost nothing behind it is visible."""

    view: int
    """Number of the candidate."""
    offsets: NDArray[np.int64]
    """Ray i has the crossings from `offsets[i]` up to `offsets[i + 1]`: R + 1."""
    voxels: NDArray[np.int64]
    """The voxel of each crossing: C."""
    visibilities: NDArray[np.float32]
    """Probability that the voxel is visible, the product of 1 - P(occupied) over those before it: C."""
    ends: NDArray[np.uint8]
    """How each ray ends, `LEFT_BOX`, `OCCUPIED` or `FADED`: R."""
    end_voxels: NDArray[np.int64]
    """The occupied voxel that each ray meets, -1 if it meets none: R."""
    end_visibilities: NDArray[np.float32]
    """Probability that this voxel is visible, 0 if there is none: R."""


class Planner(ABC):
    """A planner of your own: subclass it, and give `planner=` the class, or its name "python:module:Class".

    Every scan creates its own object, without arguments; it may remember earlier calls. Apart from that and
    `situation.seed`, the same situation must give the same view, or an interrupted scan cannot be resumed. An
    exception ends the scan with an `InputError`, whose `__cause__` is that exception.

    >>> import nextview, numpy as np
    >>> class FromAbove(nextview.Planner):
    ...     def plan(self, situation):
    ...         heights = situation.candidates[situation.open_views, 2, 3]
    ...         return int(situation.open_views[np.argmax(heights)])
    """

    @abstractmethod
    def plan(self, situation: Situation) -> int | tuple[int, float] | None:
        """The number of the view to take, one of `situation.open_views`; or this number and a score for the
        records; or None if no view gains anything, which ends the scan.

        Not called for the first view, which is given.
        """


class Gain(ABC):
    """An information gain of your own: subclass it, and give `planner=` the class, or its name
    "python:module:Class". The view with the largest gain is taken, as by the built-in planners named after a
    gain; `greedy={"theta": 0.3}` penalises long moves, `greedy={"ray_spacing": 4.0}` casts fewer rays.

    Every scan creates its own object, without arguments. An exception ends the scan with an `InputError`,
    whose `__cause__` is that exception. Runs of a campaign are done in parallel: numpy operations that use
    all cores, such as `@` on long arrays, are slow there.

    >>> import nextview, numpy as np
    >>> class VisibleUnknown(nextview.Gain):
    ...     def begin(self, situation):
    ...         self.is_unknown = situation.map.occupancy.ravel() == nextview.Map.UNKNOWN
    ...     def gain(self, situation, rays):
    ...         return float((rays.visibilities * self.is_unknown[rays.voxels]).sum())
    """

    free_space: str = "clear"
    """How far rays see through voxels known to be free: "clear", they hide nothing, and the free margin of
    the box is left out; or "fades", each passes 1 - P(occupied), as the formulas of the literature say."""

    def begin(self, situation: Situation) -> None:
        """Called once before the views of each decision, for what does not depend on the view."""

    @abstractmethod
    def gain(self, situation: Situation, rays: Rays) -> float:
        """The gain of the view with these rays, finite and at least 0; a view with gain 0 is never taken.

        Called for every open view, one after the other, in increasing order.
        """


def situation_of(
    arrays: dict[str, Any],
    candidates: NDArray[np.float64],
    open_views: NDArray[np.int64],
    visited: NDArray[np.int64],
    frame_poses: NDArray[np.float64],
    camera: tuple[Any, ...],
    seed: int,
) -> Situation:
    """The situation with this map and this camera."""
    return Situation(map_of(arrays), candidates, open_views, visited, frame_poses, Camera(*camera), seed)
