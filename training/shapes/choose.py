"""Which shapes are taken: families by name, near copies by shape, a choice that is spread, and two parts."""

import hashlib
import re
from collections import Counter

import numpy as np

# At most so many of a family.
MOST_OF_FAMILY = 2
# Shapes whose signatures differ by less than this in every number are near copies.
NEAR = 0.01
# One family of so many is held out.
HELD_OUT_OF = 10

# Words that tell makers, sizes and mountings, not what a thing is.
SAYS_LITTLE = frozenset(
    "mm ep pitch ii iii iv horizontal vertical angled straight left right top side up anode kathode smd tht "
    "thermal vias phoenix contact wuerth mounting molex jst te texas stocko altech samtec".split()
)


def words(name):
    """The words of a file's name: without numbers, single letters and what says little."""
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    found = [word for word in re.findall(r"[a-z]{2,}", spaced.lower()) if word not in SAYS_LITTLE]
    return found or re.findall(r"[a-z]+", name.lower()) or [name]


def series(name):
    """What is the same for all sizes of one thing."""
    return " ".join(words(name))


def family(name):
    """What the things are: the first two words."""
    return " ".join(words(name)[:2])


def digest(*parts):
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def part(of_family):
    is_held_out = int(digest("part", of_family), 16) % HELD_OUT_OF == 0
    return "held_out" if is_held_out else "train"


class Near:
    """Signatures, and whether one is near any of them."""

    def __init__(self):
        self.signatures = []

    def has(self, signature):
        return any((np.abs(other - signature) < NEAR).all() for other in self.signatures)

    def add(self, signature):
        self.signatures.append(signature)


def choose(shapes, count):
    """Up to `count` of the shapes, and of each other one why it is not taken.

    Packages take turns, in each its categories, and in each its families, in the order of hashes: a family's
    second shape comes after the first ones of all others.
    """
    why = []
    queues = {}
    seen = Counter()
    for shape in sorted(shapes, key=lambda shape: digest("order", shape.source)):
        turn = seen[shape.family]
        seen[shape.family] += 1
        if turn >= MOST_OF_FAMILY:
            why.append((shape, "family is full"))
        else:
            queues.setdefault(shape.package, {}).setdefault(shape.category, []).append((turn, shape))
    for categories in queues.values():
        for queue in categories.values():
            queue.sort(key=lambda item: item[0], reverse=True)
    chosen, near = [], Near()
    while queues and len(chosen) < count:
        for package in sorted(queues, key=lambda package: package.name):
            shape = next_shape(queues[package], near, why)
            if shape is None:
                del queues[package]
            elif len(chosen) < count:
                chosen.append(shape)
            else:
                why.append((shape, "not needed"))
    why += [(shape, "not needed") for of in queues.values() for queue in of.values() for _, shape in queue]
    return chosen, why


def next_shape(categories, near, why):
    """The next shape of a package: that of the category whose turn it is, the first in the table."""
    while categories:
        category = next(iter(categories))
        queue = categories.pop(category)
        shape = None
        while queue and shape is None:
            _, shape = queue.pop()
            if near.has(shape.signature):
                why.append((shape, "near copy"))
                shape = None
        if queue:
            categories[category] = queue
        if shape is not None:
            near.add(shape.signature)
            return shape
    return None
