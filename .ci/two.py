#!/usr/bin/env python3
"""Two processes on one folder, killed at any instant: no acknowledged frame may be lost.

    .ci/two.py target/release/nextview [--rounds 1000] [--seed 1] [--python PYTHON]

Each round starts two processes on the same folder at nearly the same time, two servers, a server and a program, two
programs, or a server and Python, and kills both (SIGKILL) at random instants, one after the other. Then the journal
is read here, without nextview: it must hold every frame that either of them acknowledged. One of the two must refuse
and give the reason. Scans that finish must have the results of an undisturbed one. Prints a table; fails if anything
was lost or differs. Server and Python needs an interpreter with the package, or it is skipped.
"""

import argparse
import http.client
import json
import pathlib
import random
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import threading
import time
import urllib.parse
import zlib

import soak

# What the second of two may say, and nothing else.
REFUSALS = re.compile(
    r"is in use by a running scan|it is already open|holds an interrupted scan|holds no interrupted scan|already holds results"
    r"|frames of this scan come from a user's camera|is already served by another server|holds a scan of simulated or recorded frames"
)


def kept(folder):
    """The frames on the disk, in their order: of a journal the heads of its entries, of results their steps."""
    path, steps = folder / "scan.journal", folder / "steps.jsonl"
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        lines = steps.read_text().splitlines() if steps.exists() else []
        return [{"view": step["view"], "name": step.get("frame")} for step in map(json.loads, lines)]
    if data[:8] != b"nvframes":
        sys.exit(f"{path} is not a journal")
    frames, at, number = [], 8, 0
    while at + 8 <= len(data):
        length, checksum = struct.unpack_from("<II", data, at)
        content = data[at + 8 : at + 8 + length]
        if len(content) < length or zlib.crc32(number.to_bytes(8, "little") + content) != checksum:
            break  # cut off by a kill
        if number:
            head = json.loads(content[5 : 5 + struct.unpack_from("<I", content, 1)[0]])
            frames += [{"name": None, **head["frame"]}] if "frame" in head else []
        at, number = at + 8 + length, number + 1
    return frames


class Row:
    """What happened to a pair."""

    def __init__(self, name):
        self.name = name
        self.rounds = self.acknowledged = self.lost = self.refused = self.both = self.done = self.differing = 0


class Process:
    """A process whose output goes to files."""

    def __init__(self, command, work, name):
        self.out, self.err = work / f"{name}.out", work / f"{name}.err"
        with self.out.open("w") as out, self.err.open("w") as err:
            self.process = subprocess.Popen(command, stdout=out, stderr=err, stdin=subprocess.DEVNULL)

    def kill(self):
        """Its exit code; none if it was killed."""
        code = self.process.poll()
        self.process.kill()
        self.process.wait()
        return code

    def was_refused(self, code):
        """Whether it ended because the folder is taken; anything else that ends it is a fault."""
        if code in (None, 0):
            return False
        said = self.err.read_text()
        if code not in (1, 2) or not REFUSALS.search(said) or "panicked" in said:
            sys.exit(f"{self.process.args} ended with {code}: {said}")
        return True


def pause(rng, seconds):
    time.sleep(rng.uniform(0.0, seconds))


class Programs:
    """Two programs: both begin a scan, or resume it, or one each."""

    def __init__(self, program, work, python):
        self.row, self.work, self.out = Row("program, program"), work, work / "scan"
        (work / "scan.toml").write_text(soak.SCAN)
        self.begin = [program, "scan", "builtin:bracket", "--config", work / "scan.toml", "--out"]
        self.resume = [program, "scan", "--resume", self.out]
        start = time.monotonic()
        subprocess.run([*self.begin, work / "whole"], check=True, stdout=subprocess.DEVNULL)
        self.seconds = time.monotonic() - start
        self.whole, self.known = soak.files(work / "whole"), []

    def round(self, rng):
        is_begun = (self.out / "scan.journal").exists()
        commands = [self.resume if is_begun and rng.random() < 0.8 else [*self.begin, self.out] for _ in range(2)]
        processes = []
        for i, command in enumerate(commands):
            processes.append(Process(command, self.work, f"program-{i}"))
            pause(rng, rng.choice((0.0, 0.02)))
        rng.shuffle(processes)
        pause(rng, 1.2 * self.seconds)
        codes = [processes[0].kill()]
        pause(rng, 0.3 * self.seconds)
        codes.append(processes[1].kill())
        refused = [process.was_refused(code) for process, code in zip(processes, codes)]
        self.row.refused += sum(refused)
        acknowledged = [self.printed(process) for process in processes]
        acknowledged.sort(key=len)
        views, known = [frame["view"] for frame in kept(self.out)], len(self.known)
        for printed in (self.known, *acknowledged):
            self.row.lost += sum(view != found for view, found in zip(printed, views + [None] * len(printed)))
        self.known = max(self.known, acknowledged[-1], key=len)
        self.row.acknowledged += len(self.known) - known
        self.row.rounds += 1
        if (self.out / "record.json").exists() and not (self.out / "scan.journal").exists():
            self.row.done += 1
            self.row.differing += soak.n_differing(self.out, self.whole)
            self.reset()
        elif not views:
            self.reset()

    def printed(self, process):
        """The views of the frames that it printed as a whole."""
        text = process.out.read_text()
        steps = re.findall(r"^ +\d+ +(\d+) .*%", text[: text.rfind("\n") + 1], re.MULTILINE)
        return [int(view) for view in steps]

    def reset(self):
        self.known = []
        shutil.rmtree(self.out, ignore_errors=True)


class Servers:
    """A server that takes one scan after the other, and another process on its folder."""

    NAME = "server, server"

    def __init__(self, program, work, python):
        self.program, self.python, self.work, self.dir = program, python, work, work / "scans"
        self.row, self.n_scans, self.acknowledged, self.clients = Row(self.NAME), 0, [], []
        self.whole = None

    @property
    def scan(self):
        return self.dir / f"ball-{self.n_scans}"

    def serve(self, name):
        return Process([self.program, "serve", "--listen", "127.0.0.1:0", "--dir", self.dir], self.work, name)

    def other(self, rng):
        return self.serve("other")

    def round(self, rng):
        start = [lambda: self.serve("server"), lambda: self.other(rng)]
        if rng.random() < 0.5:
            start.reverse()
        processes = []
        for begin in start:
            processes.append(begin())
            pause(rng, rng.choice((0.0, 0.05, 0.5)))
        clients = [threading.Thread(target=self.drive, args=(process,)) for process in processes if self.is_server(process)]
        for client in clients:
            client.start()
        rng.shuffle(processes)
        codes = []
        for process in processes:
            self.wait(rng)
            codes.append(process.kill())
        for client in clients:
            client.join()
        listening = sum("listening on" in process.out.read_text() for process in processes if self.is_server(process))
        self.row.both += listening == 2
        self.row.refused += sum(process.was_refused(code) for process, code in zip(processes, codes))
        self.note_others(processes)
        names = [frame["name"] for frame in kept(self.scan) if frame["name"]]
        self.row.lost += sum(name not in names for name in self.acknowledged)
        if len(set(names)) < len(names):
            sys.exit(f"{self.scan}: {names}: one was counted twice")
        self.row.rounds += 1
        if self.scan.exists() and not (self.scan / "scan.journal").exists() and (self.scan / "record.json").exists():
            self.check_results()

    def wait(self, rng):
        """Until a kill: one in four comes at any time at all, the others after some more frames."""
        if rng.random() < 0.25:
            return pause(rng, 0.5)
        enough, end = self.progress() + rng.randint(1, 2), time.monotonic() + 2.0
        while self.progress() < enough and time.monotonic() < end:
            time.sleep(0.002)
        pause(rng, 0.03)

    def progress(self):
        return self.row.acknowledged

    def is_server(self, process):
        return "serve" in process.process.args

    def note_others(self, processes):
        """Frames that the other one acknowledged, if it does so by itself."""

    def check_results(self):
        """All scans are of the same frames, and so are their results."""
        results = {name: (self.scan / name).read_bytes() for name in soak.Servers.RESULTS}
        self.whole = self.whole or results
        self.row.differing += results != self.whole
        self.row.done += 1
        self.next_scan()

    def next_scan(self):
        self.n_scans, self.acknowledged = self.n_scans + 1, []

    def drive(self, process):
        """Posts frames until it is killed, or the scan is finished."""
        try:
            while process.process.poll() is None:
                found = re.search(r"listening on (\S+)\n", process.out.read_text())
                if found:
                    return self.post_all(soak.Client(found[1]))
                time.sleep(0.002)
        except (OSError, http.client.HTTPException, json.JSONDecodeError):
            pass  # the kill

    def post_all(self, client):
        name = self.scan.name
        body = json.dumps({"id": name, **soak.LIVE})
        while True:
            status, answer = client.ask("POST", "/scans", body)
            if status == 201 or (status == 409 and client.ask("GET", f"/scans/{name}")[0] == 200):
                break
            if status not in (404, 409):
                sys.exit(f"POST /scans: {status} {answer.decode()}")
            time.sleep(0.01)
        while True:
            status, answer = client.ask("GET", f"/scans/{name}/next")
            if status != 200:
                # The other process has the scan, or it is finished.
                said = answer.decode()
                if not REFUSALS.search(said) and "is finished" not in said and "while the scan was under way" not in said:
                    sys.exit(f"GET next: {status} {said}")
                time.sleep(0.005)
                continue
            view = json.loads(answer)
            if view["state"] != "view":
                client.ask("POST", f"/scans/{name}/finish")
                return
            self.post(client, name, view["view"])

    def post(self, client, scan, view):
        numbers = ",".join(repr(number) for row in view["world_from_camera"] for number in row)
        frame = f"view-{view['view']}"
        query = {"id": frame, "world_from_camera": numbers, "width": soak.WIDTH, "height": soak.HEIGHT, "dtype": "f32"}
        path = f"/scans/{scan}/frames?{urllib.parse.urlencode(query)}"
        depth = soak.depth_of(view["world_from_camera"])
        status, answer = client.ask("POST", path, depth, "application/octet-stream")
        if status == 200 and frame not in self.acknowledged:
            self.acknowledged.append(frame)
            self.row.acknowledged += 1
        elif status != 200 and not REFUSALS.search(answer.decode()):
            sys.exit(f"POST {path}: {status} {answer.decode()}")


class ServerAndProgram(Servers):
    """A program that begins or resumes a scan in the folder of one of the server's."""

    NAME = "server, program"

    def other(self, rng):
        if rng.random() < 0.5:
            return Process([self.program, "scan", "--resume", self.scan], self.work, "other")
        config = self.work / "other.toml"
        config.write_text(soak.SCAN)
        more = ["--force"] if (self.scan / "scan.journal").exists() and self.acknowledged else []
        command = [self.program, "scan", "builtin:bracket", "--config", config, "--out", self.scan, *more]
        return Process(command, self.work, "other")

    def round(self, rng):
        super().round(rng)
        # The program may have the folder as long as the scan has no frames.
        heading = self.scan / "scan.journal"
        if heading.exists() and b"builtin:bracket" in heading.read_bytes()[:4096]:
            self.next_scan()

    def check_results(self):
        if 'object = "ball"' in (self.scan / "config.toml").read_text():
            super().check_results()
        else:
            self.next_scan()


class ServerAndPython(Servers):
    """A program in Python that resumes the server's scan and takes frames, too."""

    NAME = "server, Python"
    TAKE = """\
import sys, warnings
import numpy as np
import nextview, soak
warnings.simplefilter("ignore")
try:
    scan = nextview.resume(sys.argv[1])
except nextview.DataError as error:
    sys.exit(f"{error}")
while (view := scan.next_view()) is not None:
    pose = view.world_from_camera
    depth = np.frombuffer(soak.depth_of(pose.tolist()), "<f4").reshape(soak.HEIGHT, soak.WIDTH)
    scan.observe(depth, world_from_camera=pose)  # as a client of the server states it, to the bit
    print(len(scan.steps), flush=True)
"""

    def other(self, rng):
        (self.work / "take.py").write_text(f"import sys\nsys.path.append({str(pathlib.Path(__file__).parent)!r})\n{self.TAKE}")
        return Process([self.python, self.work / "take.py", self.scan], self.work, "other")

    def note_others(self, processes):
        for process in processes:
            if not self.is_server(process):
                lines = process.out.read_text().split("\n")[:-1]
                self.row.acknowledged += len(lines)
                self.n_frames = max([self.n_frames, *map(int, lines)])
        self.row.lost += max(self.n_frames - len(kept(self.scan)), 0)

    # As Python counted them.
    n_frames = 0

    def progress(self):
        printed = self.work / "other.out"
        return self.row.acknowledged + (printed.read_text().count("\n") if printed.exists() else 0)

    def next_scan(self):
        self.n_frames = 0
        super().next_scan()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--python", type=pathlib.Path, help="an interpreter with the package nextview")
    args = parser.parse_args()
    rng = random.Random(args.seed)
    start = time.monotonic()
    kinds = [Servers, ServerAndProgram, Programs]
    if args.python:
        kinds.append(ServerAndPython)
    else:
        print("SKIPPED server and Python: --python names no interpreter", file=sys.stderr)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        pairs = []
        for kind in kinds:
            work = pathlib.Path(folder) / kind.__name__
            work.mkdir()
            pairs.append(kind(args.program.absolute(), work, args.python))
        for i in range(args.rounds):
            pairs[i % len(pairs)].round(rng)
        rows = [pair.row for pair in pairs]
    print(f"{'pair':<18}{'rounds':>8}{'refused':>9}{'frames acknowledged':>21}{'lost':>6}{'finished':>10}{'differing':>11}")
    for row in rows:
        print(
            f"{row.name:<18}{row.rounds:>8}{row.refused:>9}{row.acknowledged:>21}{row.lost:>6}{row.done:>10}{row.differing:>11}"
        )
    print(f"seed {args.seed}, {time.monotonic() - start:.0f} s")
    both = sum(row.both for row in rows)
    if both:
        sys.exit(f"{both} times, two servers served one folder")
    if sum(row.lost + row.differing for row in rows):
        sys.exit("something was lost or differs")
    if any(row.rounds > 20 and not row.refused for row in rows):
        sys.exit("no process was ever refused: the two did not meet")


if __name__ == "__main__":
    main()
