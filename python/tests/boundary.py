"""Every argument of every public callable, given every hostile value, each call in a process of its own.

The only answers are a result or an exception: no signal, no exit, no panic, no call that does not end. What
is called is read from the package's signatures, and the options from the schema of the configuration: an
argument that comes is tried without a word here. One that has no default needs a sound value in `SOUND`.

    python tests/boundary.py SCHEMA [--every N] [--only TEXT]
"""

from __future__ import annotations

import os

# A process that is forked has no threads: numpy's are never started.
os.environ.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1")

import argparse
import importlib
import inspect
import json
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from hostile_values import SHAPE, VALUES

import nextview

MODULES = ("nextview", "nextview.errors", "nextview.gym")
"""The public modules. Without `nextview.ray` and `nextview.rerun`, whose packages start threads or processes
when they are used; one that needs a package which is not installed is left out."""

ADDRESS_SPACE = 3 << 30
"""Memory that a call may ask for, bytes beside that of the parent: no argument is worth more."""

CPU_S, WALL_S = 30, 120
"""Time that a call may take."""

MOST_TEXT = 4_000_000
"""Characters of a message: the name of a file is in it as it was given."""

NO_RESULT = 10
"""Exit status of a process whose call ended with what is no exception of Python's."""

BOX = [[-0.1, -0.1, -0.1], [0.1, 0.1, 0.1]]
FEW: dict[str, Any] = {"candidates": 5, "voxel_size_m": 0.02, "views": 2}
SPEC: dict[str, Any] = {
    "name": "two",
    "objects": ["builtin:bracket"],
    "scan": {**FEW, "planner": "random", "baselines": False},
}


def camera() -> nextview.Camera:
    """A camera of few pixels."""
    return nextview.Camera(SHAPE[1], SHAPE[0], fx=7.0, fy=7.0, cx=3.5, cy=2.5)


def frame() -> Any:
    """A depth image of it."""
    return np.full(SHAPE, 0.3, np.float32)


def pose() -> Any:
    """Where it stands."""
    matrix = np.diag([1.0, -1.0, -1.0, 1.0])
    matrix[2, 3] = 0.4
    return matrix


def live() -> nextview.Scan:
    """A scan with a frame."""
    scan = nextview.Scan(camera(), BOX, **FEW)
    scan.observe(frame(), pose())
    return scan


def scene() -> nextview.SimulatedScene:
    """A simulated object before the camera."""
    return nextview.SimulatedScene("builtin:bracket", camera=camera(), **FEW)


def done(**options: Any) -> nextview.ScanResult:
    """A simulated scan."""
    return nextview.scan("builtin:bracket", camera=camera(), **{**FEW, "baselines": False, **options})


def grid() -> nextview.Map:
    """A map of eight voxels."""
    state, p = np.full((2, 2, 2), nextview.Map.OCCUPIED, np.uint8), np.full((2, 2, 2), 0.9, np.float32)
    return nextview.Map(state, p, np.zeros(3), 0.01)


def env() -> Any:
    """An episode that began."""
    made = importlib.import_module("nextview.gym").ViewPlanning(
        ["builtin:bracket"], n_candidates=5, cells=8, camera=camera()
    )
    made.reset(seed=1)
    return made


def saved() -> str:
    """A folder of results."""
    live().save("results")
    return "results"


class Answering(nextview.Planner):
    """A planner that answers what it was told."""

    answer: Any = None

    def plan(self, situation: nextview.Situation) -> Any:
        return self.answer


class Rating(nextview.Gain):
    """A gain that answers what it was told."""

    answer: Any = None

    def gain(self, situation: nextview.Situation, rays: nextview.Rays) -> Any:
        return self.answer


def planned(answer: Any, score: Any = 1.0) -> None:
    """What a planner in Python answers."""
    for given in (answer, (answer, score)):
        Answering.answer = given
        scan = nextview.Scan(camera(), BOX, planner=Answering, **FEW)
        scan.observe(frame(), scan.next_view())
        scan.next_view()


def rated(answer: Any, free_space: Any = "clear") -> None:
    """What a gain in Python answers, and how it sees."""
    Rating.answer, Rating.free_space = answer, free_space
    done(planner=Rating)


def map_saved(
    occupancy: Any = grid().occupancy,
    probability: Any = grid().probability,
    origin_m: Any = grid().origin_m,
    voxel_size_m: Any = 0.01,
) -> None:
    """A map of these arrays is saved."""
    nextview.Map(occupancy, probability, origin_m, voxel_size_m).save("map.ot")


def page_shown(html: Any, height_px: Any = 720) -> None:
    """A page of a notebook."""
    nextview.Page(html, height_px)._repr_html_()


def benched(**keys: Any) -> None:
    """A campaign with these keys in its specification."""
    nextview.bench({**SPEC, **keys}, jobs=1)


def unpickled(text: Any) -> None:
    """A view that was pickled as this."""
    view = nextview._native.view_of_text(text)
    for name in dir(view):
        getattr(view, name)


def used(**numbers: Any) -> None:
    """A camera of these numbers takes pictures, and scans."""
    arguments: dict[str, Any] = dict(zip(nextview._camera._KEYS, camera().numbers(), strict=True))
    own = nextview.Camera(**{**arguments, **numbers})
    nextview.SimulatedScene("builtin:bracket", camera=own, **FEW).capture(pose())
    nextview.Scan(own, BOX, **FEW).next_view()


KEYS: dict[str, Callable[[Any], list[str]]] = {
    "benched": lambda _: ["name", "seed", "seeds", "view_seeds", "first_views", "objects", "scan", "variant"],
    "used": lambda _: list(nextview._camera._KEYS),
}
"""The names that `**` takes, where they are no options."""

OWN = [planned, rated, map_saved, page_shown, benched, unpickled, used]
"""Calls that use what others only keep."""

RECEIVERS: dict[str, Callable[[], Any]] = {
    "Camera": camera,
    "Map": grid,
    "Scan": live,
    "ScanResult": done,
    "SimulatedScene": scene,
    "Gain": Rating,
    "ViewPlanning": env,
}
"""By class, an object whose methods are called."""

SOUND: dict[str, Callable[[], Any]] = {
    "Camera.width": lambda: SHAPE[1],
    "Camera.height": lambda: SHAPE[0],
    "Camera.fx": lambda: 7.0,
    "Camera.fy": lambda: 7.0,
    "Camera.cx": lambda: 3.5,
    "Camera.cy": lambda: 2.5,
    "Camera.of_sensor.name": lambda: "d405",
    "Camera.sensor.name": lambda: "d405",
    "Gain.begin.situation": lambda: None,
    "Scan.camera": camera,
    "Scan.box": lambda: BOX,
    "Scan.observe.depth": frame,
    "Scan.observe.world_from_camera": pose,
    "Scan.locate.depth": frame,
    "Scan.frame.step_idx": lambda: 0,
    "Scan.guidance.world_from_camera": pose,
    "Scan.skip.view": lambda: 1,
    "Scan.save.out": lambda: "saved",
    "Scan.turntable_pose.angle_deg": lambda: 10.0,
    "SimulatedScene.object": lambda: "builtin:bracket",
    "SimulatedScene.camera": camera,
    "SimulatedScene.capture.world_from_camera": pose,
    "SimulatedScene.frame.world_from_camera": pose,
    "SimulatedScene.reachable_coverage.views": lambda: [0, 1],
    "ViewPlanning.objects": lambda: ["builtin:bracket"],
    "ViewPlanning.step.action": lambda: 1,
    "Map.save.path": lambda: "map.bt",
    "Map.load.path": lambda: "map.bt",
    "bench.spec": lambda: SPEC,
    "bench.jobs": lambda: 1,
    "export.results": saved,
    "export.to": lambda: "tum",
    "export.out": lambda: "exported",
    "resume.out": lambda: "scan",
    "scan.object": lambda: "builtin:bracket",
    "scan.camera": camera,
    "log.scan": live,
    "log.out": lambda: "a.rrd",
    "log_folder.folder": saved,
    "log_folder.out": lambda: "a.rrd",
    "planned.answer": lambda: 1,
    "rated.answer": lambda: 1.0,
    "page_shown.html": lambda: "<p>",
    "unpickled.text": lambda: "{}",
}
"""Sound values of arguments that have no default, or whose default takes long."""

OPTIONS: dict[str, dict[str, Any]] = {
    "Scan": FEW,
    "SimulatedScene": FEW,
    "scan": {**FEW, "baselines": False},
}
"""Sound values of options."""


@dataclass(frozen=True)
class Argument:
    """An argument of something to call."""

    call: Callable[..., Any]
    receiver: Callable[[], Any] | None
    name: str
    key: str
    """A parameter, or with dots a key of the options."""
    required: tuple[str, ...]
    """The other parameters that need a value."""

    def __str__(self) -> str:
        return f"{self.name}({self.key})"

    def given(self, value: Any) -> Any:
        """Calls with this value."""
        arguments = {name: SOUND[f"{self.name}.{name}"]() for name in self.required}
        arguments.update(OPTIONS.get(self.name, {}))
        top, *rest = self.key.split(".")
        for part in reversed(rest):
            value = {part: value}
        arguments[top] = value
        if self.receiver is None:
            return self.call(**arguments)
        return self.call(self.receiver(), **arguments)


def callables() -> Iterator[tuple[str, Callable[..., Any], Callable[[], Any] | None]]:
    """The public callables by name, with the maker of the object they are methods of."""
    seen: set[Any] = set()
    for module_name in MODULES:
        try:
            module = importlib.import_module(module_name)
        except ImportError:
            print(f"{module_name}: SKIPPED, the package that it needs is not installed", file=sys.stderr)
            continue
        own = [name for name, value in vars(module).items() if getattr(value, "__module__", "") == module_name]
        for name in getattr(module, "__all__", [name for name in own if not name.startswith("_")]):
            value = getattr(module, name)
            if not callable(value) or value in seen:
                continue
            seen.add(value)
            if not isinstance(value, type):
                yield name, value, None
                continue
            if not inspect.isabstract(value) and has_signature(value):
                yield name, value, None
            yield from methods(name, value)
    for own in OWN:
        yield own.__name__, own, None


def methods(name: str, cls: type) -> Iterator[tuple[str, Callable[..., Any], Callable[[], Any] | None]]:
    """The public methods of a class that are ours."""
    for attribute in dir(cls):
        owner = next((base for base in cls.__mro__ if attribute in vars(base)), object)
        if attribute.startswith("_") or not owner.__module__.startswith("nextview"):
            continue
        value = vars(owner)[attribute]
        if isinstance(value, classmethod | staticmethod):
            yield f"{name}.{attribute}", getattr(cls, attribute), None
        elif inspect.isroutine(value) and not getattr(value, "__isabstractmethod__", False):
            if len(inspect.signature(value).parameters) > 1:
                yield f"{name}.{attribute}", value, RECEIVERS[name]


def has_signature(value: Any) -> bool:
    """Whether it can be called at all: native classes without a constructor cannot."""
    try:
        inspect.signature(value)
    except ValueError:
        return False
    return True


def arguments(options: list[str]) -> list[Argument]:
    """Everything that is given to something public."""
    found = []
    missing = []
    for name, call, receiver in callables():
        parameters = list(inspect.signature(call).parameters.values())[receiver is not None :]
        plain = [p for p in parameters if p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)]
        is_kept = hasattr(call, "__dataclass_fields__") or hasattr(call, "_fields")
        for p in plain:
            place = f"{name}.{p.name}"
            if p.default is p.empty and place not in SOUND:
                SOUND[place] = lambda: None
                if not is_kept:
                    missing.append(place)
        needed = [p.name for p in plain if f"{name}.{p.name}" in SOUND]
        keys = [p.name for p in plain]
        if any(p.kind is p.VAR_KEYWORD for p in parameters):
            keys += KEYS[name](call) if name in KEYS else [key for key in options if key not in keys]
        for key in keys:
            found.append(Argument(call, receiver, name, key, tuple(n for n in needed if n != key)))
    if missing:
        sys.exit(f"SOUND has no value for {', '.join(missing)}")
    return found


def keys_of(schema: dict[str, Any]) -> list[str]:
    """The keys of a configuration, dotted, sections included."""

    def below(part: dict[str, Any], key: str) -> Iterator[str]:
        if "$ref" in part:
            yield from below(schema["$defs"][part["$ref"].rsplit("/", 1)[1]], key)
        for each in (*part.get("anyOf", ()), *part.get("oneOf", ())):
            yield from below(each, key)
        for name, inner in part.get("properties", {}).items():
            below_key = f"{key}.{name}" if key else name
            yield below_key
            yield from below(inner, below_key)

    return sorted(set(below(schema, "")))


def call(argument: Argument, value: str, folder: Path) -> None:
    """The life of a process: the call, and its end as the exit status."""
    os.chdir(folder)
    out = os.open("printed", os.O_WRONLY | os.O_CREAT)
    os.dup2(out, 1)
    os.dup2(out, 2)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + ADDRESS_SPACE, used + ADDRESS_SPACE))
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_S, CPU_S + 5))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    status = 0
    try:
        argument.given(VALUES[value]())
    except nextview.InternalError:
        traceback.print_exc()
        status = NO_RESULT
    except Exception as error:
        # Its text can be shown, and is at most a few times that of the longest value.
        if isinstance(error, nextview.NextviewError) and len(str(error)) > MOST_TEXT:
            print(f"a message of {len(str(error))} characters")
            status = NO_RESULT
    except BaseException:
        traceback.print_exc()
        status = NO_RESULT
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


def ending(status: int, is_late: bool) -> str | None:
    """What is wrong with the end of a process."""
    if is_late:
        return f"did not end within {WALL_S} s"
    if os.WIFSIGNALED(status):
        return f"ended by {signal.Signals(os.WTERMSIG(status)).name}"
    code = os.waitstatus_to_exitcode(status)
    if code == NO_RESULT:
        return "no exception of Python's, or one that says nothing"
    return None if code == 0 else f"exit status {code}"


def run(cases: list[tuple[Argument, str]], folder: Path, jobs: int) -> list[str]:
    """Does the calls, some beside each other; what was wrong."""
    wrong: list[str] = []
    running: dict[int, tuple[int, float]] = {}
    late: set[int] = set()
    slowest = (0.0, "")
    numbered = iter(enumerate(cases))
    n_done = 0
    while True:
        while len(running) < jobs and (case := next(numbered, None)) is not None:
            number, (argument, value) = case
            own = folder / str(number)
            own.mkdir()
            pid = os.fork()
            if pid == 0:
                call(argument, value, own)
            running[pid] = (number, time.monotonic())
        if not running:
            print(f"slowest: {slowest[0]:.1f} s, {slowest[1]}", file=sys.stderr)
            return wrong
        pid, status = os.waitpid(-1, os.WNOHANG)
        if pid == 0:
            for each, (_, began) in running.items():
                if time.monotonic() - began > WALL_S and each not in late:
                    late.add(each)
                    os.kill(each, signal.SIGKILL)
            time.sleep(0.001)
            continue
        number, began = running.pop(pid)
        argument, value = cases[number]
        slowest = max(slowest, (time.monotonic() - began, f"{argument} = {value}"))
        problem = ending(status, pid in late)
        if problem is not None:
            printed = (folder / str(number) / "printed").read_text(errors="replace")
            wrong.append(f"{argument} = {value}: {problem}\n{printed[-2000:]}")
            print(wrong[-1], file=sys.stderr)
        shutil.rmtree(folder / str(number), ignore_errors=True)
        late.discard(pid)
        n_done += 1
        if n_done % 1000 == 0:
            print(f"{n_done} of {len(cases)}", file=sys.stderr)


def main() -> int:
    """Runs the calls; 1 if any ended otherwise than by a result or an exception."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("schema", type=Path, help="the schema of the configuration")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="only every Nth call [default: 1]")
    parser.add_argument("--only", default="", metavar="TEXT", help="only calls whose name has this text")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), metavar="N", help="calls at once")
    given = parser.parse_args()
    every = arguments(keys_of(json.loads(given.schema.read_text())))
    cases = [(argument, value) for argument in every for value in VALUES]
    cases = [case for case in cases if given.only in f"{case[0]} = {case[1]}"][:: given.every]
    begin = time.monotonic()
    folder = Path(tempfile.mkdtemp(prefix="nextview-boundary-"))
    try:
        wrong = run(cases, folder, given.jobs)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    n_arguments = len({str(argument) for argument, _ in cases})
    print(
        f"{len(cases)} calls, {n_arguments} arguments, {len(VALUES)} values, "
        f"{time.monotonic() - begin:.0f} s: {len(wrong)} ended otherwise than by a result or an exception"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
