"""Campaigns on a Ray cluster (extra `ray`).

`python -m nextview.ray bench SPEC --out DIR` does the runs of a campaign as Ray tasks, and `bench` does the
same from a script. Only the driver writes the folder, by the rules of every campaign; tasks send back
records, each as soon as its run is done. Apart from times, the tables are the same to the byte as if one
process had done all runs.

A task does the runs of an object, or, towards the end, some of them. Ray's dashboard shows
them by object and planners. Workers need the same build of this package, and the same paths of the objects'
files.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from nextview import _native
from nextview._bench import names_of, spec_of
from nextview.errors import DataError, InputError, NextviewError

try:
    import ray
except ImportError as missing:
    raise ImportError("the package ray is not installed: pip install 'nextview[ray]'") from missing

Failed = list[tuple[str, str, int]]
"""Runs that failed: object, reason and how many of them."""


def bench(
    spec: str | os.PathLike[str] | Mapping[str, Any],
    objects: Sequence[str | os.PathLike[str]] | None = None,
    *,
    out: str | os.PathLike[str],
    address: str | None = None,
    cpus: int = 1,
    retries: int = 3,
    workers: int | None = None,
    truth_cache: str | os.PathLike[str] | None = None,
    truth_cache_mb: int = 4096,
    on_event: Callable[[dict[str, Any]], object] | None = None,
) -> Failed:
    """Runs a whole specification on a cluster, writes the tables, and returns the failed runs.

    - `spec`, `objects`: those of `nextview.bench`. Planners of your own are classes of a module that workers
      can import.
    - `out`: the campaign's folder, on this machine. If it already holds runs of the campaign, only the
      missing ones are done.
    - `address`: that of the cluster, as for `ray.init`; leave it out if `ray.init` was already called.
    - `cpus`: CPUs that Ray reserves for a task; its runs have as many threads.
    - `retries`: how often Ray repeats a task whose worker or node died; -1 for no limit.
    - `workers`: number of workers for which the runs are split into tasks; by default, as many as the cluster
      has CPUs for. Set it if the cluster grows.
    - `truth_cache`: a folder shared by all nodes, or one on each of them, that caches the true visibility of
      every object from all candidates, so that it is computed once; at most `truth_cache_mb` megabytes.
    - `on_event`: called with every event, such as `{"run-finished": {...}}`.

    Raises `InputError` or `DataError` if the specification cannot be run, if a worker has another build, or
    if runs are missing at the end because their tasks were lost.
    """
    for name, value, least in [("cpus", cpus, 1), ("retries", retries, -1), ("workers", workers, 1), ("truth_cache_mb", truth_cache_mb, 0)]:
        if value is not None and value < least:
            raise InputError(f"`{name}` is {value}, expected at least {least}")
    campaign = _native.Campaign(spec_of(spec), names_of(objects), os.fspath(out))
    tell = on_event or (lambda event: None)
    for event in campaign.beginning():
        tell(event)
    if not ray.is_initialized():
        ray.init(address)
    n_workers = workers or max(1, int(ray.cluster_resources().get("CPU", 1) / cpus))
    cache = (None if truth_cache is None else os.path.abspath(truth_cache), truth_cache_mb)
    lost = _do_all(campaign, cpus, retries, n_workers, cache, tell)
    try:
        return campaign.finish()
    except DataError as missing:
        raise (DataError(f"{missing}\n{lost[0]}", missing.faults) if lost else missing) from None


def _do_all(
    campaign: _native.Campaign,
    cpus: int,
    retries: int,
    n_workers: int,
    cache: tuple[str | None, int],
    tell: Callable[[dict[str, Any]], object],
) -> list[str]:
    """Does the open runs; returns the reasons why tasks were lost."""
    options = {"num_cpus": cpus, "max_retries": retries, "num_returns": "streaming"}
    task = ray.remote(**options)(_records)
    running: list[Any] = []
    lost: list[str] = []
    try:
        while True:
            # Twice as many as there are workers, so that none waits for the driver.
            while len(running) < 2 * n_workers and (batch := campaign.take(n_workers)) is not None:
                name, text = batch
                running.append(task.options(name=name).remote(text, cpus, *cache))
            if not running:
                return lost
            ready, _ = ray.wait(running, num_returns=1, fetch_local=False)
            records = ready[0]
            # Those that were not looked at for the longest time come first.
            running.remove(records)
            try:
                record = ray.get(next(records))
            except StopIteration:
                continue
            except ray.exceptions.RayTaskError as error:
                raise _failure(error) from None
            except ray.exceptions.RayError as error:
                lost.append(str(error))
                tell({"note": f"a task was lost: {str(error).splitlines()[0]}"})
                continue
            running.append(records)
            for event in campaign.keep(record):
                tell(event)
    finally:
        for records in running:
            ray.cancel(records)


def _records(batch: str, n_threads: int, truth_cache: str | None, truth_cache_mb: int) -> Iterator[str]:
    """The task: the records of a batch, each as soon as its run is done."""
    # No `yield from`: Ray sends values to the generator.
    for record in _native.BatchRuns(batch, n_threads, truth_cache, truth_cache_mb):
        yield record


def _failure(error: ray.exceptions.RayTaskError) -> NextviewError:
    """Tasks record runs that fail; if one fails itself, every other would do so, too."""
    cause = error.cause
    if isinstance(cause, NextviewError):
        return type(cause)(str(cause), cause.faults)
    return DataError(f"a worker cannot do its runs: {type(cause).__name__}: {cause}")


class _Progress:
    """Events as lines on stderr: every object, and from time to time how many runs are done."""

    PERIOD_S = 10.0

    def __init__(self, out: str) -> None:
        self._out, self._n_done, self._n_runs, self._told = out, 0, 0, time.monotonic()

    def __call__(self, event: dict[str, Any]) -> None:
        if began := event.get("began"):
            self._n_runs, self._n_done = began["n_runs"], began["n_finished"]
            before = f", {self._n_done} already done" if self._n_done else ""
            objects, runs = _counted(began["n_objects"], "object"), _counted(self._n_runs, "run")
            self._print(f"{objects}, {runs}{before}, in {self._out}")
        elif "run-finished" in event:
            self._n_done += 1
            if time.monotonic() - self._told > self.PERIOD_S:
                self._print(f"{self._n_done} of {_counted(self._n_runs, 'run')}")
        elif ended := event.get("object-finished"):
            failed = f", {ended['n_failed']} failed" if ended["n_failed"] else ""
            self._print(f"{ended['object']}: {_counted(ended['n_runs'], 'run')}{failed}")
        elif note := event.get("note"):
            self._print(f"note: {note}")

    def _print(self, line: str) -> None:
        self._told = time.monotonic()
        print(line, file=sys.stderr, flush=True)


def _counted(n: int, noun: str) -> str:
    return f"{n} {noun}{'' if n == 1 else 's'}"


def _main() -> int:
    parser = argparse.ArgumentParser(prog="python -m nextview.ray")
    about = "Do the runs of a campaign as Ray tasks; the same command resumes it."
    commands = parser.add_subparsers(required=True, metavar="bench")
    command = commands.add_parser("bench", help=about, description=about)
    add = command.add_argument
    add("spec", metavar="SPEC", help="a TOML file or the name of a built-in specification")
    add("meshes", metavar="MESH", nargs="*", help="objects instead of those of SPEC")
    add("--out", required=True, metavar="DIR", help="the campaign's folder, new or from an earlier start")
    add("--address", help="address of the cluster [default: RAY_ADDRESS, one that runs here, or a new one]")
    add("--cpus", type=int, default=1, metavar="N", help="CPUs and threads per task [default: 1]")
    retries = "repetitions of a task whose worker or node died, -1 for no limit [default: 3]"
    add("--retries", type=int, default=3, metavar="N", help=retries)
    workers = "number of workers for which the runs are split [default: as many as the cluster has CPUs for]"
    add("--workers", type=int, metavar="N", help=workers)
    cache = "folder that caches the true visibility of the objects, so that it is computed once"
    add("--truth-cache", metavar="DIR", help=cache)
    bound = "maximum size of that folder; the least recently used entries are removed [default: 4096]"
    add("--truth-cache-mb", type=int, default=4096, metavar="MB", help=bound)
    args = parser.parse_args()
    try:
        failed = bench(
            args.spec,
            args.meshes or None,
            out=args.out,
            address=args.address,
            cpus=args.cpus,
            retries=args.retries,
            workers=args.workers,
            truth_cache=args.truth_cache,
            truth_cache_mb=args.truth_cache_mb,
            on_event=_Progress(args.out),
        )
    except (NextviewError, ConnectionError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2 if isinstance(error, InputError) else 1
    except KeyboardInterrupt:
        print("interrupted; the same command resumes the campaign", file=sys.stderr)
        return 130
    for name, reason, n_runs in failed:
        print(f"error: {name} ({_counted(n_runs, 'run')} failed): {reason}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    # By the name under which workers import it.
    from nextview.ray import _main as main

    sys.exit(main())
