#!/usr/bin/env python3
"""Every planner in eight settings: voxels of 5 mm and 1 cm, all around and on a table, without noise and with it.

    benchmarks/planners/settings.py target/release/nextview OUT MESH ...                         # all eight; resumes what was begun
    benchmarks/planners/settings.py target/release/nextview OUT MESH ... --only 5mm 5mm-table-noise
    benchmarks/planners/settings.py target/release/nextview OUT MESH ... --spec headline         # another file of this folder

Each setting is a campaign in OUT with its report; OUT/settings.md has the skill of every planner in every setting.
"""

import argparse
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
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


def skills(report):
    """By variant, the mean skill with its interval, and that of the lowest of several objects, as the report has them."""
    table = report[report.index("| variant | objects |"):].split("\n\n")[0]
    head, _, *rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
    mean, lowest = head.index("skill"), head.index("lowest skill")
    without_median = lambda cell: cell.split(", median")[0].rstrip(")") + ")"
    return {row[0]: f"{without_median(row[mean])}, {row[lowest].split(' ')[0]}" for row in rows}


def page(found):
    """The skill of every variant in every setting as Markdown, sorted by the first setting."""
    first = next(iter(found.values()))
    variants = sorted(first, key=lambda name: -float(first[name].split(" ")[0]))
    lines = ["| | " + " | ".join(found) + " |", "|---|" + "---:|" * len(found)]
    for name in variants:
        lines.append(f"| {name} | " + " | ".join(table[name] for table in found.values()) + " |")
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
    found = {}
    for setting in options.only:
        spec = options.out / f"{setting}.toml"
        spec.write_text(variants.replace("[scan]\n", f"[scan]\n{SETTINGS[setting]}"), encoding="utf-8")
        found[setting] = skills(run(options.program, options.out / setting, spec, options.meshes))
        (options.out / "settings.md").write_text(page(found), encoding="utf-8")
    print(options.out / "settings.md")


if __name__ == "__main__":
    main()
