#!/usr/bin/env python3
"""Requests scans whose keys name files of the server's machine, and watches which files the server opens.

    .ci/canary.py target/debug/nextview

Every key of the schema of `POST /scans`, whatever its kind, is set in separate requests to the path of a file, of a
folder, and to a path that does not exist. The answers must be the same but for the path, and under `strace` the
server may open nothing outside the folder that it serves, nor anything of a canary's name. Fails if it does. Needs
strace (Debian: strace).
"""

import http.client
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

LIVE = {"box_m": [-0.08, -0.08, -0.08, 0.08, 0.08, 0.08]}
CAMERA = {"width": 32, "height": 24, "fx": 30, "fy": 30, "cx": 15.5, "cy": 11.5}
SCAN = {"views": 3, "candidates": 12, "voxel_size_m": 0.02, "planner": "random", "live": LIVE, "camera": CAMERA}
# What any program opens: its memory in use, the number of cores, the clock's zone.
OF_THE_SYSTEM = ("/proc/self/", "/proc/meminfo", "/sys/fs/cgroup/", "/sys/devices/system/cpu", "/etc/localtime", "/dev/urandom")


def ask(address, method, path, body=None):
    connection = http.client.HTTPConnection(address, timeout=60)
    connection.request(method, path, body and json.dumps(body), {"content-type": "application/json"} if body else {})
    answer = connection.getresponse()
    status, text = answer.status, answer.read().decode()
    connection.close()
    return status, text


def keys(description, schema, key=()):
    """All keys of a schema that hold a value, as tuples; None stands for any place in a list."""
    if "$ref" in schema:
        parts = schema["$ref"].removeprefix("#/").split("/")
        for part in parts:
            description_part = description if part == parts[0] else description_part
            description_part = description_part[part]
        yield from keys(description, description_part, key)
    for of in ("anyOf", "oneOf", "allOf"):
        for part in schema.get(of, []):
            yield from keys(description, part, key)
    if "properties" in schema:
        for word, inner in schema["properties"].items():
            yield from keys(description, inner, (*key, word))
    elif isinstance(schema.get("items"), dict):
        yield from keys(description, schema["items"], (*key, None))
    elif schema.get("type") not in (None, "null"):
        yield key


def with_value(scan, key, value):
    """The scan with this value at a key."""
    word, *rest = key
    if word is None:
        return [with_value(scan if isinstance(scan, dict) else {}, rest, value) if rest else value]
    inner = scan.get(word) if isinstance(scan, dict) else None
    return {**(scan if isinstance(scan, dict) else {}), word: with_value(inner, rest, value) if rest else value}


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    strace = shutil.which("strace")
    if not strace:
        print("SKIPPED canary: there is no strace")
        return
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work).resolve()
        scans, log = work / "scans", work / "strace.txt"
        outside = work / "canary"
        canaries = [outside / kind / f"canary{suffix}" for suffix in ("", ".toml") for kind in ("file", "folder", "nothing")]
        for canary in canaries:
            canary.parent.mkdir(parents=True, exist_ok=True)
            if canary.parent.name == "file":
                canary.write_text('like = "secret"\n')
            elif canary.parent.name == "folder":
                canary.mkdir()
        command = [strace, "-f", "-qq", "-e", "trace=%file", "-o", log, program, "serve", "--listen", "127.0.0.1:0",
                   "--min-free-disk-mb", "1", "--max-scans", "4000", "--dir", scans]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        problems, n = [], 0
        try:
            address = process.stdout.readline().removeprefix("listening on http://").strip()
            description = json.loads(ask(address, "GET", "/openapi.json")[1])
            schema = description["paths"]["/scans"]["post"]["requestBody"]["content"]["application/json"]["schema"]
            found = sorted(set(keys(description, schema)), key=str)
            began = log.stat().st_size
            for key in found:
                name = ".".join(word or "[]" for word in key)
                answers = {}
                for canary in canaries:
                    n += 1
                    body = with_value({**SCAN, "id": f"s{n}"}, key, str(canary))
                    status, text = ask(address, "POST", "/scans", body)
                    if status == 500:
                        problems.append(f"{name}: 500 {text}")
                    if status == 201:
                        ask(address, "DELETE", f"/scans/{json.loads(text)['id']}")
                    if "secret" in text:
                        problems.append(f"{name}: the answer quotes the file: {text}")
                    plain = re.sub(r'"created":"[^"]*"|"peak_memory_mb":[0-9.]*', "", text.replace(str(canary), "CANARY").replace(f"s{n}", "ID"))
                    answers.setdefault(canary.suffix, set()).add((status, plain))
                for suffix, different in answers.items():
                    if len(different) > 1:
                        problems.append(f"{name}: answers differ: {different}")
            time.sleep(0.2)
            with log.open() as lines:
                lines.seek(began)
                for line in lines:
                    for path in re.findall(r'"((?:[^"\\]|\\.)*)"', line):
                        is_inside = path.startswith((str(scans), *OF_THE_SYSTEM)) or scans.is_relative_to(path)
                        if str(outside) in path or (path.startswith("/") and not is_inside) or path.startswith(".."):
                            problems.append(f"outside: {line.strip()}")
        finally:
            # strace, which passes no signals on, ends with the server.
            for child in pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split():
                os.kill(int(child), signal.SIGTERM)
            process.wait()
    print(f"{len(found)} keys, {n} requests: {len(problems)} faults")
    if problems:
        sys.exit("\n".join(list(dict.fromkeys(problems))[:40]))


if __name__ == "__main__":
    main()
