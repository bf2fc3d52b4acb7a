#!/usr/bin/env python3
"""Runs every command of the program under tight limits of the system, and prints the result of each.

    .ci/limits.py target/release/nextview [--quick]

Limits: 64 open files, 300 MB of address space, files of 16 kB, no more threads, a full file system of 64 kB (where
this process may mount one). A command must do its work or end with an error on stderr and code 1 or 2: no panic, no
signal. Its input stays as it was, no unfinished file is left, and every frame or run that it acknowledged is still
there. The same command without the limit then finishes the work. Prints a table; fails if any of this is not the
case.

All run with MALLOC_ARENA_MAX=2, as docs/robustness.md advises for a limited address space.
"""

import argparse
import ctypes
import json
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import soak

os.environ["MALLOC_ARENA_MAX"] = "2"

MB = 1 << 20
NOBODY = 65534
# What a report is made of.
CAMPAIGN = ("spec.toml", "runs.jsonl")
SPEC = soak.CAMPAIGN.replace('"builtin:bracket", "builtin:mug"', '"builtin:bracket"').replace("[0, 1, 2]", "[0, 1]")


def limit_of(what, value):
    return lambda: resource.setrlimit(what, (value, value))


LIMITS = {
    "64 open files": limit_of(resource.RLIMIT_NOFILE, 64),
    "300 MB": limit_of(resource.RLIMIT_AS, 300 * MB),
    "files of 16 kB": limit_of(resource.RLIMIT_FSIZE, 16 << 10),
    "no threads": limit_of(resource.RLIMIT_NPROC, 1),
    "full disk": None,
}


class Commands:
    """The commands, each with what it needs; `out` is the folder that it writes to."""

    def __init__(self, program, data):
        self.program, self.data = program, data
        (data / "scan.toml").write_text(soak.SCAN)
        (data / "spec.toml").write_text(SPEC)
        scan = ["scan", "builtin:bracket", "--config", data / "scan.toml"]
        self.begin = [*scan, "--out"]
        bench = ["bench", data / "spec.toml", "--jobs", "1"]
        shards = [[*bench, "--shard", f"{number}/2"] for number in (1, 2)]
        self.run([*scan, "--out", data / "part"])
        self.run([*bench, "--out", data / "whole"])
        for number, shard in enumerate(shards):
            self.run([*shard, "--out", data / f"shard-{number}"])
        mesh = data / "part" / "mesh.ply"
        (data / "views.csv").write_bytes(self.run(["views"]))
        plan = ["plan", "--map", data / "part" / "map.ot", "--views", data / "views.csv"]
        # What each does in a folder for its output.
        self.all = {
            "scan": lambda out: [*self.begin, out / "x"],
            "scan, large": lambda out: ["scan", "builtin:mug", "--views", "2", "--baselines", "off", "--out", out / "x"],
            "bench": lambda out: [*bench, "--out", out / "x"],
            "merge": lambda out: ["merge", data / "shard-0", data / "shard-1", "--out", out / "x"],
            "report": self.report,
            "compare": lambda out: ["compare", data / "whole", data / "whole"],
            "export": lambda out: ["export", data / "part", "--to", "tum", "--out", out / "x"],
            "inspect": lambda out: ["inspect", data / "part", "--reference", mesh, "--unit", "m", "--out", out / "x"],
            "plan": lambda out: plan,
            "plan --batch": lambda out: [*plan, "--batch", "3"],
            "views": lambda out: ["views"],
            "map info": lambda out: ["map", "info", data / "part" / "map.ot"],
            "map convert": lambda out: ["map", "convert", data / "part" / "map.ot", out / "x.bt"],
            "dataset": lambda out: ["dataset", "nbv-net", "--objects", "1", "--out", out / "x"],
            "completions": lambda out: ["completions", "bash"],
            "man": lambda out: ["man", "--out", out / "x"],
        }

    def report(self, out):
        """Reports on a copy of the campaign: the page is written next to its input."""
        if not (out / "x").exists():
            (out / "x").mkdir()
            (out / "x").chmod(0o777)
            for name in CAMPAIGN:
                shutil.copy(self.data / "whole" / name, out / "x")
        return ["report", out / "x"]

    def is_copy(self, folder):
        return all((folder / name).read_bytes() == (self.data / "whole" / name).read_bytes() for name in CAMPAIGN)

    def run(self, command):
        done = subprocess.run([self.program, *command], capture_output=True)
        if done.returncode != 0:
            sys.exit(f"{command} failed without a limit: {done.stderr.decode()}")
        return done.stdout


def under(limit):
    """What a process does before it is the program: it obeys a limit, which root does not of threads."""

    def prepare():
        if os.geteuid() == 0:
            # From the C library: Python's own would keep the groups.
            ctypes.CDLL(None).setgroups(0, None)
            os.setgid(NOBODY)
            os.setuid(NOBODY)
        if limit:
            limit()

    return prepare


def mount(folder):
    """Mounts a file system of 64 kB; false where that is not allowed."""
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k,mode=777", "tmpfs", folder], capture_output=True)
    return mounted.returncode == 0


def faults_of(code, stderr):
    """What is wrong with the end of a command."""
    text = stderr.decode(errors="replace")
    faults = []
    if code < 0 or code >= 101:
        faults.append(f"ended by a signal or a panic ({code})")
    if "panicked" in text:
        faults.append("panicked")
    if code != 0 and "error:" not in text:
        faults.append("no error on stderr")
    return faults


def message(code, stderr):
    lines = [line for line in stderr.decode(errors="replace").splitlines() if line.startswith(("error:", "memory alloc"))]
    return lines[-1] if lines and code != 0 else ""


def unfinished(out):
    return [str(path.relative_to(out)) for path in out.rglob("*.partial")]


def n_kept(out):
    """Runs and frames that a folder holds: for a campaign its records."""
    runs = out / "x" / "runs.jsonl"
    return runs.read_bytes().count(b"\n") if runs.exists() else 0


def check_command(commands, name, limit, out):
    """Code, message and faults of a command under a limit, and of the same without it."""
    command = [commands.program, *commands.all[name](out)]
    before = soak.files(commands.data)
    done = subprocess.run(command, capture_output=True, preexec_fn=under(limit), cwd=out, timeout=300)
    faults = faults_of(done.returncode, done.stderr)
    if soak.files(commands.data) != before or (name == "report" and not commands.is_copy(out / "x")):
        faults.append("its input has changed")
    if left := unfinished(out):
        faults.append(f"unfinished files are left: {left}")
    if done.returncode == 0:
        return 0, "", faults
    # With what is left, in a folder without limits.
    with tempfile.TemporaryDirectory(dir=commands.data.parent) as moved:
        again = pathlib.Path(moved) / "again"
        shutil.copytree(out, again)
        rest = commands.all[name](again)
        if (again / "x" / "scan.journal").exists():
            rest = ["scan", "--resume", again / "x"]
        elif name in ("bench", "dataset") and (again / "x").exists():
            rest = [*rest, "--resume"] if any((again / "x").iterdir()) else rest
        kept = n_kept(again)
        finished = subprocess.run([commands.program, *rest], capture_output=True, cwd=again)
        if finished.returncode != 0:
            faults.append(f"cannot be finished afterwards: {finished.stderr.decode()[-300:]}")
        if name.startswith("scan"):
            printed = len(re.findall(rb"^ +\d+ +\d+ .*%", done.stdout, re.MULTILINE))
            told = re.search(rb"resuming after (\d+) frame", finished.stdout + finished.stderr)
            if printed > (int(told[1]) if told else 0):
                faults.append(f"{printed} frames were acknowledged, then {told and told[1]}")
        if n_kept(again) < kept:
            faults.append("stored runs are gone")
    return done.returncode, message(done.returncode, done.stderr), faults


def post(client, pose, number):
    """Sends the frame of this number."""
    numbers = ",".join(repr(number) for row in pose for number in row)
    query = {"id": f"frame-{number}", "world_from_camera": numbers, "width": soak.WIDTH, "height": soak.HEIGHT}
    path = f"/scans/ball/frames?{urllib.parse.urlencode({**query, 'dtype': 'f32'})}"
    return client.ask("POST", path, soak.depth_of(pose), "application/octet-stream")


def check_server(commands, limit, out):
    """The same of a server that takes a scan: its code, or that of the first request that failed."""
    command = [commands.program, "serve", "--listen", "127.0.0.1:0", "--dir", out / "x"]
    command += ["--min-free-disk-mb", "0"]

    def start(prepare):
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=prepare, cwd=commands.data
        )
        line = process.stdout.readline().decode()
        client = soak.Client(line.removeprefix("listening on ").strip()) if line else None
        return process, client

    process, client = start(under(limit))
    if client is None:
        code = process.wait()
        stderr = process.stderr.read()
        return code, message(code, stderr), faults_of(code, stderr)
    n_acknowledged, said, faults = 0, "", []
    try:
        status, answer = client.ask("POST", "/scans", json.dumps({"id": "ball", **soak.LIVE}))
        while status < 400:
            status, answer = client.ask("GET", "/scans/ball/next")
            view = json.loads(answer) if status == 200 else {}
            if view.get("state") != "view":
                break
            status, answer = post(client, view["view"]["world_from_camera"], n_acknowledged)
            n_acknowledged += status == 200
        if status < 400:
            status, answer = client.ask("POST", "/scans/ball/finish")
        said = "" if status < 400 else f"{status} {answer.decode(errors='replace')[:160]}"
    except OSError as error:
        faults.append(f"the connection broke: {error}")
    faults += [] if process.poll() is None else [f"the server ended: {process.returncode}"]
    process.terminate()
    stderr = process.communicate()[1]
    if b"panicked" in stderr:
        faults.append("panicked: " + stderr.decode(errors="replace")[-200:])
    with tempfile.TemporaryDirectory(dir=commands.data.parent) as moved:
        again = pathlib.Path(moved) / "again"
        shutil.copytree(out, again)
        command[command.index("--dir") + 1] = again / "x"
        process, client = start(None)
        if n_acknowledged:
            n = client.json("GET", "/scans/ball")["n_frames"]
            if n < n_acknowledged:
                faults.append(f"{n_acknowledged} frames were acknowledged, {n} are there")
            status, answer = client.ask("POST", "/scans/ball/finish")
            if status >= 400:
                faults.append(f"cannot be finished afterwards: {answer.decode(errors='replace')[:160]}")
        process.terminate()
        process.communicate()
    return (0 if not said else 1), said, faults


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--quick", action="store_true", help="only scan, merge, export and serve")
    args = parser.parse_args()
    if "NEXTVIEW_LIMITS_INSIDE" not in os.environ and shutil.which("unshare"):
        # A name space of its own, where it may mount the full file system.
        how = ["-m"] if os.geteuid() == 0 else ["-Urm"]
        if subprocess.run(["unshare", *how, "true"], capture_output=True).returncode == 0:
            os.environ["NEXTVIEW_LIMITS_INSIDE"] = "1"
            os.execvp("unshare", ["unshare", *how, sys.executable, *sys.argv])
    n_faults = 0
    with tempfile.TemporaryDirectory(prefix="nextview-limits-") as folder:
        work = pathlib.Path(folder)
        work.chmod(0o755)
        data = work / "data"
        data.mkdir()
        commands = Commands(args.program.resolve(), data)
        names = ["scan", "merge", "export"] if args.quick else list(commands.all)
        print(f"{'command':<14} {'limit':<15} {'code':>4} {'s':>5}  message")
        for name in [*names, "serve"]:
            for what, limit in LIMITS.items():
                out = work / "out"
                out.mkdir()
                out.chmod(0o777)
                is_mounted = limit is None and mount(out)
                if limit is None and not is_mounted:
                    print(f"SKIPPED {name}, {what}: no file system can be mounted", file=sys.stderr)
                    out.rmdir()
                    continue
                start = time.monotonic()
                try:
                    if name == "serve":
                        code, said, faults = check_server(commands, limit, out)
                    else:
                        code, said, faults = check_command(commands, name, limit, out)
                except subprocess.TimeoutExpired:
                    code, said, faults = "", "", ["does not end"]
                seconds = time.monotonic() - start
                print(f"{name:<14} {what:<15} {code:>4} {seconds:>5.1f}  {said.replace(str(work), '')}", flush=True)
                for fault in faults:
                    print(f"{'':<14} FAULT {fault}", flush=True)
                n_faults += len(faults)
                if is_mounted:
                    subprocess.run(["umount", out], check=True)
                shutil.rmtree(out)
    sys.exit(f"{n_faults} faults" if n_faults else 0)


main()
