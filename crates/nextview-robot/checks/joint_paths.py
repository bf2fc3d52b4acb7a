#!/usr/bin/env python3
"""Checks paths printed by the example `joint_paths` with other code: kinematics in numpy, distances by coal.

Usage: joint_paths.py paths.jsonl [most_paths]. Needs numpy and coal (`pip install pin` brings both).

Every path is sampled at most 0.002 rad apart in any joint. Samples are left out only where the distances of
the sample before and the reach of the arm prove them free.
"""

import json
import sys

import coal
import numpy as np

STEP = 0.002


def matrix(pose):
    x, y, z, w = pose["rotation_xyzw"]
    rotation = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = rotation, pose["translation_m"]
    return result


def solid(shape):
    if "half" in shape:
        return coal.Box(*(2.0 * np.array(shape["half"]))), matrix(shape["pose"])
    return coal.Cylinder(shape["radius"], shape["length"]), matrix(shape["pose"])


def boxes(blocked, n, voxel):
    """Blocked voxels as few boxes: runs along x, merged over y and z where equal."""
    free = np.array([c == "1" for c in blocked]).reshape(n, n, n)
    while free.any():
        z, y, x = np.argwhere(free)[0]
        x1 = x
        while x1 < n and free[z, y, x1]:
            x1 += 1
        y1 = y
        while y1 < n and free[z, y1, x:x1].all():
            y1 += 1
        z1 = z
        while z1 < n and free[z1, y:y1, x:x1].all():
            z1 += 1
        free[z:z1, y:y1, x:x1] = False
        low, high = np.array([x, y, z]) * voxel, np.array([x1, y1, z1]) * voxel
        yield coal.Box(*(high - low)), 0.5 * (low + high)


class Cell:
    def __init__(self, told):
        self.joints = [matrix(joint["parent_from_joint"]) for joint in told["joints"]]
        links = [[solid(shape) for shape in link] for link in told["links"]]
        carried = [solid(shape) for shape in told["camera"]]
        self.parts = [(i, shape) for i, link in enumerate(links) for shape in link]
        n_of_links = len(self.parts)
        self.parts += [(len(self.joints), shape) for shape in carried]
        may_touch = {tuple(pair) for pair in told["may_touch"]}
        self.pairs = []
        for a, (link_a, _) in enumerate(self.parts):
            for b, (link_b, _) in enumerate(self.parts):
                is_allowed = b < n_of_links and (link_a, link_b) in may_touch
                if link_a < link_b and not is_allowed:
                    self.pairs.append((a, b))
        self.manager = coal.DynamicAABBTreeCollisionManager()
        self.obstacles = []
        self.add(coal.Box(*(2.0 * np.array(told["wall"]["half"]))), matrix(told["wall"]["pose"]))
        grid = matrix(told["grid"])
        for box, middle in boxes(told["blocked"], told["n"], told["voxel"]):
            pose = grid.copy()
            pose[:3, 3] = grid[:3, :3] @ middle + grid[:3, 3]
            self.add(box, pose)
        table = np.eye(4)
        table[2, 3] = -1.0
        self.add(coal.Box(20.0, 20.0, 2.0), table)
        self.manager.setup()
        self.moved = [coal.CollisionObject(shape[0]) for _, shape in self.parts]
        # For each joint, no point that it moves is ever farther away from it, metres.
        n = len(self.joints)
        self.reach = np.array([max(self.reach_of(i, *part) for part in self.parts) for i in range(n)])

    def reach_of(self, joint, link, shape):
        if link <= joint:
            return 0.0
        form, pose = shape
        is_box = hasattr(form, "halfSide")
        size = np.linalg.norm(form.halfSide) if is_box else form.radius + form.halfLength
        between = [np.linalg.norm(self.joints[i][:3, 3]) for i in range(joint + 1, link)]
        return sum(between) + np.linalg.norm(pose[:3, 3]) + size

    def add(self, shape, pose):
        item = coal.CollisionObject(shape, coal.Transform3s(pose[:3, :3].copy(), pose[:3, 3].copy()))
        self.obstacles.append(item)
        self.manager.registerObject(item)

    def distances(self, values):
        """From obstacles, and of the parts of the arm from each other."""
        poses = [np.eye(4)]
        for parent_from_joint, value in zip(self.joints, values):
            turn = np.eye(4)
            c, s = np.cos(value), np.sin(value)
            turn[:2, :2] = [[c, -s], [s, c]]
            poses.append(poses[-1] @ parent_from_joint @ turn)
        for item, (link, (_, link_from_shape)) in zip(self.moved, self.parts):
            pose = poses[link] @ link_from_shape
            item.setTransform(coal.Transform3s(pose[:3, :3].copy(), pose[:3, 3].copy()))
            item.computeAABB()
        aside = apart = np.inf
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        for item, (link, _) in zip(self.moved, self.parts):
            if link > 0:
                callback = coal.DistanceCallBackDefault()
                self.manager.distance(item, callback)
                aside = min(aside, callback.data.result.min_distance)
        for a, b in self.pairs:
            result.clear()
            apart = min(apart, coal.distance(self.moved[a], self.moved[b], request, result))
        return np.array([aside, apart])


def least_on(cell, start, end):
    """The least distances at samples, and how many there were."""
    change = np.array(end) - np.array(start)
    n = max(1, int(np.ceil(np.abs(change).max() / STEP)))
    # While all joints move by a sample, no two points approach each other by more than this.
    most = (np.abs(change) * cell.reach).sum() / n
    i, least, n_checked = 0, np.inf, 0
    while i <= n:
        distances = cell.distances(start + change * (i / n))
        least, n_checked = np.minimum(least, distances), n_checked + 1
        if distances.min() <= 0.0:
            break
        i += max(1, int(distances.min() / most)) if most > 0.0 else n + 1
    return least, n_checked


def main():
    with open(sys.argv[1]) as file:
        lines = [json.loads(line) for line in file]
    cell, pairs = Cell(lines[0]), lines[1:]
    most = int(sys.argv[2]) if len(sys.argv) > 2 else len(pairs)
    found = [pair for pair in pairs if pair["corners"]]
    times = np.array([pair["plan_ms"] for pair in pairs])
    straight = sum(len(pair["corners"]) == 2 for pair in found)
    print(f"{len(pairs)} pairs, {len(found)} paths, {straight} of them straight")
    print(f"time to plan: median {np.median(times):.2f} ms, 99 % {np.percentile(times, 99):.0f} ms, "
          f"longest {times.max():.0f} ms")
    compared = [pair["duration_s"] / pair["best_s"] for pair in found if pair["best_s"]]
    if compared:
        shares = np.array(compared)
        print(f"duration over that of the best of 20 attempts, {len(shares)} paths: median "
              f"{np.median(shares):.3f}, 99 % {np.percentile(shares, 99):.3f}, largest {shares.max():.3f}, "
              f"within twice: {np.mean(shares <= 2.0):.4f}")
    least, n_samples, collisions = np.full(2, np.inf), 0, 0
    for number, pair in enumerate(found[:most]):
        corners = np.array(pair["corners"])
        legs = [least_on(cell, a, b) for a, b in zip(corners, corners[1:])]
        of_path = np.min([distances for distances, _ in legs], axis=0)
        n_samples += sum(n for _, n in legs)
        least = np.minimum(least, of_path)
        if of_path.min() <= 0.0:
            collisions += 1
            print(f"path {number} collides: {of_path}")
    print(f"{min(most, len(found))} paths at {n_samples} samples: {collisions} collide, least distances "
          f"from obstacles {least[0] * 1e3:.3f} mm, of parts {least[1] * 1e3:.3f} mm")
    sys.exit(collisions > 0)


main()
