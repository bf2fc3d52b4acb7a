#!/usr/bin/env python3
"""Prints the parts of the program, as CycloneDX 1.6 in JSON: every crate with its licence and its checksum in
Cargo.lock. The same sources give the same bytes.

Crates of scope "required" are in the program; those of scope "excluded" only took part in building it.

Usage: sbom.py [TARGET]
"""

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = "nextview-cli"
LINE = re.compile(r"(?P<depth>\d+)(?P<name>\S+) v(?P<version>\S+)[^\t]*\t(?P<license>[^\t]*)\t(?P<repository>\S*)")


def tree(edges: str, target: str) -> list[re.Match]:
    """The lines of `cargo tree`, which has the features of this program alone; `cargo metadata` has those of all."""
    command = ["cargo", "tree", "--locked", "--package", PACKAGE, "--target", target, "--edges", edges]
    command += ["--prefix", "depth", "--format", "{p}\t{l}\t{r}"]
    lines = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    matches = [LINE.match(line) for line in lines]
    if not all(matches):
        sys.exit(f"cargo tree: unexpected line {lines[matches.index(None)]!r}")
    return matches


def reference(crate: re.Match) -> str:
    return f"pkg:cargo/{crate['name']}@{crate['version']}"


def dependencies(lines: list[re.Match]) -> dict[str, set[str]]:
    """The direct dependencies of each crate. A crate that comes again is printed without its own."""
    found: dict[str, set[str]] = {}
    path: list[str] = []
    for crate in lines:
        del path[int(crate["depth"]):]
        found.setdefault(reference(crate), set())
        if path:
            found[path[-1]].add(reference(crate))
        path.append(reference(crate))
    return found


def component(crate: re.Match, checksums: dict[str, str], required: set[str]) -> dict:
    ref = reference(crate)
    described = {
        "type": "library",
        "bom-ref": ref,
        "name": crate["name"],
        "version": crate["version"],
        "scope": "required" if ref in required else "excluded",
        # Old manifests separate licences by a slash.
        "licenses": [{"expression": crate["license"].replace("/", " OR ")}],
        "purl": ref,
    }
    if ref in checksums:
        described["hashes"] = [{"alg": "SHA-256", "content": checksums[ref]}]
    if crate["repository"]:
        described["externalReferences"] = [{"type": "vcs", "url": crate["repository"]}]
    return described


def main() -> None:
    target = sys.argv[1] if len(sys.argv) > 1 else "x86_64-unknown-linux-gnu"
    locked = tomllib.loads((ROOT / "Cargo.lock").read_text())["package"]
    checksums = {f"pkg:cargo/{p['name']}@{p['version']}": p["checksum"] for p in locked if "checksum" in p}
    lines = tree("normal,build", target)
    required = {reference(crate) for crate in tree("normal,no-proc-macro", target)}
    crates = {reference(crate): component(crate, checksums, required) for crate in lines}
    program = crates.pop(reference(lines[0]))
    program.update(type="application", name="nextview")
    graph = sorted((ref, sorted(needs)) for ref, needs in dependencies(lines).items())
    bom = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": program},
        "components": [crates[ref] for ref in sorted(crates)],
        "dependencies": [{"ref": ref, "dependsOn": needs} for ref, needs in graph],
    }
    print(json.dumps(bom, indent=2))


main()
