#!/usr/bin/env python3
"""Our planners under the protocols of others: ObjView-Bench (arXiv 2605.10707) and PB-NBV (arXiv 2501.10663).

    benchmarks/protocols/protocols.py target/release/nextview OUT objview MESH...                     # resumes an unfinished campaign
    benchmarks/protocols/protocols.py target/release/nextview OUT pb-nbv MESH... --reach half hemisphere

Runs the built-in specification of that name, with the candidates that are within each reach, and writes OUT/PROTOCOL.csv and,
for PB-NBV, OUT/pb-nbv-objects.csv. docs/tables.md explains the columns.
"""

import argparse
import csv
import io
import pathlib
import re
import statistics
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "planners"))
import settings

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


def steps_of(campaign):
    """By variant and object, the steps of each run in order."""
    found = {}
    for row in settings.rows_of(campaign / "steps.csv"):
        run = (row["seed"], row["view_seed"], row["first_view"])
        found.setdefault(row["variant"], {}).setdefault(row["object"], {}).setdefault(run, []).append(row)
    return found


def after(steps, n_views, key):
    """The value of a run after so many views, or after its last."""
    return float(steps[min(n_views, len(steps)) - 1][key])


def by_object(runs_of_object, value):
    """The mean over the runs of each object."""
    return {name: statistics.mean(value(name, steps) for steps in runs.values()) for name, runs in runs_of_object.items()}


def lowest(share, name="lowest"):
    """The lowest object, in %."""
    object = min(share, key=share.get)
    return {f"{name}_percent": f"{100 * share[object]:.1f}", f"{name}_object": object}


def objview(reach, campaign, _):
    """Mean and lowest object of SC and NSC at tolerances of 0.01 and 0.02 of the radius, and the path in radii."""
    found = steps_of(campaign)
    all_views = {name: next(iter(runs.values()))[-1] for name, runs in found.pop("all views").items()}
    rows = []
    for variant, objects in found.items():
        def normalised(n_moves, key):
            return by_object(objects, lambda name, steps: after(steps, n_moves + 1, key) / float(all_views[name][key]))
        shares = {f"nsc_02_after_{n}": normalised(n, "surface_coverage_2mm") for n in MOVES}
        shares[f"nsc_01_after_{MOVES[-1]}"] = normalised(MOVES[-1], "surface_coverage_1mm")
        last = lambda _, steps: after(steps, MOVES[-1] + 1, "surface_coverage_2mm")
        shares[f"sc_02_after_{MOVES[-1]}"] = by_object(objects, last)
        path = by_object(objects, lambda _, steps: after(steps, MOVES[1] + 1, "trajectory_length_m") / UNIT_M)
        row = {"reach": reach, "variant": variant}
        for name, share in shares.items():
            row |= {f"{name}_percent": f"{100 * statistics.mean(share.values()):.1f}", **lowest(share, f"{name}_lowest")}
        rows.append(row | {f"path_after_{MOVES[1]}_radii": f"{statistics.mean(path.values()):.1f}"})
    return {"objview": rows}


def pb_nbv(reach, campaign, found):
    """The share of the surface with a point within 5 mm, the time of a decision, and the share of each object."""
    times = {}
    for row in settings.rows_of(campaign / "times.csv"):
        if row["step"] not in ("", "1"):
            times.setdefault(row["variant"], []).append(float(row["plan_time_ms"]))
    steps = steps_of(campaign)
    last = {variant: by_object(objects, lambda _, steps: float(steps[-1]["surface_coverage_5mm"])) for variant, objects in steps.items()}
    rows = []
    for variant, share in last.items():
        reached = found[variant, "surface coverage within 5 mm, %"]
        rows.append({
            "reach": reach,
            "variant": variant,
            "surface_5mm_percent": reached["value"],
            "surface_5mm_low_percent": reached["low"],
            "surface_5mm_high_percent": reached["high"],
            **lowest(share),
            "plan_time_median_ms": f"{statistics.median(times[variant]):.0f}",
        })
    objects = [
        {"reach": reach, "object": name, "variant": variant, "surface_5mm_percent": f"{100 * last[variant][name]:.1f}"}
        for name in next(iter(last.values())) for variant in last
    ]
    return {"pb-nbv": rows, "pb-nbv-objects": objects}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("protocol", choices=list(RULES))
    parser.add_argument("meshes", nargs="+", metavar="MESH", help="file, or builtin:NAME")
    parser.add_argument("--reach", nargs="+", default=["whole"], choices=list(REACHES))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    tables = {}
    for reach in options.reach:
        campaign = options.out / f"{options.protocol}-{reach}"
        spec = options.out / f"{options.protocol}-{reach}.toml"
        spec.write_text(specification(options.program, options.protocol, reach), encoding="utf-8")
        found = settings.run(options.program, campaign, spec, options.meshes)
        of_protocol = {"objview": objview, "pb-nbv": pb_nbv}[options.protocol]
        for name, rows in of_protocol(reach, campaign, found).items():
            tables.setdefault(name, []).extend(rows)
    for name, rows in tables.items():
        settings.write(options.out / f"{name}.csv", rows)
        print(options.out / f"{name}.csv")


if __name__ == "__main__":
    main()
