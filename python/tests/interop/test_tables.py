"""Columns of a campaign in pandas and polars."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import nextview

SPEC: dict[str, Any] = {
    "name": "two",
    "objects": ["builtin:mug"],
    "scan": {"views": 3, "candidates": 20, "voxel_size_m": 0.02},
    "variant": [{"scan": {"planner": "random"}}, {"scan": {"planner": "max-flow"}}],
}


@pytest.fixture(scope="module")
def done() -> nextview.Bench:
    """A small campaign."""
    return nextview.bench(SPEC)


def test_pandas_takes_the_columns(done: nextview.Bench) -> None:
    pandas = pytest.importorskip("pandas")
    runs = pandas.DataFrame(done.runs)
    assert list(runs["variant"]) == ["random", "max-flow"] and runs["skill"].dtype == np.float64
    steps = pandas.DataFrame(done.steps)
    last = steps.groupby("variant")["reachable_coverage"].max()
    for variant, coverage in zip(runs["variant"], runs["reachable_coverage"], strict=True):
        assert last[variant] == coverage
    column = pandas.Series(done.steps["reachable_coverage"], copy=False)
    assert np.shares_memory(column.to_numpy(), done.steps["reachable_coverage"])


def test_polars_takes_the_columns(done: nextview.Bench) -> None:
    polars = pytest.importorskip("polars")
    steps = polars.DataFrame(done.steps)
    assert steps["step"].dtype == polars.Int64 and steps["reachable_coverage"].dtype == polars.Float64
    best = steps.group_by("variant").agg(polars.col("reachable_coverage").max())
    expected = dict(zip(done.runs["variant"], done.runs["reachable_coverage"], strict=True))
    assert dict(best.iter_rows()) == expected
