#!/usr/bin/env python3
"""Quality of models of objects at their true size: expected against true error per point, and the number of parts of the meshes.

    benchmarks/model/model.py target/release/nextview OUT       # scans that were done before are read again

Needs numpy, scipy, trimesh and rtree. The meshes are in the folder that NEXTVIEW_DATA names. Prints the tables of docs/model.md.
"""

import argparse
import os
import pathlib
import shutil
import subprocess

import numpy
import trimesh

HERE = pathlib.Path(__file__).resolve().parent
MESHES = pathlib.Path(os.environ.get("NEXTVIEW_DATA", HERE / "../../../shared/data")).resolve() / "meshes"
ERROR_OBJECTS = ["lm/lm_obj_000001_ape.ply", "tless/tless_05.ply", "ycb/ycb_025_mug.ply", "ycb/ycb_061_foam_brick.ply"]
SENSORS = ["d435i", "d405"]
MESH_OBJECTS = [
    "lm/lm_obj_000001_ape.ply", "lm/lm_obj_000006_cat.ply", "lm/lm_obj_000008_driller.ply", "lm/lm_obj_000009_duck.ply",
    "lm/lm_obj_000010_eggbox.ply", "tless/tless_12.ply", "ycb/ycb_003_cracker_box.ply", "ycb/ycb_006_mustard_bottle.ply",
    "ycb/ycb_011_banana.ply", "ycb/ycb_061_foam_brick.ply",
]
SHARED = ["--views", "10", "--candidates", "300", "--baselines", "off"]
TYPES = {"double": "<f8", "float": "<f4", "uchar": "u1", "int": "<i4", "uint": "<u4"}
N_BINS = 10
N_POINTS = 8000


def scan(program, folder, mesh, options):
    """The folder of a scan of this mesh."""
    if not (folder / "record.json").exists():
        unit = "m" if mesh.parent.name == "ycb" else "mm"
        command = [program, "scan", mesh, "--unit", unit, *SHARED, *options, "--out", folder]
        shutil.rmtree(folder, ignore_errors=True)
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return folder


def cloud(path):
    """The points of a cloud as a table with the names of its columns."""
    head, body = path.read_bytes().split(b"end_header\n", 1)
    lines = [line.split() for line in head.decode().splitlines()]
    columns = [(line[2], TYPES[line[1]]) for line in lines if line[0] == "property"]
    count = next(int(line[2]) for line in lines if line[:2] == ["element", "vertex"])
    return numpy.frombuffer(body, dtype=columns, count=count)


def ratios(folder, mesh):
    """Root mean square of the ratio of true and expected error, in bins of equal size by the expected error."""
    points = cloud(folder / "cloud.ply")
    points = points[points["error_m"] > 0]
    chosen = points[numpy.random.default_rng(0).permutation(len(points))[:N_POINTS]]
    truth = trimesh.load(mesh, process=False)
    truth.apply_scale(1.0 if mesh.parent.name == "ycb" else 0.001)
    positions = numpy.stack([chosen[axis] for axis in "xyz"], axis=1).astype(float)
    true = trimesh.proximity.closest_point(truth, positions)[1]
    expected = chosen["error_m"].astype(float)
    bins = numpy.array_split(numpy.argsort(expected), N_BINS)
    return [float(numpy.sqrt(numpy.mean(true[b] ** 2) / numpy.mean(expected[b] ** 2))) for b in bins]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("out", type=pathlib.Path)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    print("| object | sensor | true over expected error, in ten bins |\n|---|---|---|")
    for name in ERROR_OBJECTS:
        for sensor in SENSORS:
            mesh = MESHES / name
            keys = ["--sensor", sensor, "--table", "known", "--view-space", "hemisphere"]
            found = ratios(scan(options.program, options.out / f"{mesh.stem}-{sensor}", mesh, keys), mesh)
            print(f"| {mesh.stem} | {sensor} | " + " ".join(f"{ratio:.2f}" for ratio in found) + " |", flush=True)
    print("\n| object | watertight | parts | closed |\n|---|---|---:|---|")
    for name in MESH_OBJECTS:
        for watertight in ["off", "on"]:
            mesh = MESHES / name
            keys = ["--noise", "d435i", "--seed", "1", "--box", "grows", "--table", "fit", "--watertight", watertight]
            folder = scan(options.program, options.out / f"{mesh.stem}-{watertight}", mesh, keys)
            made = trimesh.load(folder / "mesh.ply", process=False)
            print(f"| {mesh.stem} | {watertight} | {made.body_count} | {'yes' if made.is_watertight else 'no'} |", flush=True)


if __name__ == "__main__":
    main()
