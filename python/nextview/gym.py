"""View planning as a `gymnasium.Env` (extra `gym`): learn which view to take next.

>>> import gymnasium, nextview.gym
>>> env = gymnasium.make("nextview/ViewPlanning-v0", objects=["builtin:mug"], n_candidates=20, views=3)
>>> observation, info = env.reset(seed=1)
>>> observation["map"].shape, int(observation["visited"].sum())
((16, 16, 16), 1)
>>> observation, reward, terminated, truncated, info = env.step(7)
>>> 0 <= reward <= info["coverage"] <= 1
True
"""

from __future__ import annotations

import reprlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nextview._camera import Camera
from nextview._lists import listed
from nextview._scan import Scan
from nextview._simulated import SimulatedScene
from nextview.errors import InputError

try:
    import gymnasium
    from gymnasium import spaces
except ImportError as missing:
    raise ImportError("the package gymnasium is not installed: pip install 'nextview[gym]'") from missing

Observation = dict[str, Any]
"""`map`: the states of the voxels, `nextview.Map.UNKNOWN`, `FREE` or `OCCUPIED`, X x Y x Z of uint8;
`visited`: by candidate, 1 if it was taken, int8."""


class ViewPlanning(gymnasium.Env[Observation, np.int64]):
    """An unknown object in the middle of view candidates on a sphere; each action takes one of them.

    - `objects`: the objects, one of which is drawn for each episode: mesh files or built-in objects, such as
      "builtin:random-7".
    - `n_candidates`: the number of view candidates, and of actions. The candidate of an action is in the same
      direction from every object.
    - `views`: the number of views of an episode, with the first one, which is drawn. Then it is truncated.
    - `cells`: voxels of the observed map along each axis.
    - `camera`: the camera; by default one of 160 x 120 pixels with the view of a RealSense D435i.

    The reward is the share of the reachable surface that a view adds; the return and the coverage of the
    first view are together `info["coverage"]`, the coverage at the end. A candidate that was taken before
    adds nothing. Everything that an episode draws follows from the seed of `reset`.
    """

    metadata = {"render_modes": []}

    def __init__(
        self,
        objects: Sequence[str] = ("builtin:mug", "builtin:bracket", "builtin:torus-knot", "builtin:teapot"),
        *,
        n_candidates: int = 40,
        views: int = 6,
        cells: int = 16,
        camera: Camera | None = None,
    ) -> None:
        """Nothing is loaded before the first episode. Raises `InputError` if a number is out of range."""
        for name, value, most in [
            ("n_candidates", n_candidates, 10_000),
            ("views", views, 10_000),
            ("cells", cells, 256),
        ]:
            if not 2 <= value <= most:
                raise InputError(f"`{name}` is {value}, expected 2 to {most}")
        if isinstance(objects, str):
            shown = reprlib.repr(objects)
            raise InputError(f"`objects` is {shown}, expected a list, such as [{shown}]")
        self._objects = listed("objects", objects)
        if not self._objects:
            raise InputError("`objects` is empty, expected at least one object")
        self._n_candidates, self._views, self._cells = n_candidates, views, cells
        default = Camera(160, 120, fx=152.0, fy=152.0, cx=79.5, cy=59.5)
        self._camera = default if camera is None else camera
        self._scenes: dict[str, SimulatedScene] = {}
        self.observation_space = spaces.Dict(
            {
                "map": spaces.Box(0, 2, (cells, cells, cells), np.uint8),
                "visited": spaces.MultiBinary(n_candidates),
            }
        )
        self.action_space = spaces.Discrete(n_candidates)

    @property
    def directions(self) -> NDArray[np.float64]:
        """Unit vectors from the middle of the object to the candidates: N x 3."""
        scene = self._scene(self._objects[0])
        offsets = scene.candidates[:, :3, 3] - np.mean(scene.box_m, axis=0)
        directions: NDArray[np.float64] = offsets / np.linalg.norm(offsets, axis=1, keepdims=True)
        return directions

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Draws an object and a first view of it.

        `options` may name the `object`. `info` has the `object` and the `coverage`.
        """
        super().reset(seed=seed)
        drawn = self._objects[int(self.np_random.integers(len(self._objects)))]
        name = (options or {}).get("object", drawn)
        self._sim = self._scene(name)
        self._object = name
        low, high = np.asarray(self._sim.box_m)
        size = float((high - low).max())
        self._scan = Scan(
            self._sim.camera,
            self._sim.box_m,
            poses=self._sim.candidates,
            planner="random",
            voxel_size_m=size / self._cells,
        )
        self._taken: list[int] = []
        self._take(int(self.np_random.integers(self._n_candidates)))
        return self._observation(), self._info()

    def step(self, action: np.int64) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Takes the view of this number: the observation, the coverage gained, and whether that was the last
        view."""
        if not self.action_space.contains(action):
            raise InputError(f"`action` is {reprlib.repr(action)}, expected 0 to {self._n_candidates - 1}")
        before = self._coverage
        self._take(int(action))
        is_last = len(self._taken) >= self._views
        return self._observation(), self._coverage - before, False, is_last, self._info()

    def _scene(self, name: str) -> SimulatedScene:
        if name not in self._scenes:
            self._scenes[name] = SimulatedScene(
                name, camera=self._camera, view_space="sphere", candidates=self._n_candidates
            )
        return self._scenes[name]

    def _take(self, view: int) -> None:
        if view not in self._taken:
            pose = self._sim.candidates[view]
            self._scan.observe(self._sim.capture(pose), pose)
        self._taken.append(view)
        self._coverage = float(self._sim.reachable_coverage(self._taken)[-1])

    def _observation(self) -> Observation:
        known = self._scan.map
        assert known is not None, "the box is known"
        # The lattice of the voxels may cut the box into one voxel less or more.
        n = [min(self._cells, length) for length in known.occupancy.shape]
        grid = np.zeros((self._cells,) * 3, dtype=np.uint8)
        grid[: n[0], : n[1], : n[2]] = known.occupancy[: n[0], : n[1], : n[2]]
        visited = np.zeros(self._n_candidates, dtype=np.int8)
        visited[self._taken] = 1
        return {"map": grid, "visited": visited}

    def _info(self) -> dict[str, Any]:
        return {"object": self._object, "coverage": self._coverage}


gymnasium.register("nextview/ViewPlanning-v0", entry_point="nextview.gym:ViewPlanning")
