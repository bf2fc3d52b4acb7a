#!/usr/bin/env python3
"""Kills the program again and again, at any instant, and compares the results with those of undisturbed runs.

    .ci/soak.py target/release/nextview [--kills 1000] [--seed 1]

A third each of the kills (SIGKILL) is for scans, for campaigns and for a server to which frames are posted. What was
killed is resumed, and killed again, until it is done; then its files must be those of an undisturbed run, byte for
byte, except for the times in some of them and the end of a journal that a kill cut off. Nothing that was acknowledged
may be lost: a frame that a scan printed or that the server answered, a run that a campaign stored. A frame that is
sent again with its id must count once. Prints one table; fails if anything was lost or differs.
"""

import argparse
import http.client
import json
import math
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

CAMERA = "{ width = 80, height = 60, fx = 75, fy = 75, cx = 39.5, cy = 29.5 }"
SCAN = f"""\
views = 6
candidates = 40
voxel_size_m = 0.01
baselines = false
noise = {{ model = "d435i", pose_error_mm = 1 }}
camera = {CAMERA}
"""
CAMPAIGN = f"""\
name = "soak"
objects = ["builtin:bracket", "builtin:mug"]
seeds = [0, 1, 2]
[scan]
planner = "local"
views = 4
candidates = 40
voxel_size_m = 0.01
baselines = false
camera = {CAMERA}
"""
# Of a server's scan: its camera has a pixel for every 14 mm of the object.
WIDTH, HEIGHT, FOCAL = 32, 24, 30.0
LIVE = {
    "object": "ball",
    "views": 5,
    "candidates": 40,
    "voxel_size_m": 0.01,
    "live": {"box_m": [-0.08, -0.08, -0.08, 0.08, 0.08, 0.08]},
    "camera": {"width": WIDTH, "height": HEIGHT, "fx": FOCAL, "fy": FOCAL, "cx": WIDTH / 2 - 0.5, "cy": HEIGHT / 2 - 0.5},
}
# Files that hold times, and so are never the same.
TIMED = {"record.json", "steps.jsonl", "report.html", "runs.jsonl", "times.csv", "times.parquet"}


class Row:
    """What happened to a command."""

    def __init__(self, command):
        self.command = command
        self.kills = self.done = self.acknowledged = self.lost = self.differing = 0


def is_cut_end(path):
    """Whether resuming moved bytes there that are one entry of a journal, cut off by a kill during its write."""
    if not path.match("scan.journal.damaged-*"):
        return False
    entry = path.read_bytes()
    return len(entry) < 8 or len(entry) < 8 + struct.unpack_from("<I", entry)[0]


def files(folder):
    """The content of all files without times, by their paths."""
    paths = (path for path in folder.rglob("*") if path.is_file() and path.name not in TIMED and not is_cut_end(path))
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def n_differing(folder, whole):
    """1 if the files of a folder are not these, else 0; prints which ones differ."""
    found = files(folder)
    names = sorted(name for name in found.keys() | whole.keys() if found.get(name) != whole.get(name))
    for name in names:
        what = "differs" if name in found and name in whole else "is missing" if name in whole else "is new"
        print(f"{folder / name} {what}", file=sys.stderr)
    return int(bool(names))


def killed(command, printed, is_time, seconds):
    """Starts it and kills it so long after it is time: whether it had finished before. What it prints goes to a file."""
    with printed.open("w") as out:
        process = subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT)
    while process.poll() is None and not is_time():
        time.sleep(0.002)
    try:
        if process.wait(timeout=seconds) != 0:
            sys.exit(f"{command} failed: {printed.read_text()}")
        return True
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        return False


def n_frames(printed):
    """Number of frames that a scan printed; a line that a kill cut says nothing."""
    text = printed.read_text()
    whole = text[: text.rfind("\n") + 1]
    return len(re.findall(r"^ +\d+ +\d+ .*%", whole, re.MULTILINE))


def instant(rng, seconds):
    """How many more frames or runs to wait for, and then how long: one in four kills comes at any time at all."""
    return (0, rng.uniform(0.0, seconds)) if rng.random() < 0.25 else (rng.randint(1, 2), rng.uniform(0.0, 0.1 * seconds))


class Scans:
    """Scans, one after the other."""

    def __init__(self, program, work):
        self.first, self.again = Row("scan"), Row("scan --resume")
        (work / "scan.toml").write_text(SCAN)
        self.out, self.printed = work / "scan", work / "printed"
        self.begin = [program, "scan", "builtin:bracket", "--config", work / "scan.toml", "--out"]
        self.resume = [program, "scan", "--resume", self.out]
        start = time.monotonic()
        subprocess.run([*self.begin, work / "whole-scan"], check=True, stdout=subprocess.DEVNULL)
        self.seconds = time.monotonic() - start
        self.whole = files(work / "whole-scan")
        self.known = 0

    def kill_once(self, rng):
        is_resumed = (self.out / "scan.journal").exists()
        if not is_resumed and self.out.exists():
            shutil.rmtree(self.out)
        row = self.again if is_resumed else self.first
        command = self.resume if is_resumed else [*self.begin, self.out]
        n_more, seconds = instant(rng, self.seconds)
        is_done = killed(command, self.printed, lambda: n_frames(self.printed) >= self.known + n_more, seconds)
        told = re.search(r"resuming after (\d+) frame", self.printed.read_text())
        if told:
            row.lost += max(self.known - int(told[1]), 0)
        known = max(n_frames(self.printed), self.known)
        row.acknowledged += known - self.known
        self.known = known
        row.kills += not is_done
        # A kill may also come after the results are written and the journal is gone.
        if not (self.out / "scan.journal").exists():
            if is_done or self.known:
                row.done += 1
                row.differing += n_differing(self.out, self.whole)
            self.known = 0
            shutil.rmtree(self.out, ignore_errors=True)

    def finish(self):
        if self.out.exists():
            subprocess.run(self.resume, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.again.done += 1
            self.again.differing += n_differing(self.out, self.whole)


class Campaigns:
    """Campaigns, one after the other; what is acknowledged are the frames of stored runs."""

    VIEWS = 4

    def __init__(self, program, work):
        self.first, self.again = Row("bench"), Row("bench --resume")
        (work / "spec.toml").write_text(CAMPAIGN)
        self.out, self.printed = work / "bench", work / "printed"
        # The objects' truth is computed once, so that kills fall into the runs.
        cache = ["--truth-cache", work / "truth"]
        self.begin = [program, "bench", work / "spec.toml", "--jobs", "1", *cache, "--out"]
        self.resume = [program, "bench", "--resume", "--jobs", "1", *cache, "--out", self.out]
        for folder in ("warm", "whole-bench"):
            start = time.monotonic()
            subprocess.run([*self.begin, work / folder], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.seconds = time.monotonic() - start
        self.whole = files(work / "whole-bench")
        self.known = []

    def stored(self):
        """The runs that are stored as a whole."""
        path = self.out / "runs.jsonl"
        return path.read_bytes().split(b"\n")[:-1] if path.exists() else []

    def check(self, row, is_done):
        runs = self.stored()
        row.lost += self.VIEWS * sum(a != b for a, b in zip(self.known, runs + [None] * len(self.known)))
        row.acknowledged += self.VIEWS * max(len(runs) - len(self.known), 0)
        self.known = runs
        if is_done:
            row.done += 1
            row.differing += n_differing(self.out, self.whole)
            self.known = []
            shutil.rmtree(self.out)

    def kill_once(self, rng):
        is_resumed = (self.out / "runs.jsonl").exists()
        if not is_resumed:
            shutil.rmtree(self.out, ignore_errors=True)
        row = self.again if is_resumed else self.first
        command = self.resume if is_resumed else [*self.begin, self.out]
        n_more, seconds = instant(rng, self.seconds)
        is_done = killed(command, self.printed, lambda: len(self.stored()) >= len(self.known) + n_more, seconds)
        row.kills += not is_done
        self.check(row, is_done)

    def finish(self):
        if (self.out / "runs.jsonl").exists():
            subprocess.run(self.resume, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.check(self.again, True)


def depth_of(rows):
    """What a camera there sees of a ball with a knob, metres, infinite beside them."""
    position = [rows[i][3] for i in range(3)]
    balls = (((0.0, 0.0, 0.0), 0.05), ((0.0, 0.04, 0.03), 0.03))
    pixels = []
    for v in range(HEIGHT):
        for u in range(WIDTH):
            ray = ((u - WIDTH / 2 + 0.5) / FOCAL, (v - HEIGHT / 2 + 0.5) / FOCAL, 1.0)
            along = [sum(rows[i][j] * ray[j] for j in range(3)) for i in range(3)]
            nearest = math.inf
            for center, radius in balls:
                to = [c - p for c, p in zip(center, position)]
                a, b = sum(x * x for x in along), sum(x * y for x, y in zip(along, to))
                root = b * b - a * (sum(x * x for x in to) - radius**2)
                if root > 0.0:
                    nearest = min(nearest, (b - math.sqrt(root)) / a)
            pixels.append(nearest)
    return struct.pack(f"<{len(pixels)}f", *pixels)


class Client:
    """A client of the server at this address."""

    def __init__(self, address):
        self.connection = http.client.HTTPConnection(address.removeprefix("http://"), timeout=60)

    def ask(self, method, path, body=None, kind="application/json"):
        headers = {"content-type": kind} if body is not None else {}
        self.connection.request(method, path, body, headers)
        answer = self.connection.getresponse()
        return answer.status, answer.read()

    def json(self, method, path, body=None, kind="application/json", status=200):
        found, answer = self.ask(method, path, body, kind)
        if found != status:
            sys.exit(f"{method} {path}: {found} {answer.decode()}, expected {status}")
        return json.loads(answer)


class Servers:
    """A server that takes one scan after the other."""

    RESULTS = ("map.ot", "map.bt", "cloud.ply", "mesh.ply", "views.csv")

    def __init__(self, program, work):
        self.first = self.again = Row("serve")
        self.command = [program, "serve", "--listen", "127.0.0.1:0", "--dir"]
        self.dir = work / "serve"
        # Of the scan under way: frames that were answered, and the pose of one that was sent but not answered.
        self.n_scans, self.acknowledged, self.pending = 0, 0, None
        process, client = self.start(work / "whole-serve")
        self.whole = None
        self.drive(client)
        process.kill()
        process.communicate()
        self.first.done = self.first.acknowledged = 0

    def start(self, folder):
        process = subprocess.Popen([*self.command, folder], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        line = process.stdout.readline()
        return process, Client(line.removeprefix("listening on ").strip()) if line else None

    def kill_once(self, rng):
        process, client = self.start(self.dir)
        n_more, seconds = instant(rng, 0.5)
        killer = threading.Thread(target=self.kill_when, args=(process, self.first.acknowledged + n_more, seconds))
        killer.start()
        try:
            while True:
                self.drive(client)
        except (OSError, http.client.HTTPException):
            pass  # the kill
        killer.join()
        process.communicate()
        self.first.kills += 1

    def kill_when(self, process, n_acknowledged, seconds):
        while self.first.acknowledged < n_acknowledged and process.poll() is None:
            time.sleep(0.002)
        time.sleep(seconds)
        process.kill()

    def drive(self, client):
        """One scan, from where it is to its results."""
        scan = f"/scans/ball-{self.n_scans}"
        status, answer = client.ask("POST", "/scans", json.dumps({"id": f"ball-{self.n_scans}", **LIVE}))
        if status not in (201, 409):
            sys.exit(f"POST /scans: {status} {answer.decode()}")
        n = client.json("GET", scan)["n_frames"]
        self.first.lost += max(self.acknowledged - n, 0)
        if n > self.acknowledged + 1:
            sys.exit(f"{scan}: {n} frames, {self.acknowledged} acknowledged: one was counted twice")
        if self.pending:
            self.post(client, scan, self.pending, n > self.acknowledged)
        while (view := client.json("GET", f"{scan}/next"))["state"] == "view":
            self.pending = view["view"]["world_from_camera"]
            self.post(client, scan, self.pending, False)
        client.json("POST", f"{scan}/finish")
        results = {name: client.ask("GET", f"{scan}/files/{name}")[1] for name in self.RESULTS}
        if self.whole is None:
            self.whole = results
        self.first.differing += results != self.whole
        self.first.done += 1
        # First the count: the answer to the deletion may be lost, too.
        self.n_scans, self.acknowledged = self.n_scans + 1, 0
        client.ask("DELETE", scan)

    def post(self, client, scan, pose, is_there):
        """Sends a frame; where the answer to it was lost, once more under the same id."""
        numbers = ",".join(repr(number) for row in pose for number in row)
        query = {"id": f"frame-{self.acknowledged}", "world_from_camera": numbers, "width": WIDTH, "height": HEIGHT}
        path = f"{scan}/frames?{urllib.parse.urlencode({**query, 'dtype': 'f32'})}"
        answer = client.json("POST", path, depth_of(pose), "application/octet-stream")
        if answer["duplicate"] != is_there:
            sys.exit(f"{scan}: frame {self.acknowledged}: duplicate is {answer['duplicate']}, expected {is_there}")
        self.acknowledged += 1
        self.first.acknowledged += 1
        self.pending = None

    def finish(self):
        process, client = self.start(self.dir)
        self.drive(client)
        process.kill()
        process.communicate()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    rng = random.Random(args.seed)
    start = time.monotonic()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        kinds = (Scans, Campaigns, Servers)
        for i, kind in enumerate(kinds):
            victim = kind(args.program.resolve(), pathlib.Path(folder))
            n_kills = args.kills * (i + 1) // len(kinds) - args.kills * i // len(kinds)
            of_kind = list(dict.fromkeys((victim.first, victim.again)))
            while sum(row.kills for row in of_kind) < n_kills:
                victim.kill_once(rng)
            victim.finish()
            rows += of_kind
    print("| command | kills | runs finished | frames acknowledged | frames lost | results that differ |")
    print("|---|---|---|---|---|---|")
    for row in rows:
        numbers = (row.kills, row.done, row.acknowledged, row.lost, row.differing)
        print(f"| `{row.command}` | {' | '.join(map(str, numbers))} |")
    n_kills, seconds = sum(row.kills for row in rows), time.monotonic() - start
    print(f"\n{n_kills} kills in {seconds:.0f} s, seed {args.seed}")
    if any(row.lost or row.differing for row in rows):
        sys.exit("something was lost or differs")


if __name__ == "__main__":
    main()
