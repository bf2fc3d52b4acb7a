#!/usr/bin/env python3
"""When scans of objects at their true size stop, and what more views would have shown.

    benchmarks/reality/stopping.py target/release/nextview OUT                  # 22 objects, resumes an unfinished campaign
    benchmarks/reality/stopping.py target/release/nextview OUT --only mug tless # objects whose names contain one of these

Every second object of the benchmark of reality, up to 30 views, poses off by 2 mm and 0.2 degrees: once with the
default stop rules, and once with only the rule that no view gains anything. The best stop, known afterwards, is the
first view after which six more add less than a point of reachable coverage. OUT/stopping.md has the table,
OUT/campaign/report.html the calibration of the completeness that the planner estimates.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys

import reality

VARIANTS = {"default stop": "", "no stop": "scan.stop.progress = 0\n"}
# Views, and what they must add to be worth taking.
AHEAD, WORTH = 6, 0.01


def specification(only):
    """The text of the campaign."""
    tables = list(reality.objects(only))
    parts = ["objects = [\n" + "".join(f"  {table},\n" for table in tables[:: 1 if only else 2]) + "]\n"]
    parts.append((reality.HERE / "reality.toml").read_text(encoding="utf-8").replace("views = 12", "views = 30"))
    for label, rule in VARIANTS.items():
        parts.append(f'[[variant]]\nlabel = "{label}"\nscan.noise.pose_error_mm = 2\nscan.noise.pose_error_deg = 0.2\n{rule}')
    return "\n".join(parts)


def curve(run):
    """Reachable coverage after each view; of a failed run, none at all."""
    steps = run["result"].get("done", {}).get("record", {}).get("steps", [])
    return [step["reachable_coverage"] for step in steps] or [0.0]


def best_stop(coverage):
    """The number of views after which more views were not worthwhile."""
    gain = lambda n: coverage[min(n + AHEAD, len(coverage)) - 1] - coverage[n - 1]
    return next(n for n in range(1, len(coverage) + 1) if gain(n) < WORTH)


def page(runs):
    """The table as Markdown."""
    by_object = {}
    for run in runs:
        by_object.setdefault(run["object"], {})[run["variant"]] = run
    rows = []
    for name, found in sorted(by_object.items()):
        stopped, on = curve(found["default stop"]), curve(found["no stop"])
        best, record = best_stop(on), found["default stop"]["result"].get("done", {}).get("record", {})
        rows.append((name, record.get("stop_reason", "failed"), len(stopped), stopped[-1], best, on[best - 1], len(on), on[-1]))
    head = "| object | stopped because | views | coverage | best stop: views | coverage | no stop: views | coverage |"
    line = "| {} | {} | {:.1f} | {:.1%} | {:.1f} | {:.1%} | {:.1f} | {:.1%} |".format
    means = [statistics.mean(row[column] for row in rows) for column in range(2, 8)]
    lines = ["# Stopping", "", head, "|---|---|" + "---:|" * 6, *(line(*row) for row in rows), line("**mean**", "", *means)]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--only", nargs="+", metavar="PART")
    options = parser.parse_args()
    runs = reality.campaign(options.program, options.out, lambda: specification(options.only))
    (options.out / "stopping.md").write_text(page(runs), encoding="utf-8")
    subprocess.run([options.program, "report", options.out / "campaign"], check=True, stdout=subprocess.DEVNULL)
    print(options.out / "stopping.md")


if __name__ == "__main__":
    main()
