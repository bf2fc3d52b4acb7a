"""Clouds and meshes in the PLY files of a scan's results."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nextview._model import Cloud, Mesh
from nextview.errors import DataError

_TYPES = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4", "uint": "<u4"}


def read_cloud(path: Path) -> Cloud:
    """The cloud in one of our files. Raises `DataError` if the file is not a cloud."""
    vertices = _elements(path)["vertex"]
    return Cloud(_columns(vertices, "x", "y", "z"), _columns(vertices, "nx", "ny", "nz"), _colors(vertices))


def read_mesh(path: Path) -> Mesh:
    """The mesh in one of our files. Raises `DataError` if the file is not a mesh."""
    elements = _elements(path)
    vertices = elements["vertex"]
    return Mesh(
        vertices=_columns(vertices, "x", "y", "z"),
        triangles=elements["face"]["corners"].astype(np.uint32),
        normals=_columns(vertices, "nx", "ny", "nz"),
        colors=_colors(vertices),
        is_filled=None,
    )


def _elements(path: Path) -> dict[str, NDArray[Any]]:
    """The rows of each element of a binary file whose faces are triangles."""
    try:
        data = path.read_bytes()
        header, body = data.split(b"end_header\n", 1)
        elements, offset = {}, 0
        for part in header.decode().split("element ")[1:]:
            (name, n), *properties = (line.split() for line in part.splitlines() if line)
            dtype = np.dtype([field for each in properties for field in _fields(each)])
            elements[name] = np.frombuffer(body, dtype, int(n), offset)
            offset += elements[name].nbytes
    except (OSError, ValueError, KeyError) as error:
        raise DataError(f"{path}: {error}; expected a cloud or a mesh from the results of a scan") from error
    return elements


def _fields(words: list[str]) -> list[tuple[Any, ...]]:
    if words[0] != "property":
        return []
    if words[1] == "list":
        return [("n", _TYPES[words[2]]), ("corners", _TYPES[words[3]], 3)]
    return [(words[2], _TYPES[words[1]])]


def _columns(rows: NDArray[Any], *names: str) -> NDArray[np.float64]:
    return np.stack([rows[name] for name in names], axis=-1).astype(np.float64)


def _colors(rows: NDArray[Any]) -> NDArray[np.uint8] | None:
    if "red" not in (rows.dtype.names or ()):
        return None
    return np.stack([rows[name] for name in ("red", "green", "blue")], axis=-1)
