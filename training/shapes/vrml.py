"""Reads the triangles of VRML 2.0: face sets below groups, transforms and switches, with DEF and USE."""

import math
import re

import numpy as np

from meshes import Bad, Mesh, triangulated

# A comment, a string, a list of nothing but numbers (nearly all of a file is such lists), a bracket, a word.
TOKEN = re.compile(r'#[^\n]*|"(?:[^"\\]|\\.)*"|\[[-+0-9.eE,\s]*\]|[{}\[\]]|[^\s,{}\[\]"#]+')
SCALAR = re.compile(r'["0-9.+-]|(?:TRUE|FALSE)$')

CHILDREN = {"Group": "children", "Transform": "children", "Anchor": "children", "Collision": "children"}
# Curves and writing have no surface.
WITHOUT_SURFACE = {"IndexedLineSet", "PointSet", "Text"}
IDENTITY = np.eye(4)


class Node:
    def __init__(self, kind, fields):
        self.kind = kind
        self.fields = fields

    def numbers(self, name, default):
        """The numbers of a field, as many as the default has."""
        values = self.fields.get(name, default)
        if len(values) != len(default):
            raise Bad(f"{self.kind}.{name} has {len(values)} numbers instead of {len(default)}")
        return np.array(values, dtype=float)

    def below(self, name):
        """The nodes in a field, which may hold one or a list."""
        value = self.fields.get(name)
        return [node for node in (value if isinstance(value, list) else [value]) if isinstance(node, Node)]


class Parser:
    def __init__(self, text):
        self.tokens = [token for token in TOKEN.findall(text) if token[0] != "#"]
        self.at = 0
        self.named = {}

    def peek(self):
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def next(self):
        token = self.peek()
        if not token:
            raise Bad("the file ends within a node")
        self.at += 1
        return token

    def scene(self):
        nodes = []
        while self.peek():
            nodes.append(self.value())
        return [node for node in nodes if isinstance(node, Node)]

    def node(self, kind):
        if self.next() != "{":
            raise Bad(f"`{{` expected after {kind!r}")
        fields = {}
        while self.peek() != "}":
            name = self.next()
            fields[name] = self.value()
        self.next()
        return Node(kind, fields)

    def value(self):
        token = self.next()
        if token == "[":
            values = []
            while self.peek() != "]":
                value = self.value()
                values += value if isinstance(value, list) else [value]
            self.next()
            return values
        if token[0] == "[":
            return numbers(token[1:-1])
        if SCALAR.match(token):
            values = [scalar(token)]
            while SCALAR.match(self.peek()):
                values.append(scalar(self.next()))
            return values
        if token == "DEF":
            name = self.next()
            self.named[name] = self.node(self.next())
            return self.named[name]
        if token == "USE":
            name = self.next()
            if name not in self.named:
                raise Bad(f"USE {name}: no such DEF before it")
            return self.named[name]
        if token == "NULL":
            return None
        if self.peek() == "{":
            return self.node(token)
        raise Bad(f"{token!r} where a value should be")


def numbers(text):
    return list(map(float, text.replace(",", " ").split()))


def scalar(token):
    if token[0] == '"' or token in ("TRUE", "FALSE"):
        return token
    try:
        # Whole numbers may be hexadecimal.
        return float(int(token, 16)) if token[:2].lower() == "0x" else float(token)
    except ValueError:
        raise Bad(f"{token!r} where a number should be") from None


def matrix(node):
    """What takes points of a Transform's children to its parent: the standard's T C R SR S -SR -C."""
    center = moved(node.numbers("center", [0, 0, 0]))
    stretch = turned(node.numbers("scaleOrientation", [0, 0, 1, 0]))
    scale = np.diag([*node.numbers("scale", [1, 1, 1]), 1.0])
    chain = [moved(node.numbers("translation", [0, 0, 0])), center, turned(node.numbers("rotation", [0, 0, 1, 0])),
             stretch, scale, np.linalg.inv(stretch), np.linalg.inv(center)]
    return np.linalg.multi_dot(chain)


def moved(by):
    found = np.eye(4)
    found[:3, 3] = by
    return found


def turned(rotation):
    """Rodrigues' formula of an axis and an angle in radians."""
    found = np.eye(4)
    axis, angle = rotation[:3], rotation[3]
    length = math.sqrt(float((axis * axis).sum()))
    if length > 0:
        x, y, z = axis / length
        across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        found[:3, :3] += math.sin(angle) * across + (1 - math.cos(angle)) * (across @ across)
    return found


def face_set(node, to_scene):
    """Points of a face set and its polygons, each ended by -1."""
    points = [value for coord in node.below("coord") for value in coord.fields.get("point", [])]
    if len(points) % 3:
        raise Bad(f"a list of points has {len(points)} numbers, no multiple of 3")
    points = np.array(points, dtype=float).reshape(-1, 3)
    indices = np.array(node.fields.get("coordIndex", []), dtype=float).astype(np.int64)
    if len(indices) and (indices.max() >= len(points) or indices.min() < -1):
        raise Bad(f"a face names a point outside 0 to {len(points) - 1}")
    if len(indices) and indices[-1] >= 0:
        indices = np.append(indices, -1)
    is_mirrored = False
    if to_scene is not IDENTITY:
        # Sum by sum: a library's product may round in another order on another machine.
        points = (points[:, None, :] * to_scene[None, :3, :3]).sum(2) + to_scene[:3, 3]
        is_mirrored = np.linalg.det(to_scene[:3, :3]) < 0
    is_clockwise = node.fields.get("ccw") == ["FALSE"]
    if is_mirrored != is_clockwise:
        indices = np.roll(indices[::-1], -1)
    return points, indices


def face_sets(node, to_scene):
    """The face sets of a node and of those below it."""
    if node.kind == "Transform":
        to_scene = to_scene @ matrix(node)
    if node.kind in CHILDREN:
        below = node.below(CHILDREN[node.kind])
    elif node.kind == "Switch":
        choice = int(node.fields.get("whichChoice", [-1])[0])
        choices = node.below("choice")
        below = choices[choice : choice + 1] if choice >= 0 else []
    elif node.kind == "LOD":
        below = node.below("level")[:1]
    elif node.kind == "Shape":
        below = [shape for shape in node.below("geometry") if shape.kind not in WITHOUT_SURFACE]
        for shape in below:
            if shape.kind != "IndexedFaceSet":
                raise Bad(f"a Shape is a {shape.kind}, and only IndexedFaceSet is read")
        yield from (face_set(shape, to_scene) for shape in below)
        below = []
    elif node.kind == "Inline":
        raise Bad("an Inline names another file")
    else:
        below = []
    for child in below:
        yield from face_sets(child, to_scene)


def read(data):
    """The mesh of a file's bytes, in the file's unit."""
    if not data.startswith(b"#VRML V2.0"):
        raise Bad(f"begins with {data[:10]!r} instead of b'#VRML V2.0'")
    parser = Parser(data.decode("utf-8", "replace"))
    found = [part for node in parser.scene() for part in face_sets(node, IDENTITY)]
    points, indices, n_points = [np.empty((0, 3))], [np.empty(0, np.int64)], 0
    for part_points, part in found:
        points.append(part_points)
        indices.append(np.where(part < 0, -1, part + n_points))
        n_points += len(part_points)
    points, indices = np.concatenate(points), np.concatenate(indices)
    n_corners = np.diff(np.flatnonzero(indices < 0), prepend=-1) - 1
    return Mesh(points, triangulated(points, indices[indices >= 0], n_corners))
