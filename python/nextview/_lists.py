"""Lists that callers give."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from typing import Any

from nextview.errors import InputError

MOST = 100_000
"""Maximum number of entries of a list."""


def listed(name: str, values: Iterable[Any]) -> list[Any]:
    """The entries of an argument, which may be an iterator that never ends."""
    problem = f"`{name}` is of type {type(values).__name__}, expected a list"
    # A text has entries, too, but nobody means its characters.
    if isinstance(values, str | bytes):
        raise InputError(problem)
    try:
        entries = iter(values)
    except TypeError as error:
        raise InputError(problem) from error
    found = list(islice(entries, MOST + 1))
    if len(found) > MOST:
        raise InputError(f"`{name}` has more than {MOST} entries, expected a list of fewer")
    return found
