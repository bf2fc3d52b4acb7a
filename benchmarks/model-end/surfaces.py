"""Rays and distances to triangle meshes: Open3D's, and a slow, obvious twin for small meshes."""

import numpy as np

try:
    import open3d
except ImportError:
    open3d = None


class Open3dSurfaces:
    """Several meshes, given as pairs of vertices and triangles, in Open3D's ray caster (Embree)."""

    def __init__(self, meshes):
        self.scene = open3d.t.geometry.RaycastingScene(nthreads=1)
        for vertices, triangles in meshes:
            self.scene.add_triangles(np.asarray(vertices, np.float32), np.asarray(triangles, np.uint32))

    def cast(self, origins, directions):
        """For each ray: the distance in lengths of its direction (inf: nothing hit), the number of the mesh (-1: none), and
        the unit normal of the triangle."""
        hits = self.scene.cast_rays(np.concatenate([origins, directions], -1).astype(np.float32), nthreads=1)
        which = hits["geometry_ids"].numpy().astype(np.int64)
        which[which == open3d.t.geometry.RaycastingScene.INVALID_ID] = -1
        return hits["t_hit"].numpy().astype(float), which, hits["primitive_normals"].numpy().astype(float)

    def distance(self, points):
        """The distance of each point from the nearest mesh."""
        return self.scene.compute_distance(np.asarray(points, np.float32), nthreads=1).numpy().astype(float)


class SlowSurfaces:
    """The same by testing every triangle, for meshes of some hundred triangles."""

    def __init__(self, meshes):
        corners, self.which = [], []
        for number, (vertices, triangles) in enumerate(meshes):
            corners.append(np.asarray(vertices, float)[np.asarray(triangles)])
            self.which += [number] * len(triangles)
        self.corners, self.which = np.concatenate(corners), np.array(self.which)

    def cast(self, origins, directions):
        """As in Open3dSurfaces."""
        shape = np.shape(origins)[:-1]
        origins, directions = (np.reshape(a, (-1, 3)).astype(float) for a in (origins, directions))
        nearest, found = np.full(len(origins), np.inf), np.full(len(origins), -1)
        normals = np.zeros((len(origins), 3))
        for number, (a, b, c) in zip(self.which, self.corners):
            # Möller & Trumbore 1997.
            across = np.cross(directions, c - a)
            determinant = across @ (b - a)
            with np.errstate(divide="ignore", invalid="ignore"):
                u = np.einsum("ij,ij->i", origins - a, across) / determinant
                turned = np.cross(origins - a, b - a)
                v = np.einsum("ij,ij->i", directions, turned) / determinant
                t = turned @ (c - a) / determinant
                is_hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < nearest)
            nearest[is_hit], found[is_hit] = t[is_hit], number
            normal = np.cross(b - a, c - a)
            normals[is_hit] = normal / max(np.linalg.norm(normal), 1e-300)
        return nearest.reshape(shape), found.reshape(shape), normals.reshape(*shape, 3)

    def distance(self, points):
        """As in Open3dSurfaces."""
        points, least = np.asarray(points, float), np.full(len(points), np.inf)
        for a, b, c in self.corners:
            normal = np.cross(b - a, c - a)
            area = np.linalg.norm(normal)
            if area > 0:
                height = (points - a) @ normal / area
                foot = points - height[:, None] * normal / area
                sides = [np.cross(q - p, foot - p) @ normal >= 0 for p, q in ((a, b), (b, c), (c, a))]
                least = np.where(np.all(sides, 0), np.minimum(least, np.abs(height)), least)
            for p, q in ((a, b), (b, c), (c, a)):
                along = np.clip((points - p) @ (q - p) / max((q - p) @ (q - p), 1e-300), 0, 1)
                least = np.minimum(least, np.linalg.norm(points - p - along[:, None] * (q - p), axis=1))
        return least


def surfaces(meshes):
    """The fastest implementation that is installed."""
    return Open3dSurfaces(meshes) if open3d else SlowSurfaces(meshes)


def box(low, high):
    """A box as vertices and triangles that face outwards."""
    corners = np.array([[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)], float)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def sampled(vertices, triangles, n, rng):
    """n points, evenly distributed over the surface."""
    corners = np.asarray(vertices, float)[np.asarray(triangles)]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    chosen = corners[rng.choice(len(corners), n, p=areas / areas.sum())]
    u, v = np.sqrt(rng.random(n)), rng.random(n)
    return chosen[:, 0] * (1 - u)[:, None] + chosen[:, 1] * (u * (1 - v))[:, None] + chosen[:, 2] * (u * v)[:, None]
