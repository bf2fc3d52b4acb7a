#!/usr/bin/env python3
"""Checks the benchmark itself: its two ray casters agree, and its measures are what they say. Needs numpy, scipy, open3d."""

import numpy as np
from cell import SENSORS, Cell, PoseErrors, looking, turned
from measure import Truth, fit, moved, pose_error_mm
from surfaces import Open3dSurfaces, SlowSurfaces, box, sampled

rng = np.random.default_rng(1)
low, high = np.array([-.03, -.02, 0]), np.array([.05, .02, .04])
meshes = [box(low, high), box((-1, -1, -.1), (1, 1, -.01))]
fast, slow = Open3dSurfaces(meshes), SlowSurfaces(meshes)

# Rays from all around, and distances of points near and far.
origins = rng.normal(size=(2000, 3))
directions = rng.uniform(-.05, .05, size=(2000, 3)) - origins
(t, which, normals), (slow_t, slow_which, slow_normals) = fast.cast(origins, directions), slow.cast(origins, directions)
is_hit = np.isfinite(slow_t)
assert .9 < is_hit.mean() and (np.isfinite(t) != is_hit).mean() < .002
both = np.isfinite(t) & is_hit & (which == slow_which)
assert both.sum() > .99 * is_hit.sum() and np.abs(t[both] - slow_t[both]).max() < 1e-4
assert np.quantile(np.abs((normals * slow_normals).sum(-1))[both], .01) > .999
points = rng.uniform(-.2, .2, size=(500, 3))
assert np.abs(fast.distance(points) - slow.distance(points)).max() < 1e-5

# A motion is found again, and poses that differ by a motion have no error.
surface = sampled(*meshes[0], 4000, rng)
motion = np.eye(4)
motion[:3, :3], motion[:3, 3] = turned(np.array([.03, -.02, .04])), (.002, -.003, .001)
found = fit(moved(motion, sampled(*meshes[0], 4000, rng)), surface)
assert np.abs(moved(found @ motion, surface) - surface).max() < 5e-4
poses = [looking(rng.normal(size=3), (0, 0, 0)) for _ in range(5)]
assert pose_error_mm([motion @ pose for pose in poses], poses, low, high) < 1e-9
shifted = [np.array(pose) for pose in poses]
shifted[0][:3, 3] += (.001, 0, 0)
assert .3 < pose_error_mm(shifted, poses, low, high) < .5

# The object itself is the best model there can be; half of it has half the recall.
cell = Cell(meshes[0], 1, PoseErrors(), SENSORS["stereo"])
truth = Truth(cell, 4000)
best = truth.quality(cell.object)
assert best["f1"] == 100 and best["error_mm"] < .05, best
vertices, triangles = cell.object
half = truth.quality((vertices, triangles[:6]))
assert half["p1"] == 100 and 20 < half["r1"] < 80, half
nothing = truth.quality((vertices, triangles[:0]))
assert nothing["f1"] == 0

# An exact robot reports true poses, and a camera in front of a wall its distance.
depth, given = cell.capture(looking(cell.center + (0, -.3, .2), cell.center))
assert np.abs(given - cell.poses[0]).max() < 1e-12
seen = moved(given, (cell.rays * depth[..., None])[depth > 0].astype(float))
assert np.quantile(cell.surfaces.distance(seen[(np.abs(seen - cell.center) < .1).all(1)]), .9) < 2e-3
print("the benchmark's parts agree with their twins")
