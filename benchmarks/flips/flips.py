#!/usr/bin/env python3
"""Objects that are turned once: the share of the whole surface in the model before and after, and the error of the turn.

    benchmarks/flips/flips.py target/release/nextview OUT                        # ten objects; OUT/flips.md has the tables
    benchmarks/flips/flips.py target/release/nextview OUT lm/lm_obj_000009_duck.ply ...

Every object is scanned at its true size with the noise of a D435i on a table that is found, ten views at most; turned
as the results request, and at random about the vertical; and scanned again. After that, every object is scanned as a
continuation of the results of the previous object in the list: any turn found is wrong. Scans that were done before
are read again. The meshes are in the folder that NEXTVIEW_DATA names.
"""

import argparse
import json
import os
import pathlib
import shutil
import statistics
import subprocess

HERE = pathlib.Path(__file__).resolve().parent
MESHES = pathlib.Path(os.environ.get("NEXTVIEW_DATA", HERE / "../../../shared/data")).resolve() / "meshes"
OBJECTS = [
    "lm/lm_obj_000005_can.ply", "lm/lm_obj_000006_cat.ply", "lm/lm_obj_000009_duck.ply", "lm/lm_obj_000013_iron.ply",
    "tless/tless_05.ply", "tless/tless_12.ply", "ycb/ycb_006_mustard_bottle.ply", "ycb/ycb_024_bowl.ply",
    "ycb/ycb_025_mug.ply", "ycb/ycb_061_foam_brick.ply",
]
SCAN = ["--table", "fit", "--views", "10", "--baselines", "off"]
MEASURES = ["cloud_completeness_2mm", "mesh_completeness_2mm", "cloud_precision_2mm"]


def record(folder):
    return json.loads((folder / "record.json").read_text(encoding="utf-8"))


def scan(program, out, seed, *arguments):
    """The record of a scan whose camera errs by this seed; one that was done before is read again."""
    if not (out / "record.json").exists():
        shutil.rmtree(out, ignore_errors=True)
        config = out.with_suffix(".toml")
        config.write_text(f'[noise]\nmodel = "d435i"\nseed = {seed}\n', encoding="utf-8")
        subprocess.run([program, "scan", "--config", config, *map(str, arguments), *SCAN, "--out", out], check=True, stdout=subprocess.DEVNULL)
    return record(out)


def percent(value):
    return f"{100 * value:.1f}"


def turned(name, before, after):
    """The cells of a line: the measures before and after, and the turn."""
    turn = after.get("turn", {})
    found = turn.get("refusal") or f"{turn['error_mm']:.2f}"
    shares = [percent(part[measure]) for measure in MEASURES for part in (before, after)]
    return [name, *shares, found, str(before["views"] + after["views"])]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=lambda path: pathlib.Path(path).resolve())
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("meshes", nargs="*", default=OBJECTS)
    parser.add_argument("--seeds", type=int, default=1)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    pairs, wrong = [], []
    for seed in range(1, options.seeds + 1):
        folders = [options.out / f"{pathlib.Path(mesh).stem}-{seed}" for mesh in options.meshes]
        for mesh, folder in zip(options.meshes, folders):
            first = folder.with_name(f"{folder.name}-1")
            before = scan(options.program, first, 100 * seed, MESHES / mesh)
            if "next_placement" in before:
                second = folder.with_name(f"{folder.name}-2")
                after = scan(options.program, second, 100 * seed + 1, MESHES / mesh, "--after", first)
                pairs.append((folder.name, before, after))
        for mesh, folder, other in zip(options.meshes, folders, folders[-1:] + folders):
            third, first = folder.with_name(f"{folder.name}-wrong"), other.with_name(f"{other.name}-1")
            wrong.append((folder.name, scan(options.program, third, 100 * seed + 2, MESHES / mesh, "--after", first)))
    head = ["object", *(f"{measure.replace('_', ' ').replace('2mm', '2 mm')}, {when}" for measure in MEASURES
                        for when in ("before", "after")), "turn: error, mm, or refusal", "views"]
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *(turned(*pair) for pair in pairs)]
    known = [(before, after) for _, before, after in pairs if "refusal" not in after["turn"]]
    means = [percent(statistics.mean(part[measure] for part in parts)) for measure in MEASURES for parts in zip(*known)]
    error = statistics.mean(after["turn"]["error_mm"] for _, after in known)
    lines.append([f"mean of {len(known)} known", *means, f"{error:.2f}", ""])
    text = "\n".join("| " + " | ".join(cells) + " |" for cells in lines)
    refused = [after["turn"].get("refusal", "taken") for _, after in wrong]
    taken = [name for name, after in wrong if "refusal" not in after["turn"]]
    text += f"\n\nTurns refused: {len(pairs) - len(known)} of {len(pairs)}."
    text += f"\nWrong turns refused: {len(wrong) - len(taken)} of {len(wrong)}"
    text += f" ({', '.join(f'{refused.count(why)} {why}' for why in sorted(set(refused)))}).\n"
    (options.out / "flips.md").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
