"""Triangle meshes: reading OBJ and STL, triangles of polygons, welding, measures of shape, writing PLY."""

import numpy as np

# Corners closer than this share of the longest side are one: files state coordinates with five or six digits.
WELD = 1e-5
# Lines along each side of the box, by which a surface is found to be closed.
LINES_ACROSS = 64


class Bad(Exception):
    """A file that cannot be read, with what is wrong."""


class Mesh:
    def __init__(self, vertices, triangles):
        self.vertices = vertices
        self.triangles = triangles

    def sides(self):
        """Lengths of the box around the mesh along x, y and z."""
        return np.ptp(self.vertices, axis=0) if len(self.vertices) else np.zeros(3)

    def crosses(self):
        """Of each triangle the normal, as long as twice its area."""
        a, b, c = (self.vertices[self.triangles[:, i]] for i in range(3))
        u, v = b - a, c - a
        return np.stack([u[:, i] * v[:, j] - u[:, j] * v[:, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=1)

    def welded(self):
        """With corners at the same place made one, without triangles that have no area or are there twice, and
        without vertices that no triangle has. Single precision: what is measured is what is written."""
        used = np.unique(self.triangles)
        vertices = self.vertices[used]
        if not len(used):
            return Mesh(vertices, self.triangles)
        cell = max(np.ptp(vertices, axis=0).max(), 1e-300) * WELD
        keys = np.round((vertices - vertices.min(0)) / cell).astype(np.int64)
        key = (keys[:, 0] << 42) | (keys[:, 1] << 21) | keys[:, 2]
        _, first, corner = np.unique(key, return_index=True, return_inverse=True)
        triangles = corner[np.searchsorted(used, self.triangles)].reshape(-1, 3)
        is_one = (triangles != np.roll(triangles, 1, axis=1)).all(1)
        triangles = triangles[is_one]
        _, once = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
        mesh = Mesh(vertices[first].astype(np.float32).astype(float), triangles[np.sort(once)])
        mesh.triangles = mesh.triangles[(mesh.crosses() != 0).any(1)]
        left, order = np.unique(mesh.triangles, return_inverse=True)
        return Mesh(mesh.vertices[left], order.reshape(-1, 3))


def triangulated(points, corners, n_corners):
    """Triangles of polygons, which may have dents."""
    starts = np.cumsum(n_corners) - n_corners
    of = lambda n: corners[starts[n_corners == n][:, None] + np.arange(n)]
    quads = of(4)
    a, b, c, d = (points[quads[:, i]] for i in range(4))
    # A quadrangle is cut from its first to its third corner unless one of them is not the dent.
    is_dented = (np.cross(b - a, c - a) * np.cross(c - a, d - a)).sum(1) < 0
    quads[is_dented] = np.roll(quads[is_dented], 1, axis=1)
    found = [of(3), quads[:, :3], quads[:, [0, 2, 3]]]
    found += [ears(points, corners[i : i + n]) for i, n in zip(starts[n_corners > 4], n_corners[n_corners > 4])]
    return np.concatenate(found)


def ears(points, polygon):
    """Triangles of a polygon of five corners or more, cut off one by one where the corner sticks out and no other
    corner lies in the triangle."""
    around = points[polygon]
    normal = np.cross(around, np.roll(around, -1, axis=0)).sum(0)
    drop = int(np.abs(normal).argmax())
    flat = np.delete(around, drop, axis=1) - np.delete(around[0], drop)
    if (normal[drop] < 0) != (drop == 1):
        flat[:, 0] *= -1
    at = [(float(x), float(y)) for x, y in flat]
    turn = lambda i, j, k: (
        (at[j][0] - at[i][0]) * (at[k][1] - at[i][1]) - (at[j][1] - at[i][1]) * (at[k][0] - at[i][0])
    )
    left, found = list(range(len(polygon))), []
    while len(left) > 3:
        for n in range(len(left)):
            i, j, k = left[n - 1], left[n], left[(n + 1) % len(left)]
            is_in = lambda p: turn(i, j, p) >= 0 and turn(j, k, p) >= 0 and turn(k, i, p) >= 0
            others = (p for p in left if at[p] not in (at[i], at[j], at[k]))
            if turn(i, j, k) > 0 and not any(map(is_in, others)):
                break
        else:
            # It crosses itself: nothing is right, so the next corner is as good as any.
            n = 1
            i, j, k = left[:3]
        found.append((i, j, k))
        del left[n]
    return polygon[np.array([*found, left])]


def read_obj(data):
    """The mesh of an OBJ file's bytes."""
    vertices, corners, n_corners = [], [], []
    for number, line in enumerate(data.splitlines(), 1):
        words = line.split()
        try:
            if not words:
                continue
            if words[0] == b"v":
                vertices.append([float(word) for word in words[1:4]])
            elif words[0] == b"f":
                face = [int(word.split(b"/", 1)[0]) for word in words[1:]]
                # Negative numbers count back from the latest vertex.
                corners += [i - 1 if i > 0 else len(vertices) + i for i in face]
                n_corners.append(len(face))
        except ValueError:
            raise Bad(f"line {number}: {line[:40]!r} contains something other than numbers") from None
    points = np.array(vertices, dtype=float).reshape(-1, 3)
    corners, n_corners = np.array(corners, dtype=np.int64), np.array(n_corners, dtype=np.int64)
    if len(corners) and not 0 <= corners.min() <= corners.max() < len(points):
        raise Bad(f"a face names a vertex outside 1 to {len(points)}")
    return Mesh(points, triangulated(points, corners, n_corners))


def read_stl(data):
    """The mesh of a binary STL file's bytes."""
    n = int.from_bytes(data[80:84], "little")
    if len(data) != 84 + 50 * n:
        raise Bad(f"is not a binary STL: {len(data)} bytes, where {n} triangles take {84 + 50 * n}")
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    table = np.frombuffer(data, record, offset=84)
    return Mesh(table["corners"].reshape(-1, 3).astype(float), np.arange(3 * n).reshape(-1, 3))


def ply(mesh):
    """The bytes of a binary PLY file."""
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment unit: metres\n"
        f"element vertex {len(mesh.vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(mesh.triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(mesh.triangles), [("n", "u1"), ("corners", "<i4", 3)])
    faces["n"], faces["corners"] = 3, mesh.triangles
    return header.encode() + mesh.vertices.astype("<f4").tobytes() + faces.tobytes()


def odd_lines(mesh):
    """Of the lines along x, y and z that meet the surface, the share that meets it an odd number of times: 0 for a
    closed surface, whatever its parts and seams, and 1 for a sheet that lies in their way."""
    n_odd = n_met = 0
    corners = mesh.vertices[mesh.triangles]
    low, cell = mesh.vertices.min(0), mesh.sides().max() / LINES_ACROSS
    for axis in range(3):
        # In units of the lines' distance; off the grid, so that no line lies in a face of a box.
        flat = (np.delete(corners, axis, axis=2) - np.delete(low, axis)) / cell + np.array([0.4142, 0.3028])
        first, last = np.ceil(flat.min(1)).astype(np.int64), np.floor(flat.max(1)).astype(np.int64)
        n = np.maximum(last - first + 1, 0)
        n_lines = n[:, 0] * n[:, 1]
        of = np.repeat(np.arange(len(flat)), n_lines)
        at = np.arange(len(of)) - np.repeat(np.cumsum(n_lines) - n_lines, n_lines)
        u, v = first[of, 0] + at // n[of, 1], first[of, 1] + at % n[of, 1]
        p, q = flat, np.roll(flat, -1, axis=1)
        # A line is in a triangle if it crosses an odd number of the sides that begin beyond it.
        is_in = np.zeros(len(of), bool)
        for side in range(3):
            (pu, pv), (qu, qv) = p[of, side].T, q[of, side].T
            is_across = (pv > v) != (qv > v)
            with np.errstate(divide="ignore", invalid="ignore"):
                is_in ^= is_across & (u < pu + (v - pv) / (qv - pv) * (qu - pu))
        _, count = np.unique(u[is_in] * 1000 + v[is_in], return_counts=True)
        n_odd, n_met = n_odd + int((count % 2).sum()), n_met + len(count)
    return n_odd / max(n_met, 1)


def signature(mesh):
    """Seven numbers that copies share, wherever they lie, whatever their size, and turned by quarters about the axes.
    Lengths are shares of the longest side."""
    sides = np.sort(mesh.sides())[::-1]
    areas = np.sqrt((mesh.crosses() ** 2).sum(1)) / 2
    middles = mesh.vertices[mesh.triangles].mean(1)
    weights = areas / areas.sum()
    arms = middles - (middles * weights[:, None]).sum(0)
    spread = np.array([[(arms[:, i] * arms[:, j] * weights).sum() for j in range(3)] for i in range(3)])
    widths = np.sqrt(np.maximum(np.linalg.eigvalsh(spread), 0))
    radius = (np.sqrt((arms**2).sum(1)) * weights).sum()
    lengths = np.array([*sides[1:], *widths, radius]) / sides[0]
    return np.array([*lengths, np.sqrt(areas.sum()) / sides[0] / 2])
