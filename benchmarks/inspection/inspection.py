#!/usr/bin/env python3
"""The share of a part that is measured as required, by views planned for inspection and by others.

    benchmarks/inspection/inspection.py target/release/nextview OUT              # eight parts; OUT/inspection.md has the table
    benchmarks/inspection/inspection.py target/release/nextview OUT tless/tless_10.ply ...

Every part is scanned at its true size with the noise of a D435i on a table that is found, after 4, 8 and 12 views.
All of its surface must be seen within 45 degrees of its normal, with a point on each square millimetre, in one
picture. The planner of inspections has the part's mesh as CAD model, in another place, and does not know where the
part stands; `looks` is the default planner, with such a look required for everything it finds. Random views are the
mean of two scans. No scan stops by itself. Shares are of the surface that any candidate could show in this way. Needs
trimesh. Scans that were done before are read again. The meshes are in the folder that NEXTVIEW_DATA names.
"""

import argparse
import json
import os
import pathlib
import random
import shutil
import statistics
import subprocess

import trimesh

# Where the CAD model is, beside the part.
MOVED = trimesh.transformations.rotation_matrix(2.1, [0.3, -0.4, 0.87])

HERE = pathlib.Path(__file__).resolve().parent
MESHES = pathlib.Path(os.environ.get("NEXTVIEW_DATA", HERE / "../../../shared/data")).resolve() / "meshes"
OBJECTS = [
    "tless/tless_02.ply", "tless/tless_05.ply", "tless/tless_10.ply", "tless/tless_12.ply", "tless/tless_15.ply",
    "lm/lm_obj_000005_can.ply", "lm/lm_obj_000013_iron.ply", "ycb/ycb_035_power_drill.ply",
]
VIEWS = [4, 8, 12]
PLANNERS = {"inspection": [0], "looks": [0], "most-surface": [0], "even-views": [0], "random": [1, 2]}
# most-surface that seeks the same, knowing no CAD model.
LOOKS = "[looks]\nn = 1\nangle_deg = 45\npoints_per_mm2 = 1\n"
CONFIG = """
views = {views}
seed = {seed}
view_seed = 0
view_space = "hemisphere"
baselines = false
planner = "{planner}"
[object_box]
table = "fit"
[stop]
progress = 0
[noise]
model = "d435i"
[reference]
mesh = "{reference}"
angle_deg = 45
points_per_mm2 = 1
"""


def cad_model(mesh, out):
    """The mesh, turned and shifted by a third of its size, as STL."""
    path = out / f"{mesh.stem}.stl"
    if not path.exists():
        model = trimesh.load(mesh, force="mesh", process=False)
        model.apply_transform(MOVED)
        model.apply_translation(model.extents / 3)
        model.export(path)
    return path


def inspected(program, out, mesh, planner, seed, views):
    """The share of the surface that was measured as required, and the share that any candidate could show."""
    folder, report = out / f"{mesh.stem}-{planner}-{seed}-{views}", out / f"{mesh.stem}-{planner}-{seed}-{views}-report"
    if not (report / "inspection.json").exists():
        shutil.rmtree(folder, ignore_errors=True)
        config = folder.with_suffix(".toml")
        name, goal = ("most-surface", LOOKS) if planner == "looks" else (planner, "")
        config.write_text(CONFIG.format(planner=name, seed=seed, views=views, reference=cad_model(mesh, out)) + goal, encoding="utf-8")
        quietly(program, "scan", mesh, "--config", config, "--out", folder)
        quietly(program, "inspect", folder, "--out", report, "--force")
    found = json.loads((report / "inspection.json").read_text(encoding="utf-8"))
    steps = json.loads((folder / "record.json").read_text(encoding="utf-8"))["steps"]
    said = [step.get("explanation", {}).get("measurable_as_demanded_share") for step in steps]
    measurable = next((share for share in said if share), None)
    return found["surfaces"][0]["measured_share"], measurable


def quietly(*words):
    subprocess.run(list(map(str, words)), check=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def interval(values):
    """The mean, and 95 % of the means of values drawn from these with replacement."""
    drawn = random.Random(0)
    means = sorted(statistics.mean(drawn.choices(values, k=len(values))) for _ in range(10_000))
    return f"{100 * statistics.mean(values):+.1f} ({100 * means[250]:+.1f} to {100 * means[9749]:+.1f})"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=lambda path: pathlib.Path(path).resolve())
    parser.add_argument("out", type=lambda path: pathlib.Path(path).resolve())
    parser.add_argument("objects", nargs="*", default=OBJECTS)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    meshes = [MESHES / name for name in given.objects]
    shares = {}
    for mesh in meshes:
        measurable = None
        for planner, seeds in PLANNERS.items():
            for views in VIEWS:
                found = [inspected(given.program, given.out, mesh, planner, seed, views) for seed in seeds]
                measurable = measurable or found[0][1]
                share = statistics.mean(share for share, _ in found) / measurable
                shares[mesh.stem, planner, views] = share
        print(mesh.stem, *[f"{planner} {[round(shares[mesh.stem, planner, n], 3) for n in VIEWS]}" for planner in PLANNERS], flush=True)
    lines = ["| views | " + " | ".join(PLANNERS) + " | inspection - most-surface | looks - most-surface |", "|---:|" + "---:|" * (len(PLANNERS) + 2)]
    for views in VIEWS:
        of = {planner: [shares[mesh.stem, planner, views] for mesh in meshes] for planner in PLANNERS}
        cells = [f"{100 * statistics.mean(values):.1f} % ({100 * min(values):.1f})" for values in of.values()]
        pairs = [("inspection", "most-surface"), ("looks", "most-surface")]
        beside = [interval([ours - theirs for ours, theirs in zip(of[one], of[other])]) for one, other in pairs]
        lines.append("| " + " | ".join([str(views), *cells, *beside]) + " |")
    table = "\n".join(lines) + "\n"
    (given.out / "inspection.md").write_text(table, encoding="utf-8")
    print(table)


if __name__ == "__main__":
    main()
