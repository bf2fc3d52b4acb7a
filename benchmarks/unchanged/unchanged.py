#!/usr/bin/env python3
"""Checks that a program's results are unchanged: about fifty scans and two campaigns, by the hashes of their results.

    benchmarks/unchanged/unchanged.py target/release/nextview            # compares with results.csv, exit code 1 if it differs
    benchmarks/unchanged/unchanged.py target/release/nextview --write    # rewrites results.csv

Each line of results.csv is a scan or a campaign with the hashes of its map, cloud, mesh, views and waypoints as files, and
of its measures and path lengths as numbers. Times and memory are left out. Recorded scans need the reference data, in the
folder that NEXTVIEW_DATA names; without it they are reported as SKIPPED by name.
"""

import argparse
import concurrent.futures
import csv
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
DATA = pathlib.Path(os.environ.get("NEXTVIEW_DATA", HERE / "../../../shared/data")).resolve()
COLUMNS = ["name", "map.ot", "map.bt", "cloud.ply", "mesh.ply", "views.csv", "waypoints.csv", "measures", "path"]

PLANNERS = """most-surface max-flow local apora rse rear-side-voxel occlusion-aware unobserved-voxel average-entropy
    proximity-count krainin area-factor nbv-net batch in-order random clairvoyant""".split()
SMALL = ["--candidates", "60", "--voxel-size-m", "0.01", "--views", "5"]
NOISE = ["--noise", "d435i", "--pose-error-mm", "5", "--pose-error-deg", "0.5"]


def scans():
    """Name and arguments of every scan."""
    for planner in PLANNERS:
        yield f"mug {planner}", ["builtin:mug", *SMALL, "--planner", planner]
    for planner in ["most-surface", "max-flow", "rear-side-voxel", "batch"]:
        yield f"bracket {planner} noise", ["builtin:bracket", *SMALL, *NOISE, "--planner", planner]
    fine = ["builtin:teapot", "--candidates", "150", "--views", "6"]
    for planner in ["most-surface", "max-flow", "batch"]:
        yield f"teapot 5 mm {planner}", [*fine, "--planner", planner]
        yield f"teapot 5 mm {planner} theta", [*fine, "--planner", planner, "--theta", "0.3"]
    mug = ["builtin:mug", *SMALL]
    yield "paper", ["builtin:mug", "--profile", "paper", "--candidates", "100", "--views", "5"]
    yield "registration", [*mug, *NOISE, "--register", "on"]
    yield "registration overlap", [*mug, *NOISE, "--register", "on", "--min-overlap", "0.3"]
    yield "table known", [*mug, "--table", "known", "--planner", "max-flow"]
    yield "table fit noise", [*mug, *NOISE, "--table", "fit"]
    yield "box grows", [*mug, "--box", "grows"]
    yield "box grows table", [*mug, *NOISE, "--box", "grows", "--table", "fit", "--planner", "max-flow", "--register", "on"]
    # Fine voxels beside the error of the camera, as in the benchmark of reality.
    small = ["builtin:mug", "--size-m", "0.06", "--candidates", "150", "--views", "6", "--noise", "d435i"]
    yield "true size", [*small, "--pose-error-mm", "2", "--pose-error-deg", "0.2", "--box", "grows", "--table", "fit"]
    yield "coarse to fine", ["builtin:torus-knot", "--candidates", "80", "--multi-resolution", "on"]
    yield "coarse to fine max-flow", ["builtin:random-17", *SMALL, "--multi-resolution", "on", "--planner", "max-flow"]
    yield "coarse to fine rse", [*mug, "--multi-resolution", "on", "--planner", "rse", "--theta", "0.2"]
    yield "complete", ["builtin:mug", *SMALL[:4], "--complete", "0.8", "--views", "20"]
    yield "longest path", [*mug, "--max-path-m", "1"]
    yield "hemisphere", [*mug, "--view-space", "hemisphere", "--table", "known"]
    yield "sphere", [*mug, "--view-space", "sphere", "--first-view", "7", "--seed", "3"]
    yield "reach", [*mug, "--reach", "0.3,0,0,0.5", "--planner", "max-flow"]
    yield "random seed", [*mug, "--planner", "random", "--seed", "9", "--baselines", "off"]
    bunny = ["--frames", str(DATA / "rgbd/bunny_primesense"), "--pose-columns", "given", "--views", "8"]
    given = ["--register", "off"]
    truth = ["--truth", str(DATA / "meshes/stanford/bunny.ply"), "--unit", "m", "--truth-from-world",
             str(DATA / "rgbd/bunny_primesense/T_mesh_world.txt")]
    for planner in ["most-surface", "max-flow", "in-order", "clairvoyant"]:
        yield f"recorded bunny {planner}", [*given, *bunny, *truth, "--planner", planner]
    yield "recorded bunny registration", [*bunny, *truth, "--register", "on"]
    yield "recorded room", [*given, "--frames", str(DATA / "rgbd/redkitchen_kinect"), "--views", "5",
                            "--voxel-size-m", "0.02", "--box-m=-2.4,-0.8,1.4,-1.4,0.2,2.4"]


CAMPAIGNS = ["campaign planners", "campaign noise"]

# What a quantity of steps.jsonl or --json is called here.
STEP_NAMES = {
    "world_from_camera.translation": "position_m", "world_from_camera.rotation": "quaternion_xyzw",
    "choice.score": "score", "choice.runner_up": "runner_up",
    "outlook.n_seen": "planner_seen_voxels", "outlook.n_expected": "expected_new_voxels",
    "outlook.n_unseen": "expected_unseen_voxels",
    "voxel_size": "voxel_size_m", "bounds.min": "box_min_m", "bounds.max": "box_max_m",
    "table.normal": "table_normal", "table.offset": "table_offset_m",
    "update.n_hits": "hit_voxels", "update.n_misses": "missed_voxels",
    "update.n_first_measured": "first_measured_voxels", "update.n_newly_occupied": "new_voxels",
    "map.n_occupied": "occupied_voxels", "map.n_free": "free_voxels", "map.n_unknown": "unknown_voxels",
    "map.entropy": "entropy_nats", "map.entropy_share": "entropy_share",
    "way_m": "trajectory_length_m", "move_time_s": "trajectory_time_s",
    **{f"registration.{key}": f"registration_{key}" for key in [
        "accepted", "verdict", "residual_before_mm", "residual_after_mm", "overlap", "moved_mm", "turned_deg",
        "stiffness", "n_iterations"]},
    "flow.n_voxels": "explanation.flow_voxels", "flow.quality": "explanation.flow_quality_nats",
    "flow.n_views": "explanation.flow_views",
}
STEP_KEYS = set(STEP_NAMES.values()) | {
    "step", "view", "frame", "misplaced_mm", "voxel_coverage", "false_voxels", "surface_coverage_1mm",
    "surface_coverage_2mm", "surface_coverage_5mm", "reachable_coverage", "accuracy_mean_mm", "accuracy_median_mm",
    "accuracy_p95_mm"}
QUALITY = ["accuracy_mean_mm", "accuracy_median_mm", "accuracy_p95_mm", "completeness_1mm", "completeness_2mm",
           "completeness_5mm", "completeness_mean_mm"]
RECORD_NAMES = {"n_candidates": "candidates",
                **{f"{model}.{key}": f"{model}_{key}" for model in ["cloud", "mesh"] for key in QUALITY}}
RECORD_KEYS = set(RECORD_NAMES.values()) | {
    "object", "planner", "profile", "seed", "stop_reason", "voxel_size_m", "random_curve", "clairvoyant_curve", "skill"}

# What a column of a campaign's tables is called here.
COLUMN_NAMES = {
    "seen": "reachable_coverage", "estimated_seen_before": "estimated_completeness", "surface_1mm": "surface_coverage_1mm",
    "surface_2mm": "surface_coverage_2mm", "surface_5mm": "surface_coverage_5mm", "overlap": "registration_overlap",
    "way_m": "trajectory_length_m", "move_time_s": "trajectory_time_s", "registration": "registration_verdict",
    "n_object_voxels": "object_voxels", "n_reachable": "reachable_voxels", "n_views": "views",
}
TABLE_KEYS = set(COLUMN_NAMES.values()) | {
    "object", "data_set", "variant", "seed", "first_view", "status", "stop_reason", "voxel_coverage", "false_voxels",
    "expected_new_voxels", "misplaced_mm", "entropy_nats", "entropy_share", "skill", "views_to_90", "views_to_95",
    "views_to_99", "step", "view", "voxel_size_m"} | {f"cloud_{key}" for key in QUALITY}


def flat(value, prefix=""):
    """The values of nested objects by their dotted paths, without those that are null."""
    for key, entry in value.items():
        if isinstance(entry, dict):
            yield from flat(entry, f"{prefix}{key}.")
        elif entry is not None:
            yield prefix + key, entry


def renamed(value, names, keys):
    """The known quantities under the names used here."""
    entries = ((names.get(key, key), entry) for key, entry in flat(value))
    return {key: whole(entry) if key.startswith("explanation.") else entry for key, entry in entries if key in keys}


def whole(number):
    """A count as an integer: explanations hold numbers of one kind only."""
    return int(number) if float(number).is_integer() else number


def digest(content):
    """The first 16 digits of a hash of bytes or of a JSON value."""
    if not isinstance(content, bytes):
        content = json.dumps(content, sort_keys=True).encode()
    return hashlib.sha256(content).hexdigest()[:16]


def run(program, arguments, folder):
    result = subprocess.run([program, "--threads", "1", *arguments], cwd=folder, capture_output=True, text=True)
    if result.returncode != 0:
        raise RuntimeError(f"{' '.join(arguments)}: exit code {result.returncode}: {result.stderr}")
    return result.stdout


def scan(program, name, arguments):
    """The line of a scan."""
    with tempfile.TemporaryDirectory() as folder:
        record = json.loads(run(program, ["scan", *arguments, "--json", "--out", "out"], folder))
        out = pathlib.Path(folder, "out")
        steps = [json.loads(line) for line in (out / "steps.jsonl").read_text().splitlines()]
        measures = [renamed(record, RECORD_NAMES, RECORD_KEYS), *(renamed(step, STEP_NAMES, STEP_KEYS) for step in steps)]
        path = [step["path_length_m"] for step in steps]
        return [name, *(digest((out / file).read_bytes()) for file in COLUMNS[1:7]), digest(measures), digest(path)]


def table(path, names, keys):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    known = [{names.get(key, key): value for key, value in row.items()} for row in rows]
    measures = [{key: value for key, value in row.items() if key in keys and value != ""} for row in known]
    return measures, [row["path_length_m"] for row in rows]


def campaign(program, name):
    """The line of a campaign."""
    with tempfile.TemporaryDirectory() as folder:
        run(program, ["bench", str(HERE / f"{name.split()[1]}.toml"), "--out", "out"], folder)
        tables = [table(pathlib.Path(folder, "out", f"{part}.csv"), COLUMN_NAMES, TABLE_KEYS) for part in ["runs", "steps"]]
        measures, paths = zip(*tables)
        return [name, *[""] * 6, digest(measures), digest(paths)]


def line(program, make, name, *arguments):
    """The line of a scan or a campaign; one without hashes if it fails."""
    try:
        return make(program, name, *arguments)
    except (RuntimeError, OSError, KeyError) as error:
        print(f"{name}: {error!r}", file=sys.stderr)
        return [name, *[""] * (len(COLUMNS) - 1)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--only", default="", help="only scans and campaigns with this in their name")
    options = parser.parse_args()
    program = str(options.program.resolve())
    tasks = []
    for name, arguments in scans():
        if options.only not in name:
            continue
        if name.startswith("recorded") and not DATA.is_dir():
            subprocess.run([HERE / "../../.ci/skipped", f"unchanged: {name}", "data", f"there is no {DATA}"], check=True)
            continue
        tasks.append((scan, name, arguments))
    tasks += [(campaign, name) for name in CAMPAIGNS if options.only in name]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        lines = list(pool.map(lambda task: line(program, *task), tasks))
    with open(HERE / "results.csv", newline="") as file:
        expected = {line[0]: line for line in csv.reader(file)}
    if options.write:
        # Lines of scans that did not run stay.
        written = expected | {found[0]: found for found in lines}
        with open(HERE / "results.csv", "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(written.values())
        print(f"{len(lines)} lines written")
        return
    n_different = 0
    for found in lines:
        known = expected.get(found[0], [""] * len(found))
        parts = [part for part, new, old in zip(COLUMNS, found, known) if new != old]
        if parts:
            n_different += 1
            print(f"{found[0]}: differs in {', '.join(parts)}")
    print(f"{len(lines) - n_different} of {len(lines)} are unchanged")
    sys.exit(n_different > 0)


if __name__ == "__main__":
    main()
