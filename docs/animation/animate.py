#!/usr/bin/env python3
"""Makes docs/animation/scan.webp, the animation at the top of README.md: a scan with noise, view by view, as shown in its report.

    docs/animation/animate.py target/release/nextview

Needs a Chromium (or another one, named by CHROMIUM), and `pip install playwright pillow`; playwright's own browser is not used.
"""

from __future__ import annotations

import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont
from playwright.sync_api import Page, sync_playwright

# The object, as `nextview scan` names it, and the number of views.
OBJECT, N_VIEWS = "builtin:teapot", 10
OUT = Path(__file__).resolve().parent / "scan.webp"
# WebGL in software: the same picture on every machine.
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
SIZE = {"width": 1000, "height": 900}
WIDTH, QUALITY = 640, 45
# Pictures of each view, without and then with the next one; those of the last view; the time of each.
N_BEFORE, N_WITH_NEXT, N_LAST, FRAME_MS = 3, 4, 14, 130
# Pixels that the pointer drags the scene between two pictures: 1.4 degrees.
TURN = 3

# The view after the shown one as the next, where asked for: a report has none, since its scan is over.
SCENE_NEXT = "const { next } = scene;"
VIEW_AFTER = "const next = scene.next = window.hasNext ? {...scene.views[+byId('slider').value], expected: null} : null;"

SET = """([shown, hasNext]) => {
    window.hasNext = hasNext;
    const slider = document.getElementById("slider");
    slider.value = shown;
    slider.dispatchEvent(new Event("input"));
}"""


def scan(program: str, folder: Path) -> list[float]:
    """Scans the object; reachable coverage after each view."""
    command = [program, "scan", OBJECT, "--noise", "d435i", "--table", "known", "--views", str(N_VIEWS), "--out", str(folder)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    steps = (folder / "steps.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(step)["reachable_coverage"] for step in steps]


def picture(page: Page, caption: str) -> Image.Image:
    """The 3D view, with a line of text at its foot."""
    stage = Image.open(io.BytesIO(page.locator(".stage").screenshot())).convert("RGB")
    stage = stage.resize((WIDTH, round(stage.height * WIDTH / stage.width)), Image.Resampling.LANCZOS)
    place, font = (WIDTH - 14, stage.height - 12), ImageFont.load_default(19)
    ImageDraw.Draw(stage).text(place, caption, fill=(40, 48, 56), font=font, anchor="rs")
    return stage


def turn(page: Page, pixels: float) -> None:
    """Turns the scene as a reader does."""
    box = page.locator("#canvas").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + pixels, y)
    page.mouse.up()


def pictures(page: Page, coverages: list[float]) -> list[Image.Image]:
    """All pictures of the animation."""
    page.select_option("#colouring", "first view")
    page.click("#frame-cameras")
    page.uncheck("#show-expected")
    taken = []
    for shown, coverage in enumerate(coverages, 1):
        is_last = shown == len(coverages)
        caption = f"view {shown} of {len(coverages)}: {100 * coverage:.0f} % of the reachable surface seen"
        for i in range(N_LAST if is_last else N_BEFORE + N_WITH_NEXT):
            page.evaluate(SET, [shown, not is_last and i >= N_BEFORE])
            turn(page, TURN)
            page.wait_for_timeout(60)
            taken.append(picture(page, caption))
    return taken


def main() -> None:
    chromium = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
    if len(sys.argv) != 2 or not chromium:
        sys.exit(f"{__doc__}\nthe program and a Chromium are required")
    with tempfile.TemporaryDirectory() as temporary, sync_playwright() as playwright:
        folder = Path(temporary) / "scan"
        coverages = scan(sys.argv[1], folder)
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        report = folder / "report.html"
        html = report.read_text(encoding="utf-8")
        assert html.count(SCENE_NEXT) == 1, "the viewer draws the next view in another way"
        report.write_text(html.replace(SCENE_NEXT, VIEW_AFTER), encoding="utf-8")
        # The page's policy would refuse the changed script.
        page = browser.new_page(viewport=SIZE, color_scheme="light", bypass_csp=True)
        page.goto(report.as_uri())
        page.wait_for_timeout(800)
        first, *others = pictures(page, coverages)
        browser.close()
    first.save(OUT, save_all=True, append_images=others, duration=FRAME_MS, loop=0, quality=QUALITY, method=6)
    print(f"{OUT}: {len(others) + 1} pictures, {OUT.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
