#!/usr/bin/env python3
"""Makes the figures of docs/concepts.md, from scans of the built-in mug by a simulated camera.

    python docs/figures/figures.py

Needs the Python package: pip install ./python
"""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import nextview
from nextview import Map

OUT = Path(__file__).resolve().parent
N_VIEWS, SHOWN = 5, (1, 2, 5)
COLOURS = {"unknown": "#c3cad3", "free": "#f4f6f8", "occupied": "#1f2937", "frontier": "#f97316"}
LINES = {"clairvoyant": "#6b7280", "most-surface": "#1d4ed8", "random views": "#f97316"}


def svg(name: str, width: int, height: int, parts: list[str]) -> None:
    """Writes a figure on a white ground, so that it can be read on a dark page, too."""
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}"'
    ground = f'<rect width="{width}" height="{height}" fill="white"/>'
    body = "\n".join([ground, *parts])
    (OUT / name).write_text(f'{head} font-family="sans-serif" font-size="13">\n{body}\n</svg>\n', encoding="utf-8")


def text(x: float, y: float, words: str, anchor: str = "middle") -> str:
    halo = 'stroke="white" stroke-width="4" paint-order="stroke"'
    return f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="{anchor}" fill="#1f2937" {halo}>{words}</text>'


def box(x: float, y: float, width: float, height: float, colour: str) -> str:
    return f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" fill="{colour}"/>'


def circle(x: float, y: float, radius: float, style: str) -> str:
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" {style}/>'


def touches(voxels: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The voxels that touch one of these by a face, an edge or a corner."""
    for axis in range(3):
        padded = np.pad(voxels, [(int(i == axis),) * 2 for i in range(3)])
        first, last = (np.take(padded, range(k, k + voxels.shape[axis]), axis) for k in (0, 2))
        voxels = voxels | first | last
    return voxels


def slice_of(occupancy: NDArray[np.int8]) -> NDArray[np.str_]:
    """The state of each voxel in the vertical slice through the middle of the object; rows are heights."""
    states = np.select([occupancy == Map.OCCUPIED, occupancy == Map.FREE], ["occupied", "free"], "unknown")
    frontier = (states == "unknown") & touches(states == "occupied") & touches(states == "free")
    return np.where(frontier, "frontier", states)[:, states.shape[1] // 2].T


class Unknown(nextview.Gain):
    """The visible unknown voxels of each candidate, kept for the figure."""

    gains: dict[int, float] = {}

    def begin(self, situation: nextview.Situation) -> None:
        self.is_unknown = (situation.map.occupancy == Map.UNKNOWN).ravel()
        self.n_valued, self.views = 0, list(situation.open_views)
        Unknown.gains = {}

    def gain(self, situation: nextview.Situation, rays: nextview.Rays) -> float:
        gain = float((rays.visibilities * self.is_unknown[rays.voxels]).sum())
        Unknown.gains[int(self.views[self.n_valued])] = gain
        self.n_valued += 1
        return gain


def scan(planner: str | type[nextview.Gain], views: int, n: int) -> tuple[nextview.Scan, dict[int, NDArray[np.str_]]]:
    """A scan of the mug with n candidates, and the slice of its map after each view."""
    scene = nextview.SimulatedScene("builtin:mug")
    scan = nextview.Scan(scene.camera, box=scene.box_m, candidates=n, planner=planner, views=views, voxel_size_m=0.005)
    slices = {}
    while (view := scan.next_view()) is not None:
        scan.observe(scene.capture(view), view)
        slices[len(scan.steps)] = slice_of(scan.map.occupancy)
    return scan, slices


def occupancy() -> None:
    _, slices = scan("most-surface", N_VIEWS, 200)
    size, gap, parts = 5.0, 20, []
    rows, columns = slices[1].shape
    for i, shown in enumerate(SHOWN):
        left = gap + i * (columns * size + gap)
        parts.append(text(left + columns * size / 2, 20, f"after {shown} view{'s' * (shown > 1)}"))
        for row, states in enumerate(slices[shown][::-1]):
            column = 0
            for state, run in itertools.groupby(states):
                n = len(list(run))
                parts.append(box(left + column * size, 30 + row * size, n * size, size, COLOURS[str(state)]))
                column += n
    foot = 30 + rows * size + 25
    for i, (state, colour) in enumerate(COLOURS.items()):
        parts.append(box(gap + 130 * i, foot - 11, 13, 13, "#9ca3af"))
        parts.append(box(gap + 130 * i + 1, foot - 10, 11, 11, colour))
        parts.append(text(gap + 20 + 130 * i, foot, state, "start"))
    svg("occupancy.svg", round(gap + len(SHOWN) * (columns * size + gap)), round(foot + 12), parts)


def gain() -> None:
    done, _ = scan(Unknown, 2, 400)
    positions = done.candidates[:, :3, 3]
    positions = positions - positions.mean(axis=0)
    first, chosen = (step["view"] for step in done.steps)
    most = max(Unknown.gains.values())
    parts = [text(20, 20, "the direction of each candidate, and its information gain after the first view", "start")]

    def place(view: int) -> tuple[float, float]:
        x, y, z = positions[view]
        height = np.degrees(np.arcsin(z / np.linalg.norm(positions[view])))
        return 40 + (np.degrees(np.arctan2(y, x)) + 180) * 1.8, 40 + (90 - height) * 1.4

    for view, value in Unknown.gains.items():
        (x, y), share = place(view), value / most
        parts.append(circle(x, y, 2 + 4 * share, f'fill="#1d4ed8" opacity="{0.15 + 0.85 * share:.2f}"'))
    for view, label in ((first, "first view"), (chosen, "next view: the largest gain")):
        x, y = place(view)
        parts.append(circle(x, y, 9, 'fill="none" stroke="#f97316" stroke-width="3"'))
        parts.append(text(x + (14 if x < 500 else -14), y + 5, label, "start" if x < 500 else "end"))
    parts += [text(20, 38, "from above", "start"), text(20, 306, "from below", "start")]
    parts.append(text(364, 312, "azimuth, -180 to 180 degrees"))
    svg("gain.svg", 728, 322, parts)


def coverage() -> None:
    record = nextview.scan("builtin:mug", views=10).record
    curves = {
        "clairvoyant": record["clairvoyant_curve"],
        "most-surface": [step["reachable_coverage"] for step in record["steps"]],
        "random views": record["random_curve"],
    }
    parts = [text(20, 20, "share of the reachable surface seen, %", "start"), text(330, 312, "views")]
    for percent in range(0, 101, 25):
        y = 285 - 2.5 * percent
        parts += [f'<path d="M50 {y}H610" stroke="#d1d5db"/>', text(42, y + 4, str(percent), "end")]
    for i, (name, curve) in enumerate(curves.items()):
        points = " ".join(f"{60 * k + 60},{285 - 250 * share:.1f}" for k, share in enumerate(curve))
        parts.append(f'<polyline points="{points}" fill="none" stroke="{LINES[name]}" stroke-width="2.5"/>')
        parts.append(f'<path d="M440 {190 + 22 * i}h24" stroke="{LINES[name]}" stroke-width="2.5"/>')
        parts.append(text(470, 194 + 22 * i, name, "start"))
    parts += [text(60 * k + 60, 300, str(k + 1)) for k in range(len(curves["most-surface"]))]
    svg("coverage.svg", 630, 322, parts)


if __name__ == "__main__":
    occupancy()
    gain()
    coverage()
