"""Names that arguments take."""

from __future__ import annotations

from nextview import _native


def planners() -> dict[str, str]:
    """The planners by name, each with a line about it.

    >>> import nextview
    >>> next(iter(nextview.planners()))
    'most-surface'
    """
    return dict(_native.planners())


def sensors() -> list[str]:
    """The names that `Camera.sensor` takes.

    >>> import nextview
    >>> "d405" in nextview.sensors()
    True
    """
    return _native.sensors()


def builtin_objects() -> list[str]:
    """The built-in objects, which need no file. There is also `builtin:random-N` for every whole number N
    from 0.

    >>> import nextview
    >>> nextview.builtin_objects()
    ['builtin:teapot', 'builtin:mug', 'builtin:bracket', 'builtin:torus-knot']
    """
    return _native.builtin_objects()
