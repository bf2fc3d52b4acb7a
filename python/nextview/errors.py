"""The exceptions of the package: all are a `NextviewError`.

>>> import nextview
>>> try:
...     nextview.Camera(640, 480, fx=-1.0, fy=600.0, cx=320.0, cy=240.0)
... except nextview.InputError as error:
...     print(error)
fx is -1.0, expected a positive number of pixels, at least 1/250 of the image, at most 1e6
"""

from __future__ import annotations

from typing import Any


class NextviewError(Exception):
    """An error; the message states the problem, the value and what would be right.

    `faults` has one dict per fault, with the entries `kind`, `message` and, where they are known, `key` (the
    dotted key of the configuration), `value`, `expected`, `remedy` and `place`.
    """

    faults: list[dict[str, Any]]

    def __init__(self, message: str = "", faults: list[dict[str, Any]] | None = None) -> None:
        super().__init__(message)
        self.faults = [] if faults is None else faults

    @classmethod
    def _of_faults(cls, faults: list[dict[str, Any]]) -> NextviewError:
        """The exception for these faults, one per line, each with its remedy."""
        return cls("\n".join(_text(fault) for fault in faults), faults)


class InputError(NextviewError, ValueError):
    """An argument, or a combination of arguments, is invalid."""


class DataError(NextviewError):
    """A file, a folder or the data in it is at fault, or the system."""


class InternalError(NextviewError):
    """A bug in nextview. Please report it."""


_ARGUMENTS = {
    "live.box_m": "box",
    "live.first_pose": "first_pose",
    "live.max_depth_m": "camera.depth_range_m",
    "live.min_depth_m": "camera.depth_range_m",
    "live.poses": "poses",
    "live.table_z_m": "table",
}
"""Arguments of `nextview.Scan` in place of keys of a configuration."""


def _text(fault: dict[str, Any]) -> str:
    text = _located(fault)
    for key, argument in _ARGUMENTS.items():
        text = text.replace(f"`{key}`", f"`{argument}`")
    return text


def _located(fault: dict[str, Any]) -> str:
    place = fault.get("place")
    where = "" if place is None else f"{place['file']}{_position(place)}: "
    remedy = fault.get("remedy")
    return f"{where}{fault['message']}" + ("" if remedy is None else f" (hint: {remedy})")


def _position(place: dict[str, Any]) -> str:
    position = place.get("position")
    return "" if position is None else f", line {position[0]}, column {position[1]}"
