"""Planners and gains of one's own, some of them broken."""

from __future__ import annotations

import os
import threading
from typing import Any

import numpy as np

import nextview


class FromAbove(nextview.Planner):
    """Takes the highest view."""

    def plan(self, situation: nextview.Situation) -> tuple[int, float]:
        heights = situation.candidates[situation.open_views, 2, 3]
        best = int(np.argmax(heights))
        return int(situation.open_views[best]), float(heights[best])


class Dies(nextview.Planner):
    """Takes its process with it."""

    def plan(self, situation: nextview.Situation) -> int:
        os._exit(1)


class UnobservedVoxel(nextview.Gain):
    """The built-in gain of this name: the sum of visibility times entropy over the unknown voxels."""

    free_space = "fades"

    def begin(self, situation: nextview.Situation) -> None:
        is_unknown = situation.map.occupancy.ravel() == nextview.Map.UNKNOWN
        self.entropy = np.where(is_unknown, np.log(2.0), 0.0)

    def gain(self, situation: nextview.Situation, rays: nextview.Rays) -> float:
        return float((rays.visibilities * self.entropy[rays.voxels]).sum())


class OcclusionAware(nextview.Gain):
    """The built-in gain of this name: the sum of visibility times entropy over all voxels, the occupied one
    at the end of a ray included."""

    free_space = "fades"

    def begin(self, situation: nextview.Situation) -> None:
        p = situation.map.probability.ravel().astype(np.float64)
        self.entropy = -p * np.log(p) - (1 - p) * np.log1p(-p)

    def gain(self, situation: nextview.Situation, rays: nextview.Rays) -> float:
        passed = rays.visibilities * self.entropy[rays.voxels]
        # Where there is no last voxel, its visibility is 0.
        last = rays.end_visibilities * self.entropy[rays.end_voxels]
        return float(passed.sum() + last.sum())


class Random(nextview.Planner):
    """Draws a view by the seed of its scan."""

    def plan(self, situation: nextview.Situation) -> int:
        random = np.random.default_rng([situation.seed, len(situation.visited)])
        return int(random.choice(situation.open_views))


class Told(nextview.Planner):
    """Answers what it is told to."""

    answer: Any = None

    def plan(self, situation: nextview.Situation) -> Any:
        return self.answer(situation) if callable(self.answer) else self.answer


class GainTold(nextview.Gain):
    """Answers what it is told to."""

    answer: Any = None

    def gain(self, situation: nextview.Situation, rays: nextview.Rays) -> Any:
        return self.answer


class Raises(nextview.Planner):
    """Raises an exception."""

    def plan(self, situation: nextview.Situation) -> int:
        raise ZeroDivisionError("no view at all")


class GainRaises(nextview.Gain):
    """Raises an exception."""

    def gain(self, situation: nextview.Situation, rays: nextview.Rays) -> float:
        raise LookupError(f"view {rays.view}")


class CannotBegin(nextview.Planner):
    """Has no object without arguments."""

    def __init__(self, weights: str) -> None:
        self.weights = weights

    def plan(self, situation: nextview.Situation) -> None:
        return None


class Unfinished(nextview.Gain):
    """Has no gain."""


class WrongRays(nextview.Gain):
    """Wants rays that there are not."""

    free_space = "open"

    def gain(self, situation: nextview.Situation, rays: nextview.Rays) -> float:
        return 1.0


class Counts(nextview.Planner):
    """Fails if it serves more than one scan."""

    objects: set[int] = set()
    lock = threading.Lock()

    def __init__(self) -> None:
        self.n_calls = 0

    def plan(self, situation: nextview.Situation) -> int:
        self.n_calls += 1
        assert len(situation.visited) == self.n_calls
        with self.lock:
            self.objects.add(id(self))
        return int(situation.open_views[-1])


def no_class() -> None:
    """Is no class."""


class NoPlanner:
    """Is no planner."""


class Outer:
    """Holds a planner."""

    class Inner(FromAbove):
        """A planner in another class."""
