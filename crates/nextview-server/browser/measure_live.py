"""Measures the live page during a scan of 20 frames of 640 x 480 pixels: bytes from the server, frames per second.

    python measure_live.py PROGRAM TAKE_FRAME

as `check_live.py`. The browser draws in software, so that a machine with a graphics card is faster.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from live_scan import BOX_M, Robot, Server, start_browser
from playwright.sync_api import sync_playwright

N_FRAMES = 20

# Turns the scene for three seconds, waiting for each picture; gives frames a second.
TURN = """() => new Promise((resolve) => {
    const canvas = document.getElementById("canvas"), gl = canvas.getContext("webgl2"), start = performance.now();
    let n = 0;
    const step = () => {
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
        canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" }));
        n += 1;
        const seconds = (performance.now() - start) / 1000;
        if (seconds < 3) requestAnimationFrame(step);
        else resolve(n / seconds);
    };
    requestAnimationFrame(step);
})"""


def measure(page, robot: Robot, server: Server) -> None:
    received = [0]
    network = page.context.new_cdp_session(page)
    network.send("Network.enable")
    network.on("Network.dataReceived", lambda data: received.__setitem__(0, received[0] + data["dataLength"]))
    page.goto(server.page("mug"))
    page.wait_for_function("() => document.getElementById('next-text').textContent.includes('Move the camera to')")
    before = received[0]
    for i in range(1, N_FRAMES + 1):
        robot.step()
        page.wait_for_function("n => document.getElementById('shown').value === n", arg=f"{i} of {i}")
    page.wait_for_timeout(1000)
    print(f"{(received[0] - before) / 1e6:.2f} MB for {N_FRAMES} frames, the page itself {before / 1e3:.0f} kB")
    page.reload()
    page.wait_for_function("n => document.getElementById('shown').value === n", arg=f"{N_FRAMES} of {N_FRAMES}")
    print(f"surface: {page.evaluate(TURN):.0f} pictures a second")
    page.check("#show-points")
    print(f"with points: {page.evaluate(TURN):.0f} pictures a second")


def main() -> None:
    program, take_frame = sys.argv[1:]
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as work:
        browser = start_browser(playwright)
        with Server(program, Path(work) / "scans") as server:
            # All views are taken, however little is left to see.
            scan = {"id": "mug", "object": "mug", "views": N_FRAMES, "candidates": 200, "stop": {"progress": 0.0}}
            server.ask("/scans", {**scan, "live": {"box_m": BOX_M}})
            page = browser.new_page(viewport={"width": 1400, "height": 1000})
            measure(page, Robot(server, take_frame, "mug", Path(work)), server)
            page.goto("about:blank")
        browser.close()


if __name__ == "__main__":
    main()
