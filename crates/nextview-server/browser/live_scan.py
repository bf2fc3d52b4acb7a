"""A server, a simulated robot that scans through it, and a browser, shared by the scripts in this folder."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import urllib.request
import uuid
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "nextview-report" / "browser"))

from check_page import FLAGS  # noqa: E402

BOX_M = [-0.08, -0.08, -0.02, 0.08, 0.08, 0.14]


class Server:
    """`nextview serve` on a free port, ended with the block."""

    def __init__(self, program: str, folder: Path) -> None:
        command = [program, "serve", "--listen", "127.0.0.1:0", "--dir", str(folder)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        said = {}
        while "page" not in said:
            line = self.process.stdout.readline()
            if not line:
                raise SystemExit("the server ended before it listened")
            name, _, rest = line.strip().partition(" http")
            said[name.strip(":")] = "http" + rest
        self.address = said["listening on"]
        self.token = said["page"].rpartition("#token=")[2]

    def __enter__(self) -> Server:
        return self

    def __exit__(self, *_) -> None:
        self.process.terminate()
        self.process.wait()

    def page(self, scan: str) -> str:
        """The address of a scan's page."""
        return f"{self.address}/scans/{scan}/page#token={self.token}"

    def ask(self, path: str, body: object = None, method: str | None = None) -> dict:
        """The answer to a JSON body, or to none."""
        data = None if body is None else json.dumps(body).encode()
        return self.send(path, data, "application/json", method)

    def send(self, path: str, data: bytes | None, kind: str, method: str | None = None) -> dict:
        request = urllib.request.Request(self.address + path, data, {"Content-Type": kind}, method=method)
        with urllib.request.urlopen(request, timeout=60) as answer:
            return json.load(answer)


class Robot:
    """A camera before a mug: goes to the next view and posts what it sees there."""

    def __init__(self, server: Server, take_frame: str, scan: str, folder: Path) -> None:
        self.server, self.take_frame, self.scan, self.folder = server, take_frame, scan, folder

    def next(self) -> dict:
        return self.server.ask(f"/scans/{self.scan}/next")

    def look(self, next_view: dict) -> list[tuple[str, bytes]]:
        """The parts of a frame of that view."""
        paths = [self.folder / name for name in ("next.json", "frame.json", "depth.png")]
        paths[0].write_text(json.dumps(next_view))
        subprocess.run([self.take_frame, *paths], check=True)
        return [("frame", paths[1].read_bytes()), ("depth", paths[2].read_bytes())]

    def step(self) -> dict:
        return self.post("frames", self.look(self.next()))

    def post(self, what: str, parts: list[tuple[str, bytes]]) -> dict:
        boundary = uuid.uuid4().hex
        head = 'Content-Disposition: form-data; name="{}"; filename="{}"\r\n\r\n'
        body = b"".join(
            f"--{boundary}\r\n{head.format(name, name)}".encode() + data + b"\r\n" for name, data in parts
        )
        kind = f"multipart/form-data; boundary={boundary}"
        return self.server.send(f"/scans/{self.scan}/{what}", body + f"--{boundary}--\r\n".encode(), kind)


def start_browser(playwright):
    """Debian's Chromium, or the one that CHROMIUM names; None if it is missing."""
    chromium = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
    return chromium and playwright.chromium.launch(executable_path=chromium, args=FLAGS)
