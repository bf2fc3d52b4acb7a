#!/usr/bin/env python3
"""The finished model: ours against what people do without us, in a robot cell with a ray caster that is not ours.

    benchmarks/model-end/model_end.py OUT                                          # the whole table; goes on where it ended
    benchmarks/model-end/model_end.py OUT --only tless_10 bracket --seeds 3 --errors "1.5 mm" --methods nextview "even views"

An object stands on a table of unknown height. A camera with a sensor's noise is moved by a robot that reports wrong poses:
each with errors of its own and all with one of the hand-eye calibration. Measured is the mesh that comes out, after one rigid
motion to the truth: the F-score at 1 mm after 6, 8 and 12 views and at the end, and the seconds of robot and computer.
OUT/model-end.md has the tables. Needs numpy, scipy, trimesh, open3d and the package nextview. Objects are those of the folder
that NEXTVIEW_DATA names, at true size, and a bracket that the benchmark makes itself.
"""

import argparse
import concurrent.futures
import importlib.util
import json
import os
import pathlib

import numpy as np
from cell import SENSORS, Cell, PoseErrors
from measure import Truth, pose_error_mm
from methods import METHODS

HERE = pathlib.Path(__file__).resolve().parent
MESHES = pathlib.Path(os.environ.get("NEXTVIEW_DATA", HERE / "../../../shared/data")).resolve() / "meshes"
PACKAGES = ["trimesh", "manifold3d", "open3d", "nextview"]
STAGES = [6, 8, 12]
ERRORS = {
    "exact": PoseErrors(),
    "0.5 mm": PoseErrors(.5, .07),
    "1.5 mm": PoseErrors(1.5, .2, 1.0),
    "4 mm": PoseErrors(4, .5, 5.0),
    "10 mm": PoseErrors(10, 1.0, 5.0),
    "hand-eye": PoseErrors(.1, .02, 5.0, .5),
}
OBJECTS = {
    "bracket": None,
    **{f"tless_{n:02}": (f"tless/tless_{n:02}.ply", 1e-3) for n in (1, 5, 6, 8, 10, 12)},
    **{name: (f"lm/{name}.ply", 1e-3) for name in ("lm_obj_000001_ape", "lm_obj_000005_can", "lm_obj_000009_duck",
                                                   "lm_obj_000010_eggbox")},
    **{name: (f"ycb/{name}.ply", 1.0) for name in (
        "ycb_003_cracker_box", "ycb_006_mustard_bottle", "ycb_011_banana", "ycb_019_pitcher_base", "ycb_024_bowl", "ycb_025_mug",
        "ycb_035_power_drill", "ycb_051_large_clamp", "ycb_061_foam_brick")},
}


def bracket():
    """An 80 mm plate with two ribs and a boss: planes that slide along each other, a hole, a narrow corner."""
    import trimesh

    def block(size, place):
        return trimesh.creation.box(size, trimesh.transformations.translation_matrix(place))

    boss = trimesh.creation.cylinder(.012, .024, sections=64)
    boss.apply_translation((.018, 0, .02))
    hole = trimesh.creation.cylinder(.006, .08, sections=64)
    hole.apply_translation((.018, 0, .02))
    solid = trimesh.boolean.union([block((.08, .05, .01), (0, 0, .005)), block((.01, .05, .05), (-.035, 0, .025)),
                                   block((.03, .006, .028), (-.017, .01, .02)), boss], engine="manifold")
    return trimesh.boolean.difference([solid, hole], engine="manifold")


def mesh_of(name):
    """The vertices, in metres, and triangles of an object."""
    import trimesh

    if OBJECTS[name] is None:
        mesh = bracket()
        return mesh.vertices, mesh.faces
    path, unit = OBJECTS[name]
    mesh = trimesh.load(MESHES / path, force="mesh")
    return mesh.vertices * unit, mesh.faces


def run(job):
    """The rows of a method on an object."""
    name, seed, errors, sensor, missing, method = job
    cell = Cell(mesh_of(name), seed, ERRORS[errors], SENSORS[sensor], missing)
    truth, rows = Truth(cell), []
    key = {"object": name, "seed": seed, "errors": errors, "sensor": sensor, "missing": missing, "method": method}
    for views, seconds, model, poses in METHODS[method](cell, STAGES):
        off = pose_error_mm(poses, cell.poses[-len(poses):], cell.low, cell.high)
        rows.append({**key, "views": views, "seconds": round(seconds, 2), "pose_error_mm": round(off, 3), **truth.quality(model)})
    rows[-1]["is_end"] = True
    return rows


def interval(values, rng):
    """The mean and its 95 % interval over objects (bootstrap)."""
    values = np.asarray(values, float)
    means = values[rng.integers(len(values), size=(4000, len(values)))].mean(1)
    return values.mean(), *np.quantile(means, [.025, .975])


def stage(rows, views):
    """By object: the mean F-score over seeds after so many views; an ended scan keeps its last."""
    scores = {}
    for row in rows:
        scores.setdefault((row["object"], row["seed"]), {})[row["views"]] = row["f1"]
    by_object = {}
    for (name, _), curve in scores.items():
        reached = [n for n in curve if n <= views]
        by_object.setdefault(name, []).append(curve[max(reached)] if reached else 0.0)
    return {name: float(np.mean(values)) for name, values in by_object.items()}


def page(rows):
    """The tables as Markdown."""
    rng, lines = np.random.default_rng(0), []
    cells = sorted({(row["sensor"], row["missing"], row["errors"]) for row in rows}, key=lambda c: (c[:2], list(ERRORS).index(c[2])))
    for views in STAGES:
        lines += [f"## After {views} views", "",
                  "| sensor | poses off by | method | F-score at 1 mm | ours minus this | worst object |", "|---|---|---|---:|---:|---|"]
        for sensor, missing, errors in cells:
            here = [r for r in rows if (r["sensor"], r["missing"], r["errors"]) == (sensor, missing, errors)]
            ours = stage([r for r in here if r["method"] == "nextview"], views)
            for method in METHODS:
                scores = stage([r for r in here if r["method"] == method], views)
                if not scores:
                    continue
                mean, low, high = interval(list(scores.values()), rng)
                worst = min(scores, key=scores.get)
                lead = ""
                both = [name for name in scores if name in ours]
                if method != "nextview" and both:
                    lead = "{:+.1f} ({:+.1f} to {:+.1f})".format(*interval([ours[name] - scores[name] for name in both], rng))
                lost = f", {missing:.0%} missing" if missing else ""
                lines.append(f"| {sensor}{lost} | {errors} | {method} | {mean:.1f} ({low:.1f} to {high:.1f}) | {lead} | "
                             f"{scores[worst]:.1f} ({worst}) |")
        lines.append("")
    ends = [r for r in rows if r.get("is_end") and r["method"] == "nextview"]
    lines += ["## When ours ends", "", "| sensor | poses off by | views | seconds | F-score | mean error, mm |",
              "|---|---|---:|---:|---:|---:|"]
    for sensor, missing, errors in cells:
        here = [r for r in ends if (r["sensor"], r["missing"], r["errors"]) == (sensor, missing, errors)]
        if here:
            views, seconds, f1, error = (np.nanmean([r[key] for r in here]) for key in ("views", "seconds", "f1", "error_mm"))
            lines.append(f"| {sensor} | {errors} | {views:.1f} | {seconds:.0f} | {f1:.1f} | {error:.2f} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--only", nargs="+", metavar="PART", help="objects whose names contain one of these")
    parser.add_argument("--seeds", type=int, default=5, metavar="N")
    parser.add_argument("--errors", nargs="+", choices=list(ERRORS), default=list(ERRORS))
    parser.add_argument("--sensors", nargs="+", choices=list(SENSORS), default=["stereo"])
    parser.add_argument("--missing", nargs="+", type=float, default=[0.0], metavar="SHARE")
    parser.add_argument("--methods", nargs="+", choices=list(METHODS), default=list(METHODS))
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    names = [name for name in OBJECTS if not options.only or any(part in name for part in options.only)]
    if not names:
        parser.error(f"no object's name contains any of {options.only}; the objects are {', '.join(OBJECTS)}")
    absent = [str(MESHES / OBJECTS[name][0]) for name in names if OBJECTS[name] and not (MESHES / OBJECTS[name][0]).is_file()]
    if absent:
        parser.error(f"NEXTVIEW_DATA names a folder without {', '.join(absent)}; `--only bracket` needs no file")
    lacking = [package for package in PACKAGES if not importlib.util.find_spec(package)]
    if lacking:
        parser.error(f"install {', '.join(lacking)} first")
    options.out.mkdir(parents=True, exist_ok=True)
    kept = options.out / "rows.jsonl"
    rows = [json.loads(line) for line in kept.read_text(encoding="utf-8").splitlines()] if kept.exists() else []
    done = {tuple(row[key] for key in ("object", "seed", "errors", "sensor", "missing", "method")) for row in rows}
    jobs = [(name, seed, errors, sensor, missing, method)
            for seed in range(1, options.seeds + 1) for errors in options.errors for sensor in options.sensors
            for missing in options.missing for name in names for method in options.methods]
    with concurrent.futures.ProcessPoolExecutor(options.jobs) as pool, kept.open("a", encoding="utf-8") as file:
        for found in pool.map(run, [job for job in jobs if job not in done]):
            rows += found
            file.write("".join(json.dumps(row) + "\n" for row in found))
            file.flush()
    text = page(rows)
    (options.out / "model-end.md").write_text(text, encoding="utf-8")
    print(text, end="")


if __name__ == "__main__":
    main()
