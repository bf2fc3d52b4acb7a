"""Results in the formats of other tools."""

from __future__ import annotations

import os
from typing import NamedTuple

from nextview import _native


class Exported(NamedTuple):
    """The result of an export."""

    n_views: int
    """Number of pictures."""
    notes: list[str]
    """Remarks, such as what was left out."""


def export(
    results: str | os.PathLike[str],
    to: str,
    out: str | os.PathLike[str],
    *,
    force: bool = False,
) -> Exported:
    """Exports the results of a scan in the format of another tool, as `nextview export` does.

    - `results`: the folder of a scan that was saved.
    - `to`: `"bop"`, `"colmap"`, `"foundationpose"`, `"nerfstudio"`, `"obj"`, `"open3d"`, `"pcd"` or `"tum"`.
      docs/export.md lists their files, axes and units.
    - `out`: the output folder. With `force`, existing files are replaced.

    colmap, foundationpose, nerfstudio and obj need frames with colour. Raises `InputError` if there is no
    such format, and `DataError` if the folder holds no results, or `out` cannot take them.

    >>> import nextview, pathlib, tempfile
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> done = nextview.scan("builtin:mug", views=2, voxel_size_m=0.01, baselines=False, out=folder / "mug")
    >>> nextview.export(folder / "mug", "tum", folder / "tum").n_views
    2
    """
    return Exported(*_native.export(os.fspath(results), to, os.fspath(out), force))
