#!/usr/bin/env python3
"""The benchmark of reality: objects at their true size, depth noise, a table that is found, a box that grows, wrong poses.

    benchmarks/reality/reality.py target/release/nextview OUT                    # all objects, resumes what was begun
    benchmarks/reality/reality.py target/release/nextview OUT --only tless mug   # objects whose names contain one of these
    benchmarks/reality/reality.py target/release/nextview OUT --planners most-surface random --errors 2

Five planners scan every mesh of the reference data with a known unit, and three scaled ones of 40, 400 and 600 mm, with
pose errors of 0, 2 and 10 mm (0, 0.2 and 1 degree; standard deviation on each axis). OUT/reality.md has the tables: a scan
that failed counts as one that saw nothing. The data are in the folder that NEXTVIEW_DATA names.
"""

import argparse
import csv
import json
import os
import pathlib
import statistics
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
DATA = pathlib.Path(os.environ.get("NEXTVIEW_DATA", HERE / "../../../shared/data")).resolve()
PLANNERS = ["most-surface", "max-flow", "rear-side-voxel", "random", "clairvoyant"]
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
            parts.append(f'[[variant]]\nlabel = "{planner}, {error} mm"\nscan.planner = "{planner}"\n'
                         f"scan.noise.pose_error_mm = {error}\nscan.noise.pose_error_deg = {ERRORS[error]}\n")
    return "\n".join(parts)


def measures(run):
    """Of a run: skill, final coverage over that of the planner that knows the object, model. Of a failed one, zeros."""
    record = run["result"].get("done", {}).get("record")
    if record is None or record.get("skill") is None:
        return {"skill": 0.0, "coverage": 0.0, "views": 0, "failed": 1}
    return {
        "skill": record["skill"],
        "coverage": record["reachable_coverage"] / record["clairvoyant_curve"][-1],
        "views": record["views"],
        "failed": 0,
        "complete_1mm": record["cloud_completeness_1mm"],
        "complete_2mm": record["cloud_completeness_2mm"],
        "f_1mm": record["cloud_f_score_1mm"],
        "f_2mm": record["cloud_f_score_2mm"],
    }


def page(runs, options):
    """The tables as Markdown."""
    by_variant = {}
    for run in runs:
        by_variant.setdefault(run["variant"], {})[run["object"]] = measures(run)
    lines = ["# Reality", "", f"Made by `benchmarks/reality/reality.py` on {len({r['object'] for r in runs})} objects at true size.", ""]
    for error in options.errors:
        lines += [f"## Poses off by {error} mm and {ERRORS[error]} degrees", "",
                  "| planner | skill, mean | lowest | coverage over clairvoyant, mean | lowest | cloud within 1 mm | 2 mm "
                  "| F-score 1 mm | 2 mm | failed |", "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|"]
        for planner in options.planners:
            found = by_variant.get(f"{planner}, {error} mm", {})
            if not found:
                continue
            of = lambda key: [run.get(key, 0.0) for run in found.values()]
            worst = lambda key: min((run[key], name) for name, run in found.items())
            mean = lambda key: statistics.mean(of(key))
            lines.append(
                f"| {planner} | {mean('skill'):.2f} | {worst('skill')[0]:.2f} ({worst('skill')[1]}) | {mean('coverage'):.3f} "
                f"| {worst('coverage')[0]:.3f} ({worst('coverage')[1]}) | {mean('complete_1mm'):.1%} | {mean('complete_2mm'):.1%} "
                f"| {mean('f_1mm'):.1%} | {mean('f_2mm'):.1%} | {sum(of('failed'))} |")
        lines.append("")
    lines += ["## Objects", "", "Skill, and final coverage over that of the planner that knows the object.", ""]
    planner = options.planners[0]
    lines += [f"| {planner} | " + " | ".join(f"{error} mm" for error in options.errors) + " |",
              "|---|" + "---:|" * len(options.errors)]
    for name in sorted({run["object"] for run in runs}):
        cells = [by_variant.get(f"{planner}, {error} mm", {}).get(name) for error in options.errors]
        lines.append(f"| {name} | " + " | ".join("" if c is None else f"{c['skill']:.2f}, {c['coverage']:.3f}" for c in cells) + " |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--only", nargs="+", metavar="PART")
    parser.add_argument("--planners", nargs="+", default=PLANNERS, choices=PLANNERS)
    parser.add_argument("--errors", nargs="+", type=int, default=list(ERRORS), choices=list(ERRORS))
    options = parser.parse_args()
    if not (DATA / "meshes/manifest.csv").exists():
        sys.exit(f"{DATA / 'meshes/manifest.csv'}: no such file; NEXTVIEW_DATA names the folder of the reference data")
    options.out.mkdir(parents=True, exist_ok=True)
    campaign, spec = options.out / "campaign", options.out / "spec.toml"
    if campaign.exists():
        command = ["bench", "--resume", "--out", campaign]
    else:
        spec.write_text(specification(options), encoding="utf-8")
        command = ["bench", spec, "--out", campaign]
    # A run that failed is a result here; bench ends with 1 then.
    if subprocess.run([options.program, *command]).returncode not in (0, 1):
        sys.exit("the campaign did not run")
    runs = [json.loads(line) for line in open(campaign / "runs.jsonl", encoding="utf-8")]
    (options.out / "reality.md").write_text(page(runs, options), encoding="utf-8")
    print(options.out / "reality.md")


if __name__ == "__main__":
    main()
