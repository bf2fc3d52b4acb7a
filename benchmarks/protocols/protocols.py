#!/usr/bin/env python3
"""Our planners under the protocols of others: ObjView-Bench (arXiv 2605.10707) and PB-NBV (arXiv 2501.10663).

    benchmarks/protocols/protocols.py target/release/nextview OUT objview MESH...                     # resumes what was begun
    benchmarks/protocols/protocols.py target/release/nextview OUT pb-nbv MESH... --reach half hemisphere

Runs the built-in specification of that name, with the candidates that are within each reach, and writes OUT/PROTOCOL.md.
"""

import argparse
import csv
import io
import pathlib
import random
import re
import statistics
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
SPECS = HERE / "../../crates/nextview-campaign/src/spec/specs"
# Lowest coordinates of the candidates within reach: the object is in the middle of the world.
REACHES = {
    "whole": (None, None, None),
    "hemisphere": (None, None, 0),
    "half": (None, 0, None),
    "quarter": (0, None, 0),
    "eighth": (0, 0, 0),
}
RULES = {"objview": ("tammes", 360), "pb-nbv": ("rings", 800)}
# Metres per unit of ObjView-Bench, and its budgets: moves after the first view.
UNIT_M = 0.1
MOVES = (5, 10, 30)
FAR = 100.0
N_RESAMPLES = 10_000


def is_within(reach, position):
    """Whether a candidate at this position is within this reach."""
    return all(lowest is None or x >= lowest for lowest, x in zip(REACHES[reach], position))


def directions(program, protocol):
    """The directions of the candidates."""
    rule, count = RULES[protocol]
    command = [program, "views", "--rule", rule, "--count", str(count), "--size-m", "1"]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return [tuple(float(row[f"{axis}_m"]) for axis in "xyz") for row in csv.DictReader(io.StringIO(text))]


def specification(program, protocol, reach):
    """The text of the campaign with the candidates within reach."""
    text = (SPECS / f"{protocol}.toml").read_text(encoding="utf-8")
    if reach == "whole":
        return text
    left = [i for i, position in enumerate(directions(program, protocol)) if is_within(reach, position)]
    lowest = [-FAR if x is None else x for x in REACHES[reach]]
    text = text.replace("[scan]\n", f"[scan]\nreach.allowed_boxes_m = [{lowest + 3 * [FAR]}]\n")
    # The candidates are numbered anew.
    if protocol == "pb-nbv":
        first = int(re.search(r"first_views = \[(\d+)\]", text)[1])
        return text.replace(f"first_views = [{first}]", f"first_views = [{left.index(first)}]")
    return text.replace("scan.views = 360", f"scan.views = {len(left)}")


def rows(path):
    """The rows of a CSV table."""
    return list(csv.DictReader(open(path, encoding="utf-8")))


def steps_of(campaign):
    """By variant and object, the steps of each run in order."""
    found = {}
    for row in rows(campaign / "steps.csv"):
        run = (row["seed"], row["view_seed"], row["first_view"])
        found.setdefault(row["variant"], {}).setdefault(row["object"], {}).setdefault(run, []).append(row)
    return found


def after(steps, n_views, key):
    """The value of a run after so many views, or after its last."""
    return float(steps[min(n_views, len(steps)) - 1][key])


def by_object(runs_of_object, value):
    """The mean over the runs of each object."""
    return {name: statistics.mean(value(name, steps) for steps in runs.values()) for name, runs in runs_of_object.items()}


def cells(shares):
    """Mean over objects with its 95 % interval by a bootstrap, and the lowest object, in %."""
    values = [100 * share for share in shares.values()]
    draw = random.Random(0)
    means = sorted(statistics.fmean(draw.choices(values, k=len(values))) for _ in range(N_RESAMPLES))
    low, high = means[N_RESAMPLES // 40], means[-N_RESAMPLES // 40 - 1]
    lowest = min(shares, key=shares.get)
    return f"{statistics.fmean(values):.1f} ({low:.1f} to {high:.1f}) | {100 * shares[lowest]:.1f} ({lowest})"


def objview(campaign):
    """SC and NSC at tolerances of 0.01 and 0.02 of the radius, and the path in radii."""
    found = steps_of(campaign)
    all_views = {name: next(iter(runs.values()))[-1] for name, runs in found.pop("all views").items()}
    columns = [*(f"NSC@.02 after {n} moves" for n in MOVES), f"NSC@.01 after {MOVES[-1]}", f"SC@.02 after {MOVES[-1]}"]
    lines = ["| planner | " + "".join(f"{column}, % | lowest | " for column in columns) + f"path after {MOVES[1]}, radii |",
             "|---|" + "---:|---|" * len(columns) + "---:|"]
    for variant, objects in found.items():
        def normalised(n_moves, key):
            return by_object(objects, lambda name, steps: after(steps, n_moves + 1, key) / float(all_views[name][key]))
        shares = [normalised(n, "surface_coverage_2mm") for n in MOVES]
        shares.append(normalised(MOVES[-1], "surface_coverage_1mm"))
        shares.append(by_object(objects, lambda _, steps: after(steps, MOVES[-1] + 1, "surface_coverage_2mm")))
        path = by_object(objects, lambda _, steps: after(steps, MOVES[1] + 1, "trajectory_length_m") / UNIT_M)
        lines.append(f"| {variant} | " + " | ".join(map(cells, shares)) + f" | {statistics.mean(path.values()):.1f} |")
    return lines


def pb_nbv(campaign):
    """The share of the surface with a point within 5 mm, and the time of a decision."""
    times = {}
    for row in rows(campaign / "times.csv"):
        if row["step"] not in ("", "1"):
            times.setdefault(row["variant"], []).append(float(row["plan_time_ms"]))
    lines = ["| planner | surface within 5 mm after 10 views, % | lowest | median time of a decision, ms |", "|---|---:|---|---:|"]
    for variant, objects in steps_of(campaign).items():
        share = by_object(objects, lambda _, steps: after(steps, 10, "surface_coverage_5mm"))
        lines.append(f"| {variant} | {cells(share)} | {statistics.median(times[variant]):.0f} |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("protocol", choices=list(RULES))
    parser.add_argument("meshes", nargs="+", metavar="MESH", help="file, or builtin:NAME")
    parser.add_argument("--reach", nargs="+", default=["whole"], choices=list(REACHES))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    names = ", ".join(pathlib.Path(mesh).stem for mesh in options.meshes)
    lines = [f"# Protocol {options.protocol}", "",
             "Written by `benchmarks/protocols/protocols.py`; explained in [protocols](../protocols.md). Means over objects with 95 %",
             f"intervals, which with few objects are too narrow. Objects: {names}.", ""]
    for reach in options.reach:
        campaign = options.out / f"{options.protocol}-{reach}"
        if campaign.exists():
            command = ["bench", "--resume", "--out", campaign]
        else:
            spec = options.out / f"{options.protocol}-{reach}.toml"
            spec.write_text(specification(options.program, options.protocol, reach), encoding="utf-8")
            command = ["bench", spec, *options.meshes, "--out", campaign]
        if subprocess.run([options.program, *command]).returncode != 0:
            sys.exit(f"{campaign}: the campaign did not run, or some of its runs failed")
        table = objview(campaign) if options.protocol == "objview" else pb_nbv(campaign)
        lines += [f"## {reach}", "", *table, ""]
    page = options.out / f"{options.protocol}.md"
    page.write_text("\n".join(lines), encoding="utf-8")
    print(page)


if __name__ == "__main__":
    main()
