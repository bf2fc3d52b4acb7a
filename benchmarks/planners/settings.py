#!/usr/bin/env python3
"""Every planner in eight settings: voxels of 5 mm and 1 cm, all around and on a table, with and without noise.

    benchmarks/planners/settings.py target/release/nextview OUT MESH ...                         # all eight; resumes unfinished ones
    benchmarks/planners/settings.py target/release/nextview OUT MESH ... --only 5mm 5mm-table-noise
    benchmarks/planners/settings.py target/release/nextview OUT MESH ... --spec headline         # another file of this folder

Each setting is a campaign in OUT with its report. OUT/settings.md has the tables of all settings.
"""

import argparse
import csv
import pathlib
import re
import statistics
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
DEFAULT = "most-surface"
TABLE = 'object_box.table = "known"\n'
NOISE = 'noise = { model = "d435i", pose_error_mm = 2, pose_error_deg = 0.2 }\n'
SETTINGS = {
    f"{voxel}{name}": f"voxel_size_m = {size}\n{keys}"
    for name, keys in {"": "", "-table": TABLE, "-noise": NOISE, "-table-noise": TABLE + NOISE}.items()
    for voxel, size in {"5mm": 0.005, "1cm": 0.01}.items()
}


def run(program, campaign, spec, meshes):
    """The report of a campaign, which is run or resumed first."""
    command = ["bench", "--resume", "--out", campaign] if campaign.exists() else ["bench", spec, *meshes, "--out", campaign]
    if subprocess.run([program, *command]).returncode != 0:
        sys.exit(f"{campaign}: the campaign did not run, or some of its runs failed")
    subprocess.run([program, "report", campaign], check=True, stdout=subprocess.DEVNULL)
    return (campaign / "report.md").read_text(encoding="utf-8")


def table(report, caption, columns):
    """By variant, the cells of these columns in the report's table below a caption."""
    lines = report[report.index(caption):].split("\n\n")[1].splitlines()
    head, _, *rows = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip("|"))] for line in lines]
    return {row[0]: [row[head.index(column)] for column in columns] for row in rows}


def with_interval(cell):
    """A cell of the report without its median."""
    return cell.split(", median")[0] + ")"


def measures(report):
    """By variant, the cells of a setting's table."""
    reached = table(report, "Results after the last view", ["skill", "reachable coverage, %"])
    lowest = table(report, "The worst object", ["skill"])
    views = table(report, "Views until this share", ["95 %"])
    model = table(report, "Final map and cloud", ["F-score of the cloud at 2 mm, %", "Chamfer distance of the cloud, mm"])
    mean = lambda cell: re.match("(≥ )?[^ ]*", cell)[0]
    return {
        name: [with_interval(skill), *lowest[name], mean(*views[name]), mean(coverage), *map(mean, model[name])]
        for name, (skill, coverage) in reached.items()
    }


def skills_by_object(campaign, variant):
    """By object, the skill of each run of a variant."""
    found = {}
    for row in csv.DictReader(open(campaign / "runs.csv", encoding="utf-8")):
        if row["variant"] == variant:
            found.setdefault(row["object"], []).append(float(row["skill"]))
    return found


def spread(skills):
    """Mean, lowest and highest."""
    return f"{statistics.mean(skills):.2f} ({min(skills):.2f} to {max(skills):.2f})"


def rows(head, body):
    """The lines of a table."""
    return ["| " + " | ".join(head) + " |", "|---|" + "---:|" * (len(head) - 1), *(f"| {' | '.join(row)} |" for row in body)]


def page(found, by_object):
    """All settings side by side, each by itself, and the default planner on each object, as Markdown."""
    variants = sorted(next(iter(found.values())), key=lambda name: -float(next(iter(found.values()))[name][0].split(" ")[0]))
    lines = rows(["", *found], [
        [name, *(f"{of[name][0]}, {of[name][1].split(' ')[0]}" for of in found.values())] for name in variants
    ])
    head = ["", "skill", "lowest", "views to 95 %", "reachable coverage, %", "F-score 2 mm, %", "Chamfer, mm"]
    for setting, of in found.items():
        lines += ["", f"## {setting}", "", *rows(head, [[name, *of[name]] for name in variants])]
    objects = next(iter(by_object.values()))
    lines += ["", f"## {DEFAULT} on each object: mean, lowest and highest of its runs", "", *rows(
        ["object", *by_object], [[name, *(spread(of[name]) for of in by_object.values())] for name in objects]
    )]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("meshes", nargs="+", metavar="MESH", help="files, or builtin:NAME; at least two")
    parser.add_argument("--only", nargs="+", default=list(SETTINGS), choices=list(SETTINGS), metavar="SETTING")
    parser.add_argument("--spec", default="all", help="file of this folder without its extension; default: all")
    options = parser.parse_args()
    if len(options.meshes) < 2:
        parser.error("a table with the lowest skill needs at least two meshes")
    options.out.mkdir(parents=True, exist_ok=True)
    variants = (HERE / f"{options.spec}.toml").read_text(encoding="utf-8")
    found, by_object = {}, {}
    for setting in options.only:
        spec = options.out / f"{setting}.toml"
        spec.write_text(variants.replace("[scan]\n", f"[scan]\n{SETTINGS[setting]}"), encoding="utf-8")
        found[setting] = measures(run(options.program, options.out / setting, spec, options.meshes))
        by_object[setting] = skills_by_object(options.out / setting, DEFAULT)
        (options.out / "settings.md").write_text(page(found, by_object), encoding="utf-8")
    print(options.out / "settings.md")


if __name__ == "__main__":
    main()
