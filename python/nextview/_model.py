"""Cloud, mesh and map of a scan."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nextview import _native


@dataclass(frozen=True, eq=False)
class Cloud:
    """The measured points, thinned to cells of a quarter of a voxel."""

    points: NDArray[np.float64]
    """Positions in the world, metres: N x 3."""
    normals: NDArray[np.float64]
    """Unit normals that point to where the camera was: N x 3; NaN where none could be fitted."""
    colors: NDArray[np.uint8] | None
    """Red, green, blue: N x 3; None if no frame had colours."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A surface through the measured points."""

    vertices: NDArray[np.float64]
    """Positions in the world, metres: N x 3."""
    triangles: NDArray[np.uint32]
    """Vertices of the triangles, counter-clockwise seen from outside: M x 3."""
    normals: NDArray[np.float64]
    """Unit normals at the vertices: N x 3."""
    colors: NDArray[np.uint8] | None
    """Red, green, blue of the vertices: N x 3; None if no frame had colours."""
    is_filled: NDArray[np.bool_] | None
    """By vertex, whether it was filled in; None unless `model.watertight` of the configuration is true."""


@dataclass(frozen=True, eq=False)
class Map:
    """The occupancy of the box around the object as a dense grid.

    Voxel (i, j, k) is the cube with its lowest corner at `origin_m + voxel_size_m * (i, j, k)`.
    """

    UNKNOWN = 0
    """In `occupancy`: never measured."""
    FREE = 1
    """In `occupancy`: measured as free."""
    OCCUPIED = 2
    """In `occupancy`: measured as surface."""

    occupancy: NDArray[np.uint8]
    """State of each voxel, `UNKNOWN`, `FREE` or `OCCUPIED`: X x Y x Z."""
    probability: NDArray[np.float32]
    """Probability that the voxel is occupied, 0 to 1; 0.5 where nothing was measured: X x Y x Z."""
    origin_m: NDArray[np.float64]
    """Lowest corner of the grid in the world, metres: 3."""
    voxel_size_m: float
    """Edge of a voxel, metres."""

    def centers(self, state: int = 2) -> NDArray[np.float64]:
        """Centres of the voxels of this state, metres: N x 3."""
        centers: NDArray[np.float64] = (
            self.origin_m + (np.argwhere(self.occupancy == state) + 0.5) * self.voxel_size_m
        )
        return centers

    def save(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Writes the map as an OctoMap file: every probability for a name that ends in .ot, occupied and free
        only for .bt. An existing file is replaced only with `force`.

        Raises `InputError` if the grid does not fit an OctoMap: `origin_m` must be a multiple of the voxel
        size, and probabilities of measured voxels between 0 and 1.
        """
        grid = (self.occupancy, self.probability, self.origin_m, self.voxel_size_m)
        _native.write_map(os.fspath(path), *grid, force)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Map:
        """The measured part of an OctoMap file, .ot or .bt, as a dense grid.

        Raises `DataError` if the file is not an OctoMap, has no measured voxel, or spans more than 2^26
        voxels.
        """
        return map_of(_native.read_map(os.fspath(path)))


def cloud_of(arrays: dict[str, Any]) -> Cloud:
    """The cloud of these arrays."""
    return Cloud(**arrays)


def mesh_of(arrays: dict[str, Any]) -> Mesh:
    """The mesh of these arrays."""
    return Mesh(vertices=arrays["points"], **{key: arrays[key] for key in arrays if key != "points"})


def map_of(arrays: dict[str, Any]) -> Map:
    """The map of these arrays."""
    return Map(**{**arrays, "origin_m": np.array(arrays["origin_m"], dtype=np.float64)})
