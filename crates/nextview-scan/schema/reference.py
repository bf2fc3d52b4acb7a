#!/usr/bin/env python3
"""Writes docs/configuration.md, every key of a configuration, from scan_config.json in this folder.

    reference.py           # writes it
    reference.py --check   # fails if it would write something else
"""

import json
import pathlib
import re
import sys
import textwrap

HERE = pathlib.Path(__file__).resolve().parent
PAGE = HERE / "../../../docs/configuration.md"
WIDTH = 110

INTRODUCTION = """\
# Every key of a configuration

`nextview scan OBJECT --config FILE` reads these keys from a TOML file; options of the command line override
them, and `config.toml` in the results of a scan has everything that determined it. In a
[campaign](bench.md) they are under `[scan]` and `scan`; Python, the [server](server.md) and the [ROS 2
node](ros2.md) take them, too. A file needs only those that differ from the default. An unknown key is an
error, which names the nearest known key.

```toml
planner = "most-surface"
voxel_size_m = 0.002

[camera]                  # of your own camera; or sensor = "d405"
width = 848
height = 480
fx = 421.3
fy = 421.3
cx = 423.6
cy = 239.5

[object_box]
rule = "grows"
table = "fit"
```

This page is made from the types by `crates/nextview-scan/schema/reference.py`. Defaults are those of the
profile `default`.
"""


def plain(text):
    """A description of rustdoc as a paragraph of Markdown: no code, no links into the code."""
    text = re.sub(r"```.*?```", "", text, flags=re.S)
    text = re.sub(r"\[([^\]]+)\]\((?:crate|super|Self)[^)]*\)", r"\1", text)
    text = re.sub(r"\[(`[^`]+`)\](?!\()", r"\1", text)
    return " ".join(text.split())


def default_of(schema):
    """The default as TOML, or nothing."""
    if "default" not in schema or isinstance(schema["default"], (dict, list)):
        return ""
    return f"`{json.dumps(schema['default'])}`"


class Reference:
    """The pages' parts: a section for each table of the configuration."""

    def __init__(self, schema):
        self.definitions = schema["$defs"]
        self.sections = []
        self.section("", schema)

    def resolved(self, schema):
        """The schema that a key refers to, itself if it refers to none."""
        for part in [schema, *schema.get("anyOf", [])]:
            if "$ref" in part:
                return self.definitions[part["$ref"].rsplit("/", 1)[1]]
        return schema

    def section(self, path, schema, about="", brackets="[]"):
        """A table with the keys of this one, and then those within it; in double brackets, one of a list."""
        rows, below, values = [], [], []
        for key, entry in schema["properties"].items():
            target = self.resolved(entry)
            name = f"{path}{key}"
            meaning_of_key = plain(entry.get("description", ""))
            items = self.resolved(target.get("items", {}))
            table, its_brackets = (items, ("[[", "]]")) if "properties" in items else (target, "[]")
            if "properties" in table and not self.is_pose(table):
                below.append((name, entry, table, its_brackets))
                continue
            values += [line for value, meaning in self.values(target) if meaning
                       for line in textwrap.wrap(f"- `{key}` = `{value}`: {meaning}", WIDTH, subsequent_indent="  ")]
            rows.append(f"| `{key}` | {self.kind(entry, target)} | {default_of(entry)} | {meaning_of_key} |")
        title = f"## `{brackets[0]}{path[:-1]}{brackets[1]}`" if path else "## At the top"
        parts = [[title], textwrap.wrap(about, WIDTH) if path else [],
                 ["| key | value | default | |", "|---|---|---|---|", *rows] if rows else [], values]
        self.sections += ["\n".join(part) + "\n" for part in parts if part]
        for name, entry, target, its_brackets in below:
            own = plain(target.get("description", ""))
            # What names a type of the library says less than what the key is for.
            about = [plain(entry.get("description", "")), "" if own.startswith("Parameters of") else own]
            self.section(f"{name}.", target, " ".join(part for part in dict.fromkeys(about) if part), its_brackets)

    def is_pose(self, target):
        """Whether this is a rigid transform, which is written inline."""
        return "rotation_xyzw" in target["properties"]

    def kind(self, entry, target):
        """What a value can be."""
        values = self.values(target)
        if values:
            return ", ".join(f"`{value}`" for value, _ in values)
        if "properties" in target:
            return "pose: `rotation_xyzw`, `translation_m`"
        kinds = target.get("type") or [part.get("type") for part in target.get("anyOf", [])]
        kinds = [kinds] if isinstance(kinds, str) else [kind for kind in kinds if kind]
        known = {"integer": "whole number", "number": "number", "string": "text", "boolean": "true or false"}
        if "array" in kinds:
            items = self.resolved(target.get("items", {}))
            n = target.get("maxItems")
            what = "poses" if "properties" in items else "numbers"
            if items.get("type") == "array":
                return f"list of {items['maxItems']} numbers each"
            return f"{n} {what}" if n else f"list of {what}"
        return next((known[kind] for kind in kinds if kind in known), "")

    def values(self, target):
        """The texts that a value can be, if they are known, and what they mean."""
        options = [self.resolved(option) for option in target.get("anyOf", [])]
        found = []
        for option in target.get("oneOf", []):
            meaning = plain(option.get("description", ""))
            if "const" in option:
                found.append((option["const"], meaning))
            for name, entry in option.get("properties", {}).items():
                found.append((f"{{ {name} = {self.kind(entry, self.resolved(entry))} }}", meaning))
        return found + [value for option in options for value in self.values(option)]


def page():
    """The text of the page."""
    schema = json.loads((HERE / "scan_config.json").read_text(encoding="utf-8"))
    reference = Reference(schema)
    introduction = INTRODUCTION.rstrip("\n")
    return "\n".join([introduction, "", *reference.sections])


def main():
    text = page()
    if sys.argv[1:] == ["--check"]:
        kept = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""
        if kept != text:
            sys.exit(f"{PAGE.resolve()} differs from the types: rewrite it with {pathlib.Path(__file__).name}")
    elif sys.argv[1:]:
        sys.exit(__doc__)
    else:
        PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
