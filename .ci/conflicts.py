#!/usr/bin/env python3
"""Sends pairs of requests that conflict to a server, which is then killed and started again.

    .ci/conflicts.py target/release/nextview [--pairs 10000] [--seed 1]

The requests of a pair are sent by two threads, the second a little later or earlier than the first: the
delays sweep from -4 to 4 ms. Many pairs, each with its own scans, are sent to one server, which is then killed
(SIGKILL), while requests are under way in every second round. After the restart, every frame that was acknowledged
must be there and count once, every scan that was acknowledged and not deleted must answer, with the scan that it
continues, and no scan whose deletion was acknowledged may be back. Prints a table of all pairs with their answers;
fails if anything was lost, or if an answer is not one that a client could expect.
"""

import argparse
import collections
import concurrent.futures
import http.client
import json
import pathlib
import random
import struct
import subprocess
import sys
import tempfile
import threading
import time

WIDTH, HEIGHT = 32, 24
SCAN = {
    "views": 5,
    "candidates": 12,
    "voxel_size_m": 0.02,
    "planner": "random",
    "live": {"box_m": [-0.08, -0.08, 0.0, 0.08, 0.08, 0.16], "table_z_m": 0.0},
    "camera": {"width": WIDTH, "height": HEIGHT, "fx": 30, "fy": 30, "cx": 15.5, "cy": 11.5},
}
# Above the object, looking down.
POSE = [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0.5, 0, 0, 0, 1]
# A block on a table.
BLOCK = [0.42 if 10 <= u < 22 and 7 <= v < 17 else 0.5 for v in range(HEIGHT) for u in range(WIDTH)]
DEPTH = struct.pack(f"<{WIDTH * HEIGHT}f", *BLOCK)
# Statuses that a client may get in a conflict: done, gone, not possible now, or ask again.
EXPECTED = {200, 201, 404, 409, 422, 429, 503}


class Client:
    """A client of the server at this address; each thread has a connection of its own."""

    def __init__(self, address):
        self.address = address
        self.local = threading.local()

    def ask(self, method, path, body=None):
        """Status and answer; None if the server was killed before it answered."""
        kind = "application/octet-stream" if isinstance(body, bytes) else "application/json"
        data = body if body is None or isinstance(body, bytes) else json.dumps(body)
        headers = {"content-type": kind} if data is not None else {}
        for attempt in range(2):
            connection = getattr(self.local, "connection", None)
            is_new = connection is None
            if is_new:
                connection = self.local.connection = http.client.HTTPConnection(self.address, timeout=60)
            try:
                connection.request(method, path, data, headers)
                answer = connection.getresponse()
                text = answer.read()
                return answer.status, json.loads(text) if text else None
            except (OSError, http.client.HTTPException):
                connection.close()
                self.local.connection = None
                # The server closes connections on which nothing comes; a question can be asked again.
                if is_new or method != "GET":
                    return None
        return None

    def create(self, scan, after=None):
        body = {"id": scan, "after": after} if after else {"id": scan, **SCAN}
        return self.ask("POST", "/scans", body)

    def post(self, scan, frame):
        pose = ",".join(map(str, POSE))
        query = f"id={frame}&width={WIDTH}&height={HEIGHT}&dtype=f32&world_from_camera={pose}"
        return self.ask("POST", f"/scans/{scan}/frames?{query}", DEPTH)

    def next(self, scan):
        return self.ask("GET", f"/scans/{scan}/next")

    def skip(self, scan):
        view = self.next(scan)
        number = (view[1].get("view") or {}).get("view") if view and view[0] == 200 else None
        return self.ask("POST", f"/scans/{scan}/skip", {"view": number if number is not None else 0})

    def finish(self, scan):
        return self.ask("POST", f"/scans/{scan}/finish", {})

    def pause(self, scan):
        return self.ask("POST", f"/scans/{scan}/pause", {})

    def delete(self, scan):
        return self.ask("DELETE", f"/scans/{scan}")


class Scan:
    """What a client knows of a scan."""

    def __init__(self):
        # Whether it was created, and whether its deletion was asked for or acknowledged.
        self.is_created = self.may_be_deleted = self.is_deleted = False
        self.frames = set()
        self.after = None


class Book:
    """All scans of all pairs."""

    def __init__(self, client):
        self.client = client
        self.scans = collections.defaultdict(Scan)
        self.lock = threading.Lock()

    def do(self, action, scan, *more):
        """Asks for something, and keeps what the answer promises."""
        if action == "delete":
            self.scans[scan].may_be_deleted = True
        answer = getattr(self.client, action)(scan, *more)
        status = answer[0] if answer else None
        with self.lock:
            known = self.scans[scan]
            if action == "create" and status == 201:
                known.is_created = True
                known.after = more[0] if more else None
            if action == "post" and status == 200:
                known.frames.add(more[0])
            if action == "delete" and status == 200:
                known.is_deleted = True
        return status


def first(book, scan, n_frames=1):
    """A scan with some frames."""
    book.do("create", scan)
    for number in range(n_frames):
        book.do("next", scan)
        book.do("post", scan, f"before-{number}")


# By name: what is done before, and the two requests, each given the book and the id of a scan of the pair's own.
def base(book, scan):
    first(book, scan, 2)
    book.do("finish", scan)


def dependent(book, scan):
    base(book, scan)
    book.do("create", f"{scan}-on", scan)
    book.do("post", f"{scan}-on", "before-0")


PAIRS = {
    "delete × create after": (base, lambda b, s: b.do("delete", s), lambda b, s: after(b, s)),
    "delete base × delete scan after": (dependent, lambda b, s: b.do("delete", s), lambda b, s: b.do("delete", f"{s}-on")),
    "delete base × finish scan after": (dependent, lambda b, s: b.do("delete", s), lambda b, s: b.do("finish", f"{s}-on")),
    "delete base × post to scan after": (dependent, lambda b, s: b.do("delete", s), lambda b, s: b.do("post", f"{s}-on", "a")),
    "finish × create after": (lambda b, s: first(b, s, 2), lambda b, s: b.do("finish", s), lambda b, s: after(b, s)),
    "finish × post": (first, lambda b, s: b.do("finish", s), lambda b, s: b.do("post", s, "a")),
    "finish × finish": (first, lambda b, s: b.do("finish", s), lambda b, s: b.do("finish", s)),
    "finish × delete": (first, lambda b, s: b.do("finish", s), lambda b, s: b.do("delete", s)),
    "finish × skip": (first, lambda b, s: b.do("finish", s), lambda b, s: b.do("skip", s)),
    "delete × post": (first, lambda b, s: b.do("delete", s), lambda b, s: b.do("post", s, "a")),
    "delete × delete, create": (first, lambda b, s: b.do("delete", s), lambda b, s: again(b, s)),
    "delete × next": (first, lambda b, s: b.do("delete", s), lambda b, s: b.do("next", s)),
    "delete × create": (first, lambda b, s: b.do("delete", s), lambda b, s: b.do("create", s)),
    "create × create": (lambda b, s: None, lambda b, s: made(b, s, "a"), lambda b, s: made(b, s, "b")),
    "create × post": (lambda b, s: None, lambda b, s: b.do("create", s), lambda b, s: b.do("post", s, "a")),
    "create × delete": (lambda b, s: None, lambda b, s: b.do("create", s), lambda b, s: b.do("delete", s)),
    "skip × post": (first, lambda b, s: b.do("skip", s), lambda b, s: b.do("post", s, "a")),
    "skip × next": (first, lambda b, s: b.do("skip", s), lambda b, s: b.do("next", s)),
    "next × post": (first, lambda b, s: b.do("next", s), lambda b, s: b.do("post", s, "a")),
    "pause × post": (first, lambda b, s: b.do("pause", s), lambda b, s: b.do("post", s, "a")),
    "post × post, one id": (first, lambda b, s: b.do("post", s, "a"), lambda b, s: b.do("post", s, "a")),
    "post × post": (first, lambda b, s: b.do("post", s, "a"), lambda b, s: b.do("post", s, "b")),
}


def made(book, scan, frame):
    """Creates a scan, and posts to it even if another client created it."""
    status = book.do("create", scan)
    book.do("post", scan, frame)
    return status


def after(book, scan):
    """A scan that continues this one, with a frame."""
    status = book.do("create", f"{scan}-on", scan)
    if status == 201:
        book.do("post", f"{scan}-on", "a")
    return status


def again(book, scan):
    """Deletes a scan, and creates another one of its id, with a frame; what was of the first is gone."""
    status = book.do("delete", scan)
    created = book.do("create", f"{scan}")
    if created == 201:
        with book.lock:
            known = book.scans[scan]
            known.frames, known.is_deleted, known.may_be_deleted = set(), False, True
        book.do("post", scan, "again")
    return status


def pair(book, kind, scan, delay):
    """Sends both requests of a pair, the second this many seconds after the first: their statuses."""
    before, one, other = PAIRS[kind]
    before(book, scan)
    statuses = [None, None]

    def send(i, request, wait):
        time.sleep(wait)
        statuses[i] = request(book, scan)

    threads = [threading.Thread(target=send, args=(0, one, max(-delay, 0.0))),
               threading.Thread(target=send, args=(1, other, max(delay, 0.0)))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return kind, tuple(statuses)


def start(program, folder):
    command = [program, "serve", "--listen", "127.0.0.1:0", "--max-scans", "4000", "--min-free-disk-mb", "1",
               "--max-memory-mb", "8192", "--dir", folder]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    line = process.stdout.readline()
    if not line.startswith("listening on http://"):
        sys.exit(f"the server does not start: {line}{process.stderr.read()}")
    return process, Client(line.split("http://")[1].strip())


def lost(client, scans):
    """What is missing of what was acknowledged."""
    found = []
    status, listed = client.ask("GET", "/scans")
    ids = {scan["id"] for scan in listed}
    for name, scan in scans.items():
        if scan.is_deleted:
            if name in ids and not scan.may_be_deleted:
                found.append(f"{name} was deleted, but is back")
            continue
        if not scan.is_created or (scan.may_be_deleted and name not in ids):
            continue
        if name not in ids:
            found.append(f"{name} is gone with {len(scan.frames)} frames")
            continue
        status, answer = client.ask("GET", f"/scans/{name}") or (None, None)
        if status != 200:
            found.append(f"{name}: {status} {answer}")
            continue
        there = [step.get("frame") for step in answer["record"]["steps"]]
        missing = scan.frames - set(there)
        if missing or len(there) != len(set(there)):
            found.append(f"{name}: frames {sorted(scan.frames)} acknowledged, {there} there")
        if answer["state"] != "finished" and scan.after and scan.after not in ids:
            found.append(f"{name}: {scan.after}, which it continues, is gone")
        if answer["state"] != "finished" and client.next(name)[0] != 200:
            found.append(f"{name}: no next view")
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--pairs", type=int, default=10000)
    parser.add_argument("--batch", type=int, default=220, help="pairs between two kills")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    rng = random.Random(args.seed)
    table = collections.defaultdict(collections.Counter)
    problems, n_kills, n_frames, began = [], 0, 0, time.monotonic()
    kinds = list(PAIRS)
    with tempfile.TemporaryDirectory() as work:
        done = 0
        while done < args.pairs:
            folder = pathlib.Path(work) / f"scans-{done}"
            process, client = start(args.program.resolve(), folder)
            book = Book(client)
            n = min(args.batch, args.pairs - done)
            killer = None
            with concurrent.futures.ThreadPoolExecutor(8) as pool:
                jobs = []
                for i in range(n):
                    delay = rng.uniform(-0.004, 0.004)
                    jobs.append(pool.submit(pair, book, kinds[(done + i) % len(kinds)], f"s{i}", delay))
                if n_kills % 2:
                    # While requests are under way: most pairs are sent by then.
                    killer = rng.uniform(0.85, 1.0) * n
                    while sum(job.done() for job in jobs) < killer:
                        time.sleep(0.001)
                    process.kill()
            process.kill()
            process.communicate()
            n_kills += 1
            for job in jobs:
                kind, statuses = job.result()
                table[kind][statuses] += 1
                if not all(status in EXPECTED or status is None for status in statuses):
                    problems.append(f"{kind}: {statuses}")
            process, client = start(args.program.resolve(), folder)
            problems += lost(client, book.scans)
            n_frames += sum(len(scan.frames) for scan in book.scans.values())
            process.kill()
            process.communicate()
            done += n
    print("| pair | answers |\n|---|---|")
    for kind in kinds:
        answers = ", ".join(f"{'/'.join(str(s or '-') for s in statuses)}: {n}" for statuses, n in table[kind].most_common())
        print(f"| {kind} | {answers} |")
    seconds = time.monotonic() - began
    print(f"\n{args.pairs} pairs, {n_kills} kills and restarts, {n_frames} frames acknowledged, {len(problems)} lost or "
          f"wrong, in {seconds:.0f} s, seed {args.seed}")
    if problems:
        sys.exit("\n".join(problems[:40]))


if __name__ == "__main__":
    main()
