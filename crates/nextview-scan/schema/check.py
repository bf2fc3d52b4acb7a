#!/usr/bin/env python3
"""Checks the output of the program against the JSON Schemas in this folder.

    check.py target/debug/nextview

Needs the package jsonschema. A key that is not in the schema is also a fault. A recording with true poses is checked if
the reference data is there, in the folder that NEXTVIEW_DATA names; else it is reported as SKIPPED.
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile

from jsonschema import Draft202012Validator

HERE = pathlib.Path(__file__).resolve().parent
DATA = pathlib.Path(os.environ.get("NEXTVIEW_DATA", HERE / "../../../../shared/data")).resolve()
SMALL = ["--candidates", "40", "--voxel-size-m", "0.02", "--views", "3"]
NOISE = ["--noise", "d435i", "--pose-error-mm", "5", "--pose-error-deg", "0.5"]
BUNNY = DATA / "rgbd/bunny_primesense"
SCANS = {
    "default planner": ["builtin:mug", *SMALL],
    "max-flow, coarse to fine": ["builtin:mug", *SMALL, "--planner", "max-flow", "--multi-resolution", "on"],
    "registration, table, growing box": ["builtin:mug", *SMALL, *NOISE, "--register", "on", "--table", "fit", "--box", "grows"],
    "batch without baselines": ["builtin:mug", *SMALL, "--planner", "batch", "--baselines", "off"],
    "complete": ["builtin:mug", *SMALL, "--complete", "0.5"],
    "recording": ["--frames", BUNNY, "--pose-columns", "given", "--views", "3"],
    "recording with truth": ["--frames", BUNNY, "--pose-columns", "given", "--views", "3", "--unit", "m",
                             "--truth", DATA / "meshes/stanford/bunny.ply", "--truth-from-world", BUNNY / "T_mesh_world.txt"],
}


def schema(name):
    return json.loads((HERE / f"{name}.json").read_text())


def closed(schema):
    """The same schema, which allows no key that it does not name."""
    if isinstance(schema, dict):
        if "properties" in schema:
            schema.setdefault("additionalProperties", False)
        for value in schema.values():
            closed(value)
    elif isinstance(schema, list):
        for value in schema:
            closed(value)
    return schema


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    step, scan = (Draft202012Validator(closed(schema(name))) for name in ["step_record", "scan_record"])
    Draft202012Validator.check_schema(schema("scan_config"))
    n_faults = 0
    for name, arguments in SCANS.items():
        if arguments[0] == "--frames" and not BUNNY.is_dir():
            subprocess.run([HERE / "../../../.ci/skipped", f"schema: {name}", "data", f"there is no {BUNNY}"], check=True)
            continue
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder, "out")
            run = subprocess.run([program, "scan", *arguments, "--out", out, "--json"], capture_output=True, check=True)
            printed = json.loads(run.stdout)
            faults = [fault for fault in scan.iter_errors(printed)]
            if printed != json.loads((out / "record.json").read_text()):
                faults.append("record.json is not what --json prints")
            lines = (out / "steps.jsonl").read_text().splitlines()
            if [json.loads(line) for line in lines] != printed["steps"]:
                faults.append("steps.jsonl does not hold the steps of record.json")
            for line in lines:
                faults.extend(step.iter_errors(json.loads(line)))
        for fault in faults:
            print(f"{name}: {getattr(fault, 'json_path', '')} {getattr(fault, 'message', fault)}")
        n_faults += len(faults)
        print(f"{name}: {len(lines)} steps, {len(faults)} faults")
    sys.exit(n_faults > 0)


main()
