#!/usr/bin/env python3
"""Every planner in eight settings: voxels of 5 mm and 1 cm, all around and on a table, with and without noise.

    benchmarks/planners/settings.py target/release/nextview OUT MESH ...                         # all eight; resumes unfinished ones
    benchmarks/planners/settings.py target/release/nextview OUT MESH ... --only 5mm 5mm-table-noise
    benchmarks/planners/settings.py target/release/nextview OUT MESH ... --spec headline         # another file of this folder

Each setting is a campaign in OUT with its report. OUT/settings.csv has all settings, OUT/settings-objects.csv the default
planner on each object. docs/tables.md explains the columns.
"""

import argparse
import csv
import pathlib
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
    """By variant and measure, the statistics of a campaign, which is run or resumed first."""
    command = ["bench", "--resume", "--out", campaign] if campaign.exists() else ["bench", spec, *meshes, "--out", campaign]
    if subprocess.run([program, *command]).returncode != 0:
        sys.exit(f"{campaign}: the campaign did not run, or some of its runs failed")
    subprocess.run([program, "report", campaign], check=True, stdout=subprocess.DEVNULL)
    return {(row["variant"], row["measure"]): row for row in rows_of(campaign / "statistics.csv")}


def rows_of(path):
    """The rows of a CSV table."""
    return list(csv.DictReader(open(path, encoding="utf-8")))


def write(path, rows):
    """Writes rows with the same columns as a CSV table."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def measures(setting, variant, found):
    """A row of the table of settings."""
    skill = found[variant, "skill"]
    return {
        "setting": setting,
        "variant": variant,
        "skill": skill["value"],
        "skill_low": skill["low"],
        "skill_high": skill["high"],
        "lowest_skill": skill["worst"],
        "lowest_object": skill["worst_object"],
        "views_to_95": found[variant, "views to 95 %"]["value"],
        "reachable_coverage_percent": found[variant, "reachable coverage, %"]["value"],
    }


def spread(skills):
    """Mean, lowest and highest."""
    return [f"{value:.2f}" for value in (statistics.mean(skills), min(skills), max(skills))]


def on_objects(setting, campaign):
    """The default planner on each object: a row of the table of objects."""
    found = {}
    for row in rows_of(campaign / "runs.csv"):
        if row["variant"] == DEFAULT:
            found.setdefault(row["object"], []).append(float(row["skill"]))
    columns = ["setting", "object", "skill", "lowest_skill", "highest_skill"]
    return [dict(zip(columns, [setting, name, *spread(skills)])) for name, skills in found.items()]


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
    of_settings, of_objects = [], []
    for setting in options.only:
        spec, campaign = options.out / f"{setting}.toml", options.out / setting
        spec.write_text(variants.replace("[scan]\n", f"[scan]\n{SETTINGS[setting]}"), encoding="utf-8")
        found = run(options.program, campaign, spec, options.meshes)
        # All settings have the order of the first.
        order = [row["variant"] for row in of_settings] or [name for name, measure in found if measure == "skill"]
        of_setting = [measures(setting, name, found) for name in dict.fromkeys(order)]
        of_settings += of_setting if of_settings else sorted(of_setting, key=lambda row: -float(row["skill"]))
        of_objects += on_objects(setting, campaign)
        write(options.out / "settings.csv", of_settings)
        write(options.out / "settings-objects.csv", of_objects)
    print(options.out / "settings.csv")


if __name__ == "__main__":
    main()
