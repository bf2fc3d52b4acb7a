#!/usr/bin/env python3
"""Builds the site of the documentation in target/site/book.

    docs/site.py                # with `mdbook` (cargo install mdbook --locked), or the program that MDBOOK names

mdBook reads one folder, but pages are where readers of the sources look for them: README.md, docs, python, crates. This
stages them at their places in target/site, with the files that they link to: a source becomes a page, a CSV file a table.
Every link and anchor of the finished site is checked.
"""

from __future__ import annotations

import csv
import html.parser
import os
import re
import shutil
import subprocess
import sys
import urllib.parse
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SITE = ROOT / "target/site"
BOOK = SITE / "book"
PICTURES = {".png", ".svg", ".webp"}
LANGUAGES = {".rs": "rust,ignore", ".py": "python"}
# A link, or code, in which nothing is a link.
LINK = re.compile(
    r"^ *```.*?^ *```|^(?:    [^\n]*\n)+|`[^`]+`|"
    r"(?P<image>!?)\[(?P<text>(?:[^\[\]]|\[[^\]]*\])*)\]\((?P<link>[^)\s]+)\)",
    re.MULTILINE | re.DOTALL,
)


def rename(path: Path) -> Path:
    """The page of a file: index.md in place of README.md, and source.rs.md for a source."""
    if path.name == "README.md":
        return path.with_name("index.md")
    return path if path.suffix == ".md" else path.with_name(path.name + ".md")


def stage(page: Path, linked: set[Path], book_from: Path | None = None) -> str:
    """The text of a page with links as they are in the book; collects the files that it links to."""

    def replace(match: re.Match[str]) -> str:
        image, text, (link, _, anchor) = match["image"], match["text"], (match["link"] or "").partition("#")
        if not link or ":" in link:
            return match[0]
        path = Path(os.path.normpath(page.parent / link))
        if (ROOT / path).is_dir():
            return text
        linked.add(path)
        path = path if image or path.suffix in PICTURES else rename(path)
        link = os.path.relpath(path, page.parent if book_from is None else book_from)
        return f"{image}[{text}]({link}{'#' * bool(anchor)}{anchor})"

    return LINK.sub(replace, (ROOT / page).read_text(encoding="utf-8"))


def write(path: Path, text: str) -> None:
    (SITE / "src" / path).parent.mkdir(parents=True, exist_ok=True)
    (SITE / "src" / path).write_text(text, encoding="utf-8")


def shown(path: Path) -> str:
    """A file as Markdown: the rows of CSV as a table, anything else literally."""
    text = (ROOT / path).read_text(encoding="utf-8")
    if path.suffix != ".csv":
        return f"````{LANGUAGES.get(path.suffix, 'text')}\n{text}````\n"
    head, *rows = [[re.sub(r"[\\`*_<|]", r"\\\g<0>", cell) for cell in row] for row in csv.reader(text.splitlines())]
    return "".join(f"| {' | '.join(row)} |\n" for row in [head, ["---"] * len(head), *rows])


def stage_all() -> None:
    """All pages of the summary, and what they link to."""
    pages: set[Path] = set()
    summary = stage(Path("docs/SUMMARY.md"), pages, Path("."))
    linked: set[Path] = set()
    for page in sorted(pages):
        write(rename(page), stage(page, linked))
    sources = sorted(path for path in linked - pages if path.suffix not in PICTURES)
    for path in sorted(linked - pages - set(sources)):
        (SITE / "src" / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / path, SITE / "src" / path)
    for path in sources:
        write(rename(path), f"# {path.name}\n\n`{path}`\n\n{shown(path)}")
    rows = [f"- [{path.parent.name}/{path.name}]({rename(path)})\n" for path in sources]
    write(Path("SUMMARY.md"), summary + "\n# Files\n\n" + "".join(rows))


class Page(html.parser.HTMLParser):
    """Links and anchors of a page."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self.anchors.add(values.get("id") or "")
        self.links += [value for value in (values.get("href"), values.get("src")) if value]


def faults() -> list[str]:
    """Links of the finished site that lead nowhere."""
    pages = {path: Page(path) for path in BOOK.rglob("*.html") if path.name not in ("404.html", "toc.html")}
    found = []
    for path, page in pages.items():
        for link in page.links:
            url = urllib.parse.urlsplit(link)
            if url.scheme or url.netloc:
                continue
            to = Path(os.path.normpath(path.parent / urllib.parse.unquote(url.path))) if url.path else path
            anchors = pages[to].anchors if to in pages else set()
            if not to.is_file() or (url.fragment and urllib.parse.unquote(url.fragment) not in anchors):
                found.append(f"{path.relative_to(BOOK)}: {link}")
    return sorted(set(found))


def main() -> None:
    shutil.rmtree(SITE, ignore_errors=True)
    stage_all()
    for name in ("book.toml", "site.css"):
        shutil.copyfile(ROOT / "docs" / name, SITE / name)
    subprocess.run([os.environ.get("MDBOOK", "mdbook"), "build", str(SITE)], check=True)
    if broken := faults():
        sys.exit("links that lead nowhere:\n" + "\n".join(broken))
    print(f"{BOOK}/index.html")


if __name__ == "__main__":
    main()
