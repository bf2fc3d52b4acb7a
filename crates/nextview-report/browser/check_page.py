"""Opens pages of scans in Chromium and looks for faults that only a browser shows.

    python check_page.py report.html ...

Needs Debian's chromium (or another one, named by CHROMIUM), `pip install playwright`, whose own browser is not used,
and npm, which downloads axe-core once into the folder AXE_DIR (by default a temporary one). Without a browser, it
reports SKIPPED.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

# WebGL in software: machines that test have no graphics card.
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
AXE_VERSION = "4.10.3"
SIZES = {"desk": (1400, 1000), "phone": (390, 844)}

# The share of the canvas that differs from its corner.
FILLED = """() => {
    const canvas = document.getElementById("canvas"), small = document.createElement("canvas");
    [small.width, small.height] = [100, 60];
    const ctx = small.getContext("2d", { willReadFrequently: true });
    ctx.drawImage(canvas, 0, 0, 100, 60);
    const { data } = ctx.getImageData(0, 0, 100, 60);
    let opaque = 0;
    for (let i = 3; i < data.length; i += 4) opaque += data[i] > 200;
    return opaque / 6000;
}"""

VIOLATIONS = """async () => {
    const { violations } = await axe.run(document);
    return violations.map((v) => `${v.id}: ${v.help}: ${v.nodes.slice(0, 3).map((n) => n.html.slice(0, 120)).join(" | ")}`);
}"""


def axe_source() -> str:
    """The script of axe-core, fetched once."""
    folder = Path(os.environ.get("AXE_DIR") or Path(tempfile.gettempdir()) / f"axe-{AXE_VERSION}")
    script = folder / "node_modules" / "axe-core" / "axe.min.js"
    if not script.exists():
        folder.mkdir(parents=True, exist_ok=True)
        command = ["npm", "install", "--prefix", str(folder), "--no-save", f"axe-core@{AXE_VERSION}"]
        subprocess.run(command, check=True, capture_output=True)
    return script.read_text(encoding="utf-8")


def check(browser, path: Path, axe: str) -> list[str]:
    """The faults of a page, in light and dark, on a desktop and on a phone."""
    wrong = []
    for scheme in ("light", "dark"):
        for name, (width, height) in SIZES.items():
            where = f"{path} ({scheme}, {name})"
            # The page's policy would refuse the script of axe.
            context = browser.new_context(
                viewport={"width": width, "height": height}, color_scheme=scheme, bypass_csp=True
            )
            page = context.new_page()
            said: list[str] = []
            page.on("console", lambda message: said.append(message.text) if message.type == "error" else None)
            page.on("pageerror", lambda error: said.append(str(error)))
            page.on("request", lambda request: said.append(f"asks for {request.url[:80]}")
                    if request.url.split(":")[0] not in ("file", "data") else None)
            page.goto(path.resolve().as_uri())
            page.wait_for_timeout(800)
            wrong += [f"{where}: {text}" for text in said]
            if page.is_visible("#canvas"):
                if not becomes_true(page, lambda: page.evaluate(FILLED) >= 0.08):
                    filled = page.evaluate(FILLED)
                    wrong.append(f"{where}: the object fills {100 * filled:.1f} % of the 3D view")
            else:
                wrong.append(f"{where}: no 3D view")
            scrolls = page.evaluate("document.documentElement.scrollWidth")
            if scrolls > width:
                wrong.append(f"{where}: {scrolls} pixels wide")
            if page.query_selector("button.enlarge"):
                page.click("button.enlarge")
                if not page.is_visible("#enlarged-picture"):
                    wrong.append(f"{where}: a picture does not enlarge")
                page.keyboard.press("Escape")
            if wheel_is_caught(page):
                wrong.append(f"{where}: the wheel does not scroll the page over the 3D view")
            page.evaluate(axe)
            wrong += [f"{where}: axe: {violation}" for violation in page.evaluate(VIOLATIONS)]
            context.close()
    return wrong


def becomes_true(page, condition) -> bool:
    """Whether the condition is met within ten seconds: a loaded machine draws late."""
    for _ in range(100):
        if condition():
            return True
        page.wait_for_timeout(100)
    return False


def wheel_is_caught(page) -> bool:
    """Whether the page stays where it is when the wheel turns over the 3D view, which nobody clicked."""
    page.evaluate("scrollTo(0, 0)")
    box = page.locator("#canvas").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + 40)
    page.mouse.wheel(0, 120)
    return not becomes_true(page, lambda: page.evaluate("scrollY") > 0)


def skipped(name: str, needs: str, why: str) -> int:
    """Reports that a check is skipped; returns the exit code."""
    return subprocess.run([Path(__file__).parents[3] / ".ci/skipped", name, needs, why]).returncode


def main() -> int:
    chromium = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
    if not chromium:
        return skipped("pages in a browser", "chromium", "there is no chromium")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        return skipped("pages in a browser", "playwright", "playwright is not installed")
    axe = axe_source()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        wrong = [text for path in sys.argv[1:] for text in check(browser, Path(path), axe)]
        browser.close()
    print("\n".join(wrong) or f"{len(sys.argv) - 1} pages, nothing wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
