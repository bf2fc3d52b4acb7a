#!/usr/bin/env python3
"""Prints the licence texts of all crates that are in the program, each text once, as their
licences require of anyone who distributes the program.

Usage: licenses.py SBOM, with the output of sbom.py; the sources must have been fetched.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NAME = re.compile(r"(licen[cs]e|copying|copyright|notice|unlicense)", re.IGNORECASE)


def folders() -> dict[str, Path]:
    """Where the sources of each crate are."""
    command = ["cargo", "metadata", "--locked", "--format-version", "1"]
    packages = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)["packages"]
    return {f"pkg:cargo/{p['name']}@{p['version']}": Path(p["manifest_path"]).parent for p in packages}


def main() -> None:
    crates = json.loads(Path(sys.argv[1]).read_text())["components"]
    sources = folders()
    by_text: dict[str, list[str]] = {}
    for crate in crates:
        # Our own crates are under the licences beside this file.
        if crate["scope"] != "required" or "hashes" not in crate:
            continue
        name = f"{crate['name']} {crate['version']} ({crate['licenses'][0]['expression']})"
        paths = [path for path in sorted(sources[crate["purl"]].iterdir()) if path.is_file() and NAME.match(path.name)]
        texts = [path.read_text(errors="replace").strip() for path in paths]
        for text in texts or ["The crate has no file with the text of its licence."]:
            by_text.setdefault(text, []).append(name)
    for text, names in by_text.items():
        print("=" * 80, *names, "-" * 80, text, "", sep="\n")


main()
