"""Scans a mug through a server while the live page is open in Chromium, and looks for faults of the page.

    python check_live.py PROGRAM TAKE_FRAME [FOLDER]

PROGRAM is `nextview`, TAKE_FRAME the example of that name; with FOLDER, pictures of the page go there. It has the
requirements of `check_page.py`. Without a browser, it reports SKIPPED.
"""

from __future__ import annotations

import sys
import tempfile
import urllib.error
from pathlib import Path

from live_scan import BOX_M, Robot, Server, start_browser

from check_page import FILLED, SIZES, VIOLATIONS, axe_source, skipped

N_FRAMES = 5
FILES = ["cloud.ply", "mesh.ply", "map.ot", "record.json", "report.html"]

# The 3D view in few numbers, and a way to tell whether it changed.
LOOK = """() => {
    const small = document.createElement("canvas");
    [small.width, small.height] = [64, 48];
    const ctx = small.getContext("2d", { willReadFrequently: true });
    ctx.drawImage(document.getElementById("canvas"), 0, 0, 64, 48);
    return ctx.getImageData(0, 0, 64, 48).data.join(",");
}"""


class Check:
    """The page of a scan, what was wrong with it, and pictures of it."""

    def __init__(self, browser, folder: Path | None) -> None:
        self.browser, self.folder = browser, folder
        self.wrong: list[str] = []
        context = browser.new_context(viewport={"width": 1400, "height": 1000})
        self.page = context.new_page()
        self.page.set_default_timeout(15_000)
        self.page.on("console", self.hear)
        self.page.on("pageerror", lambda error: self.wrong.append(f"error: {error}"))

    def hear(self, message) -> None:
        if message.type == "error":
            self.wrong.append(f"console: {message.text}")

    def expect(self, is_right: bool, otherwise: str) -> None:
        if not is_right:
            self.wrong.append(otherwise)

    def wait(self, selector: str, text: str) -> None:
        """Until an element holds this text."""
        said = "([selector, text]) => document.querySelector(selector).textContent.includes(text)"
        try:
            self.page.wait_for_function(said, arg=[selector, text])
        except Exception:  # a timeout: say what is there instead
            found = self.page.text_content(selector)
            raise SystemExit("\n".join(self.wrong + [f"{selector} says {found!r}, expected {text!r}"])) from None

    def take(self, name: str, page=None) -> None:
        if self.folder:
            (page or self.page).screenshot(path=self.folder / f"{name}.png", full_page=True)

    def text(self, selector: str) -> str:
        return self.page.text_content(selector) or ""


def watch_scan(check: Check, robot: Robot, server: Server) -> None:
    """A scan from its first frame to its results."""
    page = check.page
    page.goto(server.page("mug"))
    check.wait("#next-text", "Move the camera to")
    check.expect("token" not in page.url, "the token stays in the address")
    check.expect(page.is_disabled("#downloads button >> nth=0"), "files are offered before the first frame")
    check.take("no-frame")
    looks = [page.evaluate(LOOK)]
    for i in range(1, N_FRAMES + 1):
        robot.step()
        check.wait("#shown", f"{i} of {i}")
        check.wait("#next-text", f"view {robot.next()['view']['view']}.")
        looks.append(next_look(page, looks[-1]))
        n_rows = page.locator("#views tbody tr").count()
        check.expect(n_rows == i, f"{n_rows} views in the table after {i} frames")
        check.expect(page.locator("#views td.depth img").count() >= i, f"a picture is missing after {i} frames")
        check.expect(looks[-1] != looks[-2], f"the 3D view is the same after frame {i}")
        if i == 2:
            skip(check, robot)
        if i == 3:
            guide(check, robot)
    filled = page.evaluate(FILLED)
    check.expect(filled > 0.08, f"the object fills {100 * filled:.1f} % of the 3D view")
    enlarge(check)
    check.take("desk")


def skip(check: Check, robot: Robot) -> None:
    """Skips a view, pauses, and goes on."""
    before = robot.next()["view"]["view"]
    check.page.fill("#reason", "a cable")
    check.page.click("#skip")
    # The button's request may come after one of the robot's.
    is_gone = "name => !document.getElementById('next-text').textContent.includes(name)"
    check.page.wait_for_function(is_gone, arg=f"view {before}.")
    after = robot.next()["view"]["view"]
    check.expect(after != before, f"view {before} was skipped and is proposed again")
    check.wait("#next-text", f"view {after}.")
    check.page.click("#pause")
    check.wait("#next-text", "is paused")
    check.expect(robot.next()["state"] == "paused", "Pause does not pause")
    check.page.click("#continue")
    check.wait("#next-text", f"view {after}.")


def next_look(page, before):
    """The 3D view once it differs from the one before, or after ten seconds: a loaded machine draws late."""
    for _ in range(100):
        page.wait_for_timeout(100)
        look = page.evaluate(LOOK)
        if look != before:
            break
    return look


def guide(check: Check, robot: Robot) -> None:
    """Moves a camera in a hand, which loses its way."""
    rows = robot.next()["view"]["world_from_camera"]
    for row, shift in zip(rows, (0.12, -0.05, 0.04)):
        row[3] += shift
    robot.server.ask(f"/scans/{robot.scan}/guidance", {"world_from_camera": rows})
    check.wait("#guidance-text", "Go ")
    check.page.wait_for_timeout(300)
    check.take("guidance")
    try:
        robot.post("locate", robot.look(robot.next()))
        check.wrong.append("a camera without registration was located")
    except urllib.error.HTTPError as error:
        check.expect(error.code == 409, f"a lost camera is answered {error.code}")
    check.wait("#tracking", "The position of the camera is unknown")
    check.expect(check.page.is_hidden("#guidance"), "a lost camera is guided")
    check.take("lost")
    robot.server.ask(f"/scans/{robot.scan}/guidance", {"world_from_camera": robot.next()["view"]["world_from_camera"]})
    check.wait("#guidance-text", "hold still")
    check.expect(check.page.is_hidden("#tracking"), "a camera that was found counts as lost")


def look_at_all_sizes(check: Check, server: Server, axe: str) -> None:
    """Light and dark, at a desk and on a phone."""
    for scheme in ("light", "dark"):
        for name, (width, height) in SIZES.items():
            where = f"{scheme}, {name}"
            # The page's policy would refuse the script of axe.
            context = check.browser.new_context(
                viewport={"width": width, "height": height}, color_scheme=scheme, bypass_csp=True
            )
            page = context.new_page()
            page.goto(server.page("mug"))
            page.wait_for_function("n => document.getElementById('shown').value.startsWith(n)", arg=f"{N_FRAMES} of")
            page.wait_for_timeout(300)
            scrolls = page.evaluate("document.documentElement.scrollWidth")
            check.expect(scrolls <= width, f"{where}: {scrolls} pixels wide")
            page.evaluate(axe)
            check.wrong += [f"{where}: axe: {violation}" for violation in page.evaluate(VIOLATIONS)]
            check.take(f"{name}-{scheme}", page)
            context.close()


def enlarge(check: Check) -> None:
    """A picture of the camera's own size, as the server has it."""
    page = check.page
    page.click("button.enlarge")
    try:
        page.wait_for_function("width => document.getElementById('enlarged-picture').naturalWidth === width", arg=640)
    except Exception:  # a timeout: say what is there instead
        width = page.evaluate("document.getElementById('enlarged-picture').naturalWidth")
        check.wrong.append(f"an enlarged picture is {width} pixels wide, expected 640")
    check.take("enlarged")
    page.click("#enlarged-close")


def finish(check: Check) -> None:
    """Ends the scan on the page and fetches its files."""
    page = check.page
    page.on("dialog", lambda dialog: dialog.accept())
    page.click("#finish")
    check.wait("#next-text", "The scan is finished")
    check.wait("#scans", "finished")
    for name in FILES:
        download(check, name)
    check.take("finished")


def download(check: Check, name: str) -> None:
    with check.page.expect_download() as download:
        check.page.click(f"#downloads button[value='{name}']")
    size = download.value.path().stat().st_size
    check.expect(size > 100, f"{name} has {size} bytes")


def accept_and_delete(check: Check, server: Server) -> None:
    """A scan whose views somebody accepts, until it is deleted."""
    server.ask("/scans", new_scan("asked", confirm_views=True))
    check.page.goto(server.page("asked"))
    check.wait("#next-text", "to be accepted")
    check.page.click("#accept")
    check.wait("#next-text", "Move the camera to")
    check.page.select_option("#scans", "mug")
    check.wait("#next-text", "The scan is finished")
    check.page.select_option("#scans", "asked")
    check.wait("#next-text", "Move the camera to")
    server.ask("/scans/asked", method="DELETE")
    check.wait("#connection", "deleted")
    check.expect(check.page.is_disabled("#finish"), "a scan that is gone can be finished")


def new_scan(name: str, confirm_views: bool = False) -> dict:
    live = {"box_m": BOX_M}
    return {"id": name, "object": "mug", "views": 8, "candidates": 200, "confirm_views": confirm_views, "live": live}


def check_all(browser, program: str, take_frame: str, pictures: Path | None) -> list[str]:
    check = Check(browser, pictures)
    axe = axe_source()
    with tempfile.TemporaryDirectory() as work:
        folder = Path(work)
        with Server(program, folder / "scans") as server:
            server.ask("/scans", new_scan("mug"))
            robot = Robot(server, take_frame, "mug", folder)
            watch_scan(check, robot, server)
            look_at_all_sizes(check, server, axe)
            finish(check)
            accept_and_delete(check, server)
            # Its page would say that it is gone.
            check.page.goto("about:blank")
        with Server(program, folder / "scans") as server:
            check.page.goto(server.page("mug"))
            check.wait("#shown", f"{N_FRAMES} of {N_FRAMES}")
            check.expect(check.page.evaluate(FILLED) > 0.08, "a finished scan is not shown after a restart")
            enlarge(check)
            download(check, "report.html")
            check.take("past")
    return check.wrong


def main() -> int:
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        return skipped("the live page in a browser", "playwright", "playwright is not installed")
    program, take_frame, *folder = sys.argv[1:]
    with sync_playwright() as playwright:
        browser = start_browser(playwright)
        if not browser:
            return skipped("the live page in a browser", "chromium", "there is no chromium")
        wrong = check_all(browser, program, take_frame, Path(folder[0]) if folder else None)
        browser.close()
    print("\n".join(wrong) or f"a scan of {N_FRAMES} frames on the live page, nothing wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
