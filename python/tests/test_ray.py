"""Campaigns on a Ray of this machine."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import nextview
from nextview import _native

os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
ray = pytest.importorskip("ray")
campaigns = pytest.importorskip("nextview.ray")

SPEC = """
name = "small"
objects = ["builtin:mug", "builtin:bracket"]
seeds = [0, 1, 2]
[scan]
profile = "paper"
candidates = 20
views = 3
voxel_size_m = 0.02
stop.entropy_share = 0
camera = { width = 80, height = 60, fx = 76, fy = 76, cx = 40, cy = 30 }
[[variant]]
scan.planner = "random"
[[variant]]
scan.planner = "max-flow"
"""
N_RUNS = 12
TABLES = ["runs.csv", "steps.csv", "runs.parquet", "steps.parquet"]


@pytest.fixture(scope="module")
def cluster() -> Iterator[str]:
    """The address of a cluster of two CPUs, which ends with the tests."""
    planners = {"env_vars": {"PYTHONPATH": str(Path(__file__).parent)}}
    context = ray.init(
        address="local", num_cpus=2, include_dashboard=False, log_to_driver=False, runtime_env=planners
    )
    yield context.address_info["address"]
    ray.shutdown()


@pytest.fixture(scope="module")
def spec(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("spec") / "small.toml"
    path.write_text(SPEC)
    return path


@pytest.fixture(scope="module")
def alone(spec: Path, tmp_path_factory: pytest.TempPathFactory) -> list[bytes]:
    """The tables of one process."""
    out = tmp_path_factory.mktemp("alone") / "out"
    nextview.bench(spec, out=out, jobs=1)
    return tables(out)


def tables(out: Path) -> list[bytes]:
    return [(out / name).read_bytes() for name in TABLES]


def test_tables_are_those_of_one_process(
    cluster: str, spec: Path, alone: list[bytes], tmp_path: Path
) -> None:
    events: list[dict[str, Any]] = []
    assert campaigns.bench(spec, out=tmp_path / "out", on_event=events.append) == []
    assert tables(tmp_path / "out") == alone
    assert events[0] == {"began": {"n_objects": 2, "n_runs": N_RUNS, "n_finished": 0}}
    assert sum("run-finished" in event for event in events) == N_RUNS
    assert {"object-finished": {"object": "mug", "n_runs": 6, "n_failed": 0}} in events
    lines = (tmp_path / "out" / "runs.jsonl").read_text().splitlines()
    assert len(lines) == N_RUNS
    assert {json.loads(line)["host"]["n_threads"] for line in lines} == {1}


def test_an_interrupted_campaign_is_resumed(
    cluster: str, spec: Path, alone: list[bytes], tmp_path: Path
) -> None:
    out = tmp_path / "out"

    class Interruption(Exception):
        pass

    def interrupt(event: dict[str, Any]) -> None:
        if "run-finished" in event and len((out / "runs.jsonl").read_text().splitlines()) == 5:
            raise Interruption

    with pytest.raises(Interruption):
        campaigns.bench(spec, out=out, on_event=interrupt)
    assert not (out / "runs.csv").exists()
    # A write that was torn, as by a driver that was killed.
    with (out / "runs.jsonl").open("a") as file:
        file.write('{"object": "mu')
    command = [sys.executable, "-m", "nextview.ray", "bench", str(spec), "--out", str(out), "--address", cluster]
    ended = subprocess.run(command, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    assert "note: the last line of runs.jsonl is incomplete" in ended.stderr
    assert "2 objects, 12 runs, 5 already done, in " in ended.stderr and "bracket: 6 runs" in ended.stderr
    assert tables(out) == alone
    assert len((out / "runs.jsonl").read_text().splitlines()) == N_RUNS
    # Once more: nothing is left to do.
    assert campaigns.bench(spec, out=out) == [] and tables(out) == alone


def test_workers_share_a_cache_of_truths(
    cluster: str, spec: Path, alone: list[bytes], tmp_path: Path
) -> None:
    truths = tmp_path / "truths"
    for name in ("cold", "warm"):
        assert campaigns.bench(spec, out=tmp_path / name, truth_cache=truths) == []
        assert tables(tmp_path / name) == alone
    assert len(list(truths.iterdir())) == 2, "an entry for each object"


def test_a_worker_of_another_build_is_refused(
    cluster: str, spec: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ours = _native.Campaign

    class Another:
        """A driver of another build."""

        def __init__(self, *args: Any) -> None:
            self.campaign = ours(*args)

        def __getattr__(self, name: str) -> Any:
            return getattr(self.campaign, name)

        def take(self, n_workers: int) -> tuple[str, str] | None:
            taken = self.campaign.take(n_workers)
            assert taken is not None
            message = json.loads(taken[1])
            message["build"]["source"] = "feedfacebeef"
            return taken[0], json.dumps(message)

    monkeypatch.setattr(campaigns._native, "Campaign", Another)
    refusal = r"build .*\(feedfacebeef\), .*worker.* has build "
    with pytest.raises(nextview.DataError, match=refusal):
        campaigns.bench(spec, out=tmp_path / "out")
    assert (tmp_path / "out" / "runs.jsonl").read_text() == ""


def test_runs_that_were_lost_are_named(cluster: str, tmp_path: Path) -> None:
    scan = {"views": 2, "candidates": 20, "voxel_size_m": 0.02, "baselines": False}
    variants = [{"label": "well", "scan": {"planner": "random"}},
                {"label": "deadly", "scan": {"planner": "python:own_planners:Dies"}}]
    spec = {"name": "lost", "objects": ["builtin:mug"], "scan": scan, "variant": variants}
    events: list[dict[str, Any]] = []
    # Each run in a task of its own.
    with pytest.raises(nextview.DataError, match=r"1 of 2 runs have no record:\n  object mug, variant deadly"):
        campaigns.bench(spec, out=tmp_path / "out", retries=1, on_event=events.append)
    assert any(event.get("note", "").startswith("a task was lost: ") for event in events)
    (line,) = (tmp_path / "out" / "runs.jsonl").read_text().splitlines()
    assert json.loads(line)["variant"] == "well"


def test_a_planner_that_workers_cannot_import_is_no_failed_run(
    cluster: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "here_alone.py").write_text("from own_planners import FromAbove\n")
    monkeypatch.syspath_prepend(tmp_path)
    spec = {"name": "no", "objects": ["builtin:mug"], "scan": {"planner": "python:here_alone:FromAbove"}}
    with pytest.raises(nextview.InputError, match=r"the worker on .*here_alone.*ModuleNotFoundError"):
        campaigns.bench(spec, out=tmp_path / "out")
    assert (tmp_path / "out" / "runs.jsonl").read_text() == ""


def test_failed_runs_are_results(cluster: str, tmp_path: Path) -> None:
    spec = {"name": "none", "objects": [str(tmp_path / "no.ply")], "variant": [{"scan": {"planner": "rse"}}]}
    (tmp_path / "no.ply").write_text("ply\n")
    (name, reason, n_runs), *others = campaigns.bench(spec, out=tmp_path / "out")
    assert (name, n_runs, others) == ("no", 1, []) and "no.ply" in reason
    assert (tmp_path / "out" / "runs.csv").exists()


def test_wrong_input_is_refused_before_anything_is_begun(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with pytest.raises(nextview.InputError, match="`cpus` is 0, expected at least 1"):
        campaigns.bench("paper-1", out=out, cpus=0)
    with pytest.raises(nextview.NextviewError, match="no-such.toml"):
        campaigns.bench("no-such.toml", out=out)
    assert not out.exists()
