#!/usr/bin/env python3
"""The effect of registration on scans with wrong and with correct poses.

    benchmarks/registration/registration.py target/release/nextview OUT          # ten objects, five seeds; OUT/registration.md
    benchmarks/registration/registration.py target/release/nextview OUT --seeds 1 --only tless_05 duck

Ten objects at their true size, ten views by the default planner among 300 on a hemisphere, the box and the table known.
Poses are off by 0, 2 or 10 mm and 0, 0.2 or 1 degree (standard deviation on each axis), the first one, too, with and
without the noise of a D435i, with and without registration. Cloud and mesh are aligned to the truth as a whole before they are
measured. Scans that were done before are read again. The meshes are in the folder that NEXTVIEW_DATA names.
"""

import argparse
import concurrent.futures
import itertools
import json
import os
import pathlib
import shutil
import statistics
import subprocess

HERE = pathlib.Path(__file__).resolve().parent
MESHES = pathlib.Path(os.environ.get("NEXTVIEW_DATA", HERE / "../../../shared/data")).resolve() / "meshes"
OBJECTS = [
    "lm/lm_obj_000001_ape.ply", "lm/lm_obj_000005_can.ply", "lm/lm_obj_000009_duck.ply", "lm/lm_obj_000010_eggbox.ply",
    "tless/tless_05.ply", "tless/tless_10.ply", "tless/tless_12.ply", "ycb/ycb_025_mug.ply", "ycb/ycb_061_foam_brick.ply",
    "ycb/ycb_035_power_drill.ply",
]
ERRORS = {0: 0.0, 2: 0.2, 10: 1.0}
NOISES = ["none", "d435i"]
CONFIG = """
views = 10
candidates = 300
view_space = "hemisphere"
baselines = false
unit = "{unit}"
seed = {seed}
[object_box]
table = "known"
[stop]
progress = 0
[noise]
model = "{noise}"
seed = {seed}
pose_error_mm = {error}
pose_error_deg = {angle}
[registration]
enabled = {register}
"""


def scan(program, out, mesh, seed, error, noise, register):
    """The record of a scan."""
    name = f"{mesh.stem}-{seed}-{error}-{noise}-{'on' if register else 'off'}"
    record = out / f"{name}.json"
    if not record.exists():
        config, folder = out / f"{name}.toml", out / name
        unit = "m" if mesh.parent.name == "ycb" else "mm"
        config.write_text(CONFIG.format(
            unit=unit, seed=seed, noise=noise, error=error, angle=ERRORS[error], register=str(register).lower()))
        shutil.rmtree(folder, ignore_errors=True)
        command = [program, "scan", mesh, "--config", config, "--out", folder, "--threads", "1"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        (folder / "record.json").rename(record)
        shutil.rmtree(folder)
    return json.loads(record.read_text(encoding="utf-8"))


MEASURES = {
    "cloud within 2 mm": "cloud_completeness_2mm", "mesh within 2 mm": "mesh_completeness_2mm",
    "mesh p95, mm": "mesh_accuracy_p95_mm", "frames aligned": None, "set aside": "frames_set_aside",
}


def value(record, key):
    """A measure of a record; the number of aligned frames has no key."""
    if key is None:
        return sum(step.get("registration_accepted", False) for step in record["steps"])
    return record.get(key) or 0


def page(records):
    """The tables as Markdown."""
    lines = ["| noise | poses off by | registration | " + " | ".join(MEASURES) + " | worst object, cloud within 2 mm |",
             "|---|---|---|" + "---:|" * (len(MEASURES) + 1)]
    for noise, error, register in itertools.product(NOISES, ERRORS, [False, True]):
        found = {key[0]: [] for key in records}
        for (mesh, _, *variant), record in records.items():
            if variant == [error, noise, register]:
                found[mesh].append(record)
        mean = lambda key, of: statistics.mean(value(record, key) for record in of)
        cells = []
        for title, key in MEASURES.items():
            number = statistics.mean(mean(key, of) for of in found.values())
            cells.append(f"{number:.1%}" if "within" in title else f"{number:.2f}")
        worst, name = min((mean("cloud_completeness_2mm", of), mesh) for mesh, of in found.items())
        lines.append(f"| {noise} | {error} mm, {ERRORS[error]} degrees | {'on' if register else 'off'} | " + " | ".join(cells)
                     + f" | {worst:.1%} ({name}) |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--seeds", type=int, default=5, metavar="N")
    parser.add_argument("--only", nargs="+", metavar="PART")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    meshes = [MESHES / name for name in OBJECTS if not options.only or any(part in name for part in options.only)]
    runs = list(itertools.product(range(options.seeds), meshes, ERRORS, NOISES, [False, True]))
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        done = pool.map(lambda run: scan(options.program, options.out, run[1], run[0], *run[2:]), runs)
        records = {(mesh.stem, seed, *variant): record for (seed, mesh, *variant), record in zip(runs, done)}
    (options.out / "registration.md").write_text(page(records), encoding="utf-8")
    print(options.out / "registration.md")


if __name__ == "__main__":
    main()
