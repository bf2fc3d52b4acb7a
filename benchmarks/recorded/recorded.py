#!/usr/bin/env python3
"""Recorded scenes: quality of cloud and mesh after a few frames, by planner, with and without masks and registration.

    benchmarks/recorded/recorded.py target/release/nextview OUT      # OUT/recorded.md has the tables

A bunny in front of a PrimeSense, whose mesh is known, and a kitchen in front of a Kinect, whose truth is the mesh of all
50 frames. The data are in the folder that NEXTVIEW_DATA names.
"""

import argparse
import itertools
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
DATA = pathlib.Path(os.environ.get("NEXTVIEW_DATA", HERE / "../../../shared/data")).resolve()
BUNNY, KITCHEN = DATA / "rgbd/bunny_primesense", DATA / "rgbd/redkitchen_kinect"
SEEDS = range(5)
# Name in the tables, arguments, and seeds.
ORDERS = [("most-surface", ["most-surface"], [0]), ("random order", ["random"], SEEDS), ("recorded order", ["in-order"], [0])]
KITCHEN_BOX = ["--box-m", "-2.4,-0.8,1.4,-1.4,0.2,2.4", "--voxel-size-m", "0.01"]


def scan(program, out, arguments):
    """The record of a scan; one that was done before is read again."""
    if not (out / "record.json").exists():
        shutil.rmtree(out, ignore_errors=True)
        subprocess.run([program, "scan", *map(str, arguments), "--out", out], check=True, stdout=subprocess.DEVNULL)
    return json.loads((out / "record.json").read_text(encoding="utf-8"))


def rows(title, counts, run, keys, orders=ORDERS):
    """A table: by order, after so many frames, the means over the seeds of the record's keys in percent."""
    yield f"## {title}\n"
    yield "| | " + " | ".join(f"{key.split('_')[0]}, {n} frames" for key, n in itertools.product(keys, counts)) + " |"
    yield "|---|" + "---:|" * (len(counts) * len(keys))
    for name, planner, seeds in orders:
        records = {(n, seed): run(planner, n, seed) for n in counts for seed in seeds}
        cells = []
        for key, n in itertools.product(keys, counts):
            values = [100 * records[n, seed][key] for seed in seeds]
            spread = f" ± {statistics.stdev(values):.1f}" if len(values) > 1 else ""
            cells.append(f"{statistics.mean(values):.1f}{spread}")
        yield f"| {name} | " + " | ".join(cells) + " |"
    yield ""


def bunny(program, out):
    """Four tables: with and without masks, with and without registration."""
    unmasked = out / "unmasked"
    if not unmasked.exists():
        shutil.copytree(BUNNY, unmasked, ignore=shutil.ignore_patterns("mask"))
    truth = ["--truth", DATA / "meshes/stanford/bunny.ply", "--unit", "m",
             "--truth-from-world", BUNNY / "T_mesh_world.txt", "--pose-columns", "given", "--baselines", "off"]
    keys = ["cloud_completeness_2mm", "mesh_completeness_2mm"]
    for (masks, folder), register in itertools.product([("with masks", BUNNY), ("without masks", unmasked)], ["off", "on"]):
        def run(planner, n, seed):
            name = f"bunny-{'-'.join(masks.split())}-{register}-{planner[0]}-{n}-{seed}"
            return scan(program, out / name, ["--frames", folder, *truth, "--register", register,
                                              "--planner", *planner, "--views", n, "--seed", seed])
        yield from rows(f"Bunny, {masks}, registration {register}", [4, 8, 12], run, keys)


def kitchen(program, out):
    """One table; the truth is the mesh of all frames."""
    everything = out / "kitchen-all"
    scan(program, everything, ["--frames", KITCHEN, *KITCHEN_BOX, "--views", 50, "--planner", "in-order"])
    truth = ["--truth", everything / "mesh.ply", "--unit", "m", "--baselines", "off"]
    def run(planner, n, seed):
        return scan(program, out / f"kitchen-{planner[0]}-{n}-{seed}",
                    ["--frames", KITCHEN, *KITCHEN_BOX, *truth, "--planner", *planner, "--views", n, "--seed", seed])
    yield from rows("Kitchen", [5, 10, 20], run, ["cloud_completeness_5mm"],
                    [*ORDERS, ("unobserved-voxel", ["unobserved-voxel"], [0])])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("out", type=pathlib.Path)
    options = parser.parse_args()
    if not BUNNY.exists():
        sys.exit(f"{BUNNY}: no such folder; NEXTVIEW_DATA names the folder of the reference data")
    options.out.mkdir(parents=True, exist_ok=True)
    lines = ["# Recorded scenes", "", "Share of the true surface within 2 mm (kitchen: 5 mm), %.", ""]
    for part in (bunny, kitchen):
        for line in part(options.program, options.out):
            lines.append(line)
            print(line, flush=True)
    (options.out / "recorded.md").write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
