#!/usr/bin/env python3
"""The benchmark of reality: objects at their true size, depth noise, a table to be found, a growing box, wrong poses.

    benchmarks/reality/reality.py target/release/nextview OUT                    # all objects, resumes an unfinished campaign
    benchmarks/reality/reality.py target/release/nextview OUT --only tless mug   # objects whose names contain one of these
    benchmarks/reality/reality.py target/release/nextview OUT --planners most-surface random --errors 2

Six planners, the default one also with registration, scan every mesh of the reference data with a known unit, and three
scaled ones of 40, 400 and 600 mm, with pose errors of 0, 2 and 10 mm (0, 0.2 and 1 degree; standard deviation on each axis).
OUT/reality.md has the tables: a scan that failed counts as one that saw nothing. The data are in the folder that
NEXTVIEW_DATA names.
"""

import argparse
import csv
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
DATA = pathlib.Path(os.environ.get("NEXTVIEW_DATA", HERE / "../../../shared/data")).resolve()
REGISTERED = "most-surface, registered"
PLANNERS = ["most-surface", REGISTERED, "max-flow", "rear-side-voxel", "even-views", "random", "clairvoyant"]
# Standard deviations of the poses, mm and degrees.
ERRORS = {0: 0.0, 2: 0.2, 10: 1.0}
# Objects without a unit, at sizes beyond those of the others, metres.
SCALED = {"other/ode_spot.ply": 0.04, "other/ode_koala.ply": 0.4, "other/common_rocker_arm.ply": 0.6}


def objects(only):
    """The tables of the specification's objects."""
    for row in csv.DictReader(open(DATA / "meshes/manifest.csv", encoding="utf-8")):
        path, name = DATA / "meshes" / row["file"], pathlib.Path(row["file"]).stem
        if only and not any(part in name for part in only):
            continue
        longest = max(float(row[f"extent_{axis}"]) for axis in "xyz")
        unit = row["unit"].split()[0]
        if row["file"] in SCALED:
            size = SCALED[row["file"]]
            yield f'{{ file = "{path}", size_m = {size}, name = "{name} scaled to {size * 1e3:.0f} mm" }}'
        elif unit in ("m", "mm") and longest * {"m": 1.0, "mm": 1e-3}[unit] <= 0.65:
            yield f'{{ file = "{path}", unit = "{unit}" }}'


def specification(options):
    """The text of the campaign."""
    parts = ["objects = [\n" + "".join(f"  {table},\n" for table in objects(options.only)) + "]\n"]
    parts.append((HERE / "reality.toml").read_text(encoding="utf-8"))
    for error in options.errors:
        for planner in options.planners:
            parts.append(f'[[variant]]\nlabel = "{planner}, {error} mm"\nscan.planner = "{planner.split(",")[0]}"\n'
                         f"scan.noise.pose_error_mm = {error}\nscan.noise.pose_error_deg = {ERRORS[error]}\n"
                         + ("scan.registration.enabled = true\n" if planner == REGISTERED else "")
                         + (f"seeds = {list(range(options.randoms))}\n" if planner == "random" else ""))
    return "\n".join(parts)


def measures(run):
    """Of a run: skill, final coverage over that of the planner that knows the object, model. Of a failed one, zeros."""
    record = run["result"].get("done", {}).get("record")
    if record is None or record.get("skill") is None:
        return {"skill": 0.0, "area": 0.0, "coverage": 0.0, "views": 0, "failed": 1}
    return {
        "skill": record["skill"],
        "area": record["coverage_auc_views"],
        "coverage": record["reachable_coverage"] / record["clairvoyant_curve"][-1],
        "views": record["views"],
        "failed": 0,
        "complete_1mm": record["cloud_completeness_1mm"],
        "complete_2mm": record["cloud_completeness_2mm"],
        "f_1mm": record["cloud_f_score_1mm"],
        "f_2mm": record["cloud_f_score_2mm"],
    }


def interval(values):
    """Mean, and for ten values the 95 % interval of the mean by Student's t, as text."""
    mean = statistics.mean(values)
    if len(values) != 10:
        return f"{mean:+.1f}"
    half = 2.262 * statistics.stdev(values) / math.sqrt(10)
    return f"{mean:+.1f} ({mean - half:+.1f} to {mean + half:+.1f})"


def of_planner(found):
    """A row of a table: means over the objects, and the worst of them."""
    of = lambda key: {name: statistics.mean(run.get(key, 0.0) for run in runs) for name, runs in found.items()}
    mean = lambda key: statistics.mean(of(key).values())
    worst = lambda key: min((value, name) for name, value in of(key).items())
    return (f"{mean('skill'):.2f} | {worst('skill')[0]:.2f} ({worst('skill')[1]}) | {mean('coverage'):.3f} "
            f"| {worst('coverage')[0]:.3f} ({worst('coverage')[1]}) | {mean('complete_1mm'):.1%} | {mean('complete_2mm'):.1%} "
            f"| {mean('f_1mm'):.1%} | {mean('f_2mm'):.1%} | {sum(run['failed'] for runs in found.values() for run in runs)}")


def page(runs, options):
    """The tables as Markdown."""
    by_variant = {}
    for run in runs:
        by_variant.setdefault(run["variant"], {}).setdefault(run["object"], []).append(measures(run))
    lines = ["# Reality", "", f"Made by `benchmarks/reality/reality.py` on {len({r['object'] for r in runs})} objects at true size.", ""]
    for error in options.errors:
        lines += [f"## Poses off by {error} mm and {ERRORS[error]} degrees", "",
                  "| planner | skill, mean | lowest | coverage over clairvoyant, mean | lowest | cloud within 1 mm | 2 mm "
                  "| F-score 1 mm | 2 mm | failed |", "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|"]
        for planner in options.planners:
            found = by_variant.get(f"{planner}, {error} mm")
            lines += [f"| {planner} | {of_planner(found)} |"] if found else []
        lines.append("")
    planner = options.planners[0]
    lines += ["## Objects", "", f"Of {planner}: skill, final coverage over that of the planner that knows the object, and the area "
              "under its curve less that of random scans, points, of ten with a 95 % interval of the mean.", "",
              "| object | " + " | ".join(f"{error} mm | | less random" for error in options.errors) + " |",
              "|---|" + "---:|---:|---:|" * len(options.errors)]
    for name in sorted({run["object"] for run in runs}):
        cells = []
        for error in options.errors:
            of = lambda planner: by_variant.get(f"{planner}, {error} mm", {}).get(name, [])
            own, random = of(planner), of("random")
            cells += [f"{own[0]['skill']:.2f} | {own[0]['coverage']:.3f}" if own else " | "]
            difference = [100 * (own[0]["area"] - run["area"]) for run in random] if own else []
            cells.append(interval(difference) if difference else "")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def campaign(program, out, specification):
    """Runs the campaign of a specification in a folder, or what is left of it; returns its runs."""
    if not (DATA / "meshes/manifest.csv").exists():
        sys.exit(f"{DATA / 'meshes/manifest.csv'}: no such file; NEXTVIEW_DATA names the folder of the reference data")
    out.mkdir(parents=True, exist_ok=True)
    folder, file = out / "campaign", out / "spec.toml"
    if folder.exists():
        command = ["bench", "--resume", "--out", folder]
    else:
        file.write_text(specification(), encoding="utf-8")
        command = ["bench", file, "--out", folder]
    # A run that failed is a result here; bench ends with 1 then.
    if subprocess.run([program, *command]).returncode not in (0, 1):
        sys.exit("the campaign did not run")
    return [json.loads(line) for line in open(folder / "runs.jsonl", encoding="utf-8")]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--only", nargs="+", metavar="PART")
    parser.add_argument("--planners", nargs="+", default=PLANNERS, choices=PLANNERS)
    parser.add_argument("--errors", nargs="+", type=int, default=list(ERRORS), choices=list(ERRORS))
    parser.add_argument("--randoms", type=int, default=10, metavar="N", help="random scans of each object (default: 10)")
    options = parser.parse_args()
    runs = campaign(options.program, options.out, lambda: specification(options))
    (options.out / "reality.md").write_text(page(runs, options), encoding="utf-8")
    print(options.out / "reality.md")


if __name__ == "__main__":
    main()
