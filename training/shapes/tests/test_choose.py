from dataclasses import dataclass

import numpy as np
import pytest

import choose


@dataclass(frozen=True)
class Package:
    name: str


@dataclass
class Shape:
    package: Package
    category: str
    family: str
    source: str
    signature: np.ndarray


BIG, SMALL = Package("big"), Package("small")


def shapes():
    """Eleven families of five in two categories of one package, three families of one in another."""
    random = np.random.default_rng(5)
    make = lambda package, family, n: Shape(
        package, f"category {family % 2}", f"{package.name} {family}", f"{package.name}{family}-{n}", random.random(7))
    return [make(BIG, family, n) for family in range(11) for n in range(5)] + [make(SMALL, n, 0) for n in range(3)]


@pytest.mark.parametrize(
    ("name", "series", "family"),
    [
        ("PinHeader_2x17_P2.54mm_Vertical", "pin header", "pin header"),
        ("JST_XH_B3B-XH-A_1x03_P2.50mm_Vertical", "xh xh", "xh xh"),
        ("SW_DIP_SPSTx09_Slide_Copal", "sw dip spstx slide copal", "sw dip"),
        ("kitchenKnife2", "kitchen knife", "kitchen knife"),
        ("kitchen-knife", "kitchen knife", "kitchen knife"),
        ("D_5W", "d w", "d w"),
        ("0402", "0402", "0402"),
    ],
)
def test_names_without_numbers(name, series, family):
    assert (choose.series(name), choose.family(name)) == (series, family)


def test_a_family_is_in_one_part_and_a_tenth_is_held_out():
    parts = [choose.part(f"family {n}") for n in range(2000)]
    assert parts == [choose.part(f"family {n}") for n in range(2000)]
    assert 0.08 < parts.count("held_out") / 2000 < 0.12


def test_packages_take_turns_and_second_ones_come_last():
    chosen, others = choose.choose(shapes(), 12)
    assert len(chosen) + len(others) == 58
    assert sum(shape.package is SMALL for shape in chosen) == 3
    families = [shape.family for shape in chosen]
    assert len(set(families)) == 12
    chosen, _ = choose.choose(shapes(), 100)
    assert len(chosen) == 25
    assert max([shape.family for shape in chosen].count(family) for family in families) == choose.MOST_OF_FAMILY


def test_the_order_of_the_shapes_decides_nothing():
    name = lambda found: [shape.source for shape in found[0]]
    assert name(choose.choose(shapes(), 12)) == name(choose.choose(shapes()[::-1], 12))


def test_near_copies_are_left_out_in_all_families():
    copies = shapes()
    for shape in copies:
        shape.signature = np.full(7, 0.3 if shape.package is BIG else 0.31 + 1e-3 * len(shape.source))
    chosen, others = choose.choose(copies, 12)
    assert len(chosen) == 2
    assert sum(why == "near copy" for _, why in others) == 23
