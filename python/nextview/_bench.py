"""Campaigns: many scans by one specification."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from nextview import _native
from nextview._lists import listed
from nextview.errors import InputError

Columns = dict[str, Any]
"""Columns by name: arrays of float64 (NaN for a missing value), int64 or bool, or lists of strings or
None."""


@dataclass(frozen=True, eq=False)
class Bench:
    """The tables of a campaign, as `pandas.DataFrame` and `polars.DataFrame` take them."""

    runs: Columns
    """A row per run."""
    steps: Columns
    """A row per view of each run."""
    times: Columns
    """The same rows with times and memory."""
    failed: list[tuple[str, str, int]]
    """Runs that failed: object, reason and how many of them."""


def bench(
    spec: str | os.PathLike[str] | Mapping[str, Any],
    objects: Sequence[str | os.PathLike[str]] | None = None,
    *,
    out: str | os.PathLike[str] | None = None,
    resume: bool = False,
    jobs: int | None = None,
    on_event: Callable[[dict[str, Any]], object] | None = None,
) -> Bench:
    """Runs a whole specification, as `nextview bench` does.

    - `spec`: the name of a built-in specification, a TOML file, or a dict with the same keys, in which
      planners of your own may be their classes.
    - `objects`: mesh files or built-in objects, instead of those of a specification given by name.
    - `out`: a folder that stores every run as soon as it is done; with `resume`, stored runs are not
      repeated. By default, nothing is stored.
    - `jobs`: number of runs in parallel; by default one per core.
    - `on_event`: called with every event, such as `{"run-finished": {...}}`, for a progress bar. It may be
      called from another thread. If it raises, the campaign ends.

    A run that fails does not stop the others. Raises `InputError` or `DataError` if the specification cannot
    be run. Ctrl-C ends it; finished runs stay in `out`.

    >>> import nextview
    >>> spec = {"name": "two", "objects": ["builtin:mug"],
    ...     "scan": {"views": 2, "candidates": 20, "voxel_size_m": 0.02},
    ...     "variant": [{"scan": {"planner": "random"}}, {"scan": {"planner": "max-flow"}}]}
    >>> done = nextview.bench(spec)
    >>> done.runs["variant"]
    ['random', 'max-flow']
    """
    listed = names_of(objects)
    given = spec_of(spec)
    if out is not None:
        return Bench(**_native.bench(given, listed, os.fspath(out), resume, jobs, on_event))
    with tempfile.TemporaryDirectory(prefix="nextview-") as folder:
        return Bench(**_native.bench(given, listed, os.path.join(folder, "bench"), resume, jobs, on_event))


def names_of(objects: Sequence[str | os.PathLike[str]] | None) -> list[str]:
    """The names of objects that take the place of those of a specification; empty for None."""
    if objects is None:
        return []
    names = [os.fspath(each) for each in listed("objects", objects)]
    # A search for files that found none is no wish for those of the specification.
    if not names:
        raise InputError("`objects` is empty, expected at least one, or None for those of the specification")
    return names


def spec_of(spec: str | os.PathLike[str] | Mapping[str, Any]) -> dict[str, Any] | str:
    """A specification: its values, or its name or file."""
    return dict(listed("spec", spec.items())) if isinstance(spec, Mapping) else os.fspath(spec)
