#!/usr/bin/env python3
"""Checks that this program reproduces the published tables: measures some of their entries again.

    benchmarks/sample.py target/release/nextview                   # a few entries of each table; exit code 1 if a digit differs
    benchmarks/sample.py target/release/nextview --turn 7          # the next ones: each turn takes those after the last turn's
    benchmarks/sample.py target/release/nextview --count 5 --only map-rule short-paper-1
    benchmarks/sample.py --list                                    # the tables, and how many entries they have

A table is a file of docs and the specification that made it; an entry is one object with one planner. Its runs are those of
the whole campaign, since an object's seeds do not depend on what else is run. With the number of commits as turn, as in .ci,
every entry is measured at some time. The meshes are in the folder that NEXTVIEW_DATA names; without it the tables are
SKIPPED, which is a failure if NEXTVIEW_REQUIRE_ALL is 1.
"""

import argparse
import csv
import dataclasses
import itertools
import json
import os
import pathlib
import random
import re
import statistics
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable

HERE = pathlib.Path(__file__).resolve().parent
DOCS = HERE.parent / "docs"
DATA = pathlib.Path(os.environ.get("NEXTVIEW_DATA", HERE / "../../shared/data")).resolve()
for folder in ["planners", "protocols", "reality"]:
    sys.path.insert(0, str(HERE / folder))
import protocols
import reality
import settings


@dataclasses.dataclass
class Entry:
    """A number of a file: of this object and variant, as printed."""

    name: str
    object: str
    variant: str
    printed: str


@dataclasses.dataclass
class Table:
    """Entries of one file of docs that one specification makes."""

    name: str
    file: str
    entries: Callable[[str], list[Entry]]
    specification: Callable[[str, Entry], str]
    value: Callable[[pathlib.Path], str]
    # How many entries are measured in one turn, unless the command says otherwise.
    count: int = 1


# Entries as the files print them.


def of_rows(where, object, variant, printed):
    """Entries of the rows of a CSV file that have these values."""
    def entries(text):
        rows = csv.DictReader(text.splitlines())
        found = [row for row in rows if all(row[key] == value for key, value in where.items())]
        return [Entry(f"{row[object]}, {variant(row)}", row[object], variant(row), printed(row)) for row in found]
    return entries


def objects(text):
    """Every object's coverage with every variant, without means over objects and what the paper published."""
    found = of_rows({}, "object", lambda row: row["variant"], lambda row: row["voxel_coverage_percent"])(text)
    return [entry for entry in found if entry.object and not entry.variant.startswith("paper: ")]


def lowest(setting):
    """A setting's lowest object with each planner."""
    return of_rows({"setting": setting}, "lowest_object", lambda row: row["variant"], lambda row: row["lowest_skill"])


def of_default(setting):
    """A setting's objects with the default planner."""
    printed = lambda row: f"{row['skill']} ({row['lowest_skill']} to {row['highest_skill']})"
    return of_rows({"setting": setting}, "object", lambda row: settings.DEFAULT, printed)


def within(reach):
    """Every object with every planner, with the candidates within this reach."""
    return of_rows({"reach": reach}, "object", lambda row: row["variant"], lambda row: row["surface_5mm_percent"])


def of_reality(column):
    """The lowest object of each planner in this column of the page's table, without random views."""
    def entries(text):
        start = text.index("| | skill, mean | lowest |")
        _, _, *lines = itertools.takewhile(lambda line: line.startswith("|"), text[start:].splitlines())
        found = []
        for planner, *cells in ([cell.strip() for cell in line.strip("|").split("|")] for line in lines):
            if planner != "random":
                printed, name = cells[column].removesuffix(")").split(" (")
                found.append(Entry(f"{name}, {planner}", name, f"{planner}, 2 mm", printed))
        return found
    return entries


# Specifications, and what of their runs is printed.


def in_folder(name, setting=None):
    """A specification of benchmarks/planners, in a setting of settings.py."""
    def text(*_):
        keys = settings.SETTINGS[setting] if setting else ""
        return (HERE / f"planners/{name}.toml").read_text(encoding="utf-8").replace("[scan]\n", f"[scan]\n{keys}")
    return text


def at_true_size(_, entry):
    """The benchmark of reality for one object, as its page says."""
    options = argparse.Namespace(only=[entry.object], errors=[2], planners=[entry.variant.split(", ")[0]], randoms=10)
    return reality.specification(options)


def values(out, key):
    """A column of a campaign's runs."""
    return [float(run[key]) for run in csv.DictReader(open(out / "runs.csv", encoding="utf-8"))]


def mean_percent(key):
    return lambda out: f"{100 * statistics.mean(values(out, key)):.1f}"


def skill(out):
    return f"{statistics.mean(values(out, 'skill')):.2f}"


def skill_and_range(out):
    return "{} ({} to {})".format(*settings.spread(values(out, "skill")))


def share_of_clairvoyant(out):
    """Final coverage over that of the planner that knows the object."""
    runs = [json.loads(line) for line in open(out / "runs.jsonl", encoding="utf-8")]
    return f"{statistics.mean(reality.measures(run)['coverage'] for run in runs):.3f}"


COVERAGE = mean_percent("voxel_coverage")
HEADLINE = ["5mm", "5mm-table-noise"]
SIX = [setting for setting in settings.SETTINGS if setting not in HEADLINE]
TABLES = [
    *(Table(f"headline-{setting}", f"data/headline-{setting}/objects.csv", objects, in_folder("headline", setting), COVERAGE)
      for setting in HEADLINE),
    *(Table(f"settings-{setting}", "data/settings.csv", lowest(setting), in_folder("all", setting), skill)
      for setting in settings.SETTINGS),
    *(Table(f"default-{setting}", "data/default-objects.csv", of_default(setting), in_folder("default", setting), skill_and_range)
      for setting in SIX),
    # Without random views: ten scans of each object take three minutes.
    *(Table(f"reality-{name}", "reality.md", of_reality(column), at_true_size, value)
      for name, column, value in [("skill", 1, skill), ("coverage", 3, share_of_clairvoyant)]),
    Table("short-paper-1", "data/short-paper-1/objects.csv", objects, in_folder("short-paper-1"), COVERAGE, 2),
    Table("map-rule", "data/map-rule/objects.csv", objects, in_folder("map-rule"), COVERAGE, 2),
    *(Table(f"pb-nbv-{reach}", "data/pb-nbv-objects.csv", within(reach),
            lambda program, _, reach=reach: protocols.specification(program, "pb-nbv", reach), mean_percent("surface_coverage_5mm"))
      for reach in ["whole", "hemisphere", "half"]),
]


def toml(value):
    """A value as TOML on one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)


def dotted(value, prefix=""):
    """The keys of nested tables by their dotted paths."""
    for key, entry in value.items():
        if isinstance(entry, dict):
            yield from dotted(entry, f"{prefix}{key}.")
        else:
            yield prefix + key, entry


def nested(entries):
    """Tables from dotted paths."""
    made = {}
    for path, value in entries.items():
        *folders, key = path.split(".")
        inner = made
        for folder in folders:
            inner = inner.setdefault(folder, {})
        inner[key] = value
    return made


def variants(specification):
    """By label, the variants of a specification, without sweeps."""
    found = {}
    for variant in specification.get("variant", [{}]):
        sweep = dict(dotted(variant.get("sweep", {})))
        others = {key: value for key, value in variant.items() if key not in ("scan", "sweep", "label")}
        for values in itertools.product(*sweep.values()):
            scan = dict(dotted(variant.get("scan", {}))) | dict(zip(sweep, values))
            of_scan = dict(dotted(specification["scan"])) | scan
            shown = lambda value: value if isinstance(value, str) else json.dumps(value)
            template = variant.get("label", ", ".join(
                ["{planner}", *(f"{key.rsplit('.')[-1]} {{{key}}}" for key in sweep if key != "planner")]))
            label = re.sub(r"\{(.*?)\}", lambda key: shown(of_scan.get(key[1], settings.DEFAULT)), template)
            found[label] = others | {"label": label, "scan": nested(scan)}
    return found


def alone(text, label):
    """A specification with one variant only."""
    specification = tomllib.loads(text)
    variant = variants(specification)[label]
    lines = [f"{key} = {toml(value)}" for key, value in specification.items() if key != "variant"]
    return "\n".join([*lines, "[[variant]]", *(f"{key} = {toml(value)}" for key, value in variant.items())]) + "\n"


def measured(program, entry, of):
    """Returns the entry as today's program prints it, or None if the object's mesh is missing."""
    mesh = next(DATA.glob(f"meshes/*/*{entry.object}.ply"), None)
    if mesh is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        spec, out = pathlib.Path(folder, "spec.toml"), pathlib.Path(folder, "out")
        text = of.specification(program, entry)
        spec.write_text(alone(text, entry.variant), encoding="utf-8")
        meshes = [] if "objects" in tomllib.loads(text) else [mesh]
        done = subprocess.run([program, "bench", spec, *meshes, "--out", out], capture_output=True, text=True)
        if done.returncode != 0:
            return f"exit code {done.returncode}: {done.stderr.strip()}"
        return of.value(out)


def turn_of(entries, turn, count, name):
    """The entries of a turn: the whole table, shuffled once, in pieces of this count."""
    entries = sorted(entries, key=lambda entry: entry.name)
    random.Random(name).shuffle(entries)
    return [entries[(turn * count + i) % len(entries)] for i in range(min(count, len(entries)))]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", default="")
    parser.add_argument("--turn", type=int, default=0)
    parser.add_argument("--count", type=int, help="entries of each table (default: one or two, by the table)")
    parser.add_argument("--only", nargs="+", metavar="TABLE", choices=[table.name for table in TABLES])
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    n_right, n_skipped, wrong = 0, 0, []
    for of in TABLES:
        if options.only and of.name not in options.only:
            continue
        entries = of.entries((DOCS / of.file).read_text(encoding="utf-8"))
        if options.list:
            print(f"{of.name}: {len(entries)} entries in docs/{of.file}")
            continue
        for entry in turn_of(entries, options.turn, options.count or of.count, of.name):
            found = measured(str(pathlib.Path(options.program).resolve()), entry, of)
            if found is None:
                n_skipped += 1
                print(f"SKIPPED {of.name}: {entry.object}: no such mesh in {DATA / 'meshes'}", file=sys.stderr)
                continue
            same = found == entry.printed
            n_right += same
            print(f"{of.name}: {entry.name}: {entry.printed}" + ("" if same else f", but measured {found}"), flush=True)
            if not same:
                wrong.append(of.name)
    if options.list:
        return
    print(f"{n_right} of {n_right + len(wrong)} entries are as printed")
    required = os.environ.get("NEXTVIEW_REQUIRE_ALL") == "1"
    sys.exit(bool(wrong) or (required and n_skipped > 0))


if __name__ == "__main__":
    main()
