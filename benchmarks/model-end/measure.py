"""How good a model is, and how far its frames are from where they should be."""

import numpy as np
from cell import turned
from methods import direction
from scipy.spatial import cKDTree
from surfaces import sampled, surfaces

# What touches the table is nobody's fault.
ABOVE_TABLE_M = .002


class Truth:
    """The surface of a cell's object that a camera above the table can see."""

    N_DIRECTIONS = 80

    def __init__(self, cell, n_points=60_000):
        self.surfaces, self.n, self.floor = surfaces([cell.object]), n_points, cell.TABLE_Z + ABOVE_TABLE_M
        points = sampled(*cell.object, n_points, np.random.default_rng(0))
        points = points[points[:, 2] > self.floor]
        is_seen = np.zeros(len(points), bool)
        for k in range(self.N_DIRECTIONS):
            up = (k + .5) / self.N_DIRECTIONS
            ray = direction(k * np.pi * (3 - 5 ** .5), np.arcsin(up))
            distances, *_ = self.surfaces.cast(points + 1e-4 * ray, np.broadcast_to(ray, points.shape))
            is_seen |= ~np.isfinite(distances)
        self.points = points[is_seen]

    def quality(self, model):
        """The measures of a model, given as vertices and triangles: mean and 95 % distance of the model from the truth in mm,
        precision, recall and F-score at 1 mm in percent, and F-score at half a millimetre; after one rigid motion."""
        vertices, triangles = model
        if len(triangles) == 0:
            return {"error_mm": float("nan"), "error95_mm": float("nan"), **dict.fromkeys(("p1", "r1", "f1", "f05"), 0.0)}
        rng = np.random.default_rng(1)
        motion = fit(sampled(vertices, triangles, min(self.n, 20_000), rng), self.points)
        vertices = moved(motion, np.asarray(vertices, float))
        points = sampled(vertices, triangles, self.n, rng)
        off = self.surfaces.distance(points[points[:, 2] > self.floor])
        missing = surfaces([(vertices, triangles)]).distance(self.points)

        def score(reach):
            precision, recall = (off < reach).mean(), (missing < reach).mean()
            return 200 * precision * recall / max(precision + recall, 1e-9), 100 * precision, 100 * recall

        (f1, p1, r1), (f05, *_) = score(1e-3), score(5e-4)
        measures = {"error_mm": off.mean() * 1e3, "error95_mm": np.quantile(off, .95) * 1e3, "p1": p1, "r1": r1, "f1": f1, "f05": f05}
        return {name: round(float(value), 3) for name, value in measures.items()}


def moved(pose, points):
    """Points in another frame."""
    return points @ pose[:3, :3].T + pose[:3, 3]


def fit(points, truth, reaches=(.04, .008, .003), n_steps=40):
    """The rigid motion that brings points to a surface: iterative closest points along the normals of the surface."""
    tree = cKDTree(truth)
    _, around = tree.query(truth, min(20, len(truth)))
    near = truth[around] - truth[around].mean(1, keepdims=True)
    normals = np.linalg.eigh(np.einsum("nki,nkj->nij", near, near))[1][:, :, 0]
    motion = np.eye(4)
    for reach in reaches:
        for _ in range(n_steps):
            placed = moved(motion, points)
            distance, nearest = tree.query(placed, distance_upper_bound=reach)
            is_pair = np.isfinite(distance)
            if is_pair.sum() < 6:
                break
            p, n = placed[is_pair], normals[nearest[is_pair]]
            residual = ((p - truth[nearest[is_pair]]) * n).sum(1)
            middle = p.mean(0)
            step, *_ = np.linalg.lstsq(np.concatenate([np.cross(p - middle, n), n], 1), -residual, rcond=1e-9)
            small = np.eye(4)
            small[:3, :3] = turned(step[:3])
            small[:3, 3] = middle + step[3:] - small[:3, :3] @ middle
            motion = small @ motion
            if np.abs(step[3:]).max() < 1e-6:
                break
    return motion


def pose_error_mm(found, true, low, high):
    """How far poses put the corners of a box from where the true poses do, root mean square, after one rigid motion."""
    corners = np.array([[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)])
    p = np.concatenate([moved(f @ np.linalg.inv(t), corners) for f, t in zip(found, true)])
    q = np.concatenate([corners] * len(found))
    # Kabsch 1976.
    u, _, v = np.linalg.svd((p - p.mean(0)).T @ (q - q.mean(0)))
    turn = v.T @ np.diag([1, 1, np.sign(np.linalg.det(v.T @ u.T))]) @ u.T
    return float(1e3 * np.sqrt((((p - p.mean(0)) @ turn.T - (q - q.mean(0))) ** 2).sum(1).mean()))
