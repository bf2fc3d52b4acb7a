"""Values that no argument expects: wrong, huge, endless, cyclic, lying. Each is made anew by its name."""

from __future__ import annotations

import datetime
import decimal
import fractions
import itertools
import tempfile
import types
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

SHAPE = (6, 8)
"""Height and width of the images of the camera that is used."""


class Raising:
    """Whatever is asked of it raises."""

    def fail(self, *_: Any, **__: Any) -> NoReturn:
        raise RuntimeError("nothing can be asked of this")

    __len__ = __iter__ = __getitem__ = __float__ = __int__ = __index__ = __bool__ = fail
    __array__ = __fspath__ = __str__ = __repr__ = __eq__ = __hash__ = __call__ = fail  # type: ignore[assignment]
    __getattr__ = __contains__ = fail


class Lying:
    """Its answers are of wrong types and sizes."""

    def __len__(self) -> int:
        return 2**62

    def __getitem__(self, _: Any) -> Any:
        return self

    def __iter__(self) -> Any:
        return [1]

    def __float__(self) -> Any:
        return "a number"

    __int__ = __index__ = __fspath__ = __bool__ = __float__

    def __array__(self, *_: Any, **__: Any) -> Any:
        return np.broadcast_to(np.float32(1), (2**20, 2**20))


class Endless:
    """A sequence that states a length and goes on."""

    def __len__(self) -> int:
        return 6

    def __getitem__(self, _: Any) -> float:
        return 0.5

    def __iter__(self) -> Iterator[float]:
        return itertools.repeat(0.5)


class EndlessList(list[float]):
    """A list whose iterator never ends."""

    __iter__ = Endless.__iter__
    __len__ = Lying.__len__


class EndlessDict(dict[str, float]):
    """A dict whose keys never end."""

    def __iter__(self) -> Iterator[str]:
        return map(str, itertools.count())

    def keys(self) -> Any:
        return iter(self)

    def items(self) -> Any:
        return ((key, 1) for key in self)

    def __getitem__(self, _: str) -> float:
        return 1.0


class Text(str):
    """A text by another type."""


class Real(float):
    """A number by another type, which says another one."""

    def __float__(self) -> Any:
        return "a number"


class Changing:
    """A path in a dict, which it changes when it is asked."""

    def __init__(self, of: dict[str, Any]) -> None:
        self.of = of

    def __fspath__(self) -> str:
        self.of.update({str(i): i for i in range(1000)})
        return "here"


class Meta(type):
    """A class that has no name, and nothing else."""

    def __getattribute__(cls, name: str) -> Any:
        raise RuntimeError(f"there is no {name}")


class Nameless(metaclass=Meta):
    """See `Meta`."""


class Array(np.ndarray[Any, Any]):
    """An array whose flags say what is not so."""

    @property
    def flags(self) -> Any:
        return types.SimpleNamespace(aligned=True, writeable=True, c_contiguous=True)

    def tolist(self) -> Any:
        return EndlessList([1.0])


def changing() -> dict[str, Any]:
    """A dict that changes while it is read."""
    values: dict[str, Any] = {}
    values["enabled"] = Changing(values)
    values["theta"] = 1.0
    return values


def cyclic_list(n: int = 1) -> list[Any]:
    """A list that holds itself so often."""
    values: list[Any] = []
    values.extend([values] * n)
    return values


def cyclic_dict() -> dict[str, Any]:
    """A dict that holds itself, by a list."""
    values: dict[str, Any] = {}
    values["a"] = [values, values]
    return values


def nested(wrap: Callable[[Any], Any], n: int) -> Any:
    """A value wrapped so often."""
    value: Any = wrap(0)
    for _ in range(n):
        value = wrap(value)
    return value


def mapped() -> Any:
    """An array in a file."""
    file = tempfile.NamedTemporaryFile(dir=".", delete=False)
    file.write(b"\0" * 4 * SHAPE[0] * SHAPE[1])
    file.flush()
    return np.memmap(file.name, np.float32, "r", shape=SHAPE)


def unaligned(shape: tuple[int, ...], dtype: Any) -> Any:
    """Numbers a byte off where numbers of their size begin."""
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    return np.frombuffer(b"\0" * (size + 1), dtype, offset=1).reshape(shape)


def read_only(array: Any) -> Any:
    """The array, which cannot be written."""
    array.flags.writeable = False
    return array


VALUES: dict[str, Callable[[], Any]] = {
    "None": lambda: None,
    "True": lambda: True,
    "0": lambda: 0,
    "1": lambda: 1,
    "-1": lambda: -1,
    "2^31": lambda: 2**31,
    "2^32": lambda: 2**32,
    "2^63 - 1": lambda: 2**63 - 1,
    "2^63": lambda: 2**63,
    "2^64": lambda: 2**64,
    "-2^64": lambda: -(2**64),
    "10^10000": lambda: 10**10000,
    "0.5": lambda: 0.5,
    "-0.0": lambda: -0.0,
    "nan": lambda: float("nan"),
    "inf": lambda: float("inf"),
    "-inf": lambda: float("-inf"),
    "1e300": lambda: 1e300,
    "-1e300": lambda: -1e300,
    "5e-324": lambda: 5e-324,
    "1e-12": lambda: 1e-12,
    "complex": lambda: 1j,
    "Decimal": lambda: decimal.Decimal("sNaN"),
    "Fraction": lambda: fractions.Fraction(10**400, 3),
    "date": datetime.datetime.now,
    "empty text": lambda: "",
    "text": lambda: "a",
    "nul": lambda: "a\0b",
    "surrogate": lambda: "\ud800",
    "lines": lambda: 'a"\n[b]\r\n\u2028\u202e',
    "1 MB of text": lambda: "x" * 10**6,
    "text of a subclass": lambda: Text("a"),
    "dots": lambda: "python::.",
    "module": lambda: "python:os:path.join",
    "bytes": lambda: b"a\xff",
    "bytearray": lambda: bytearray(100),
    "path": lambda: Path("a"),
    "path with nul": lambda: Path("a\0b"),
    "[]": list,
    "{}": dict,
    "()": tuple,
    "set": lambda: {1, 2},
    "[None]": lambda: [None],
    "[[1], [2, 3]]": lambda: [[1], [2, 3]],
    "[nan] * 6": lambda: [float("nan")] * 6,
    "[1e300] * 3": lambda: [1e300] * 3,
    "[2^70]": lambda: [2**70],
    "texts": lambda: ["a", "b"],
    "{1: 2}": lambda: {1: 2},
    "{'a': None}": lambda: {"a": None},
    "{surrogate}": lambda: {"\ud800": 1},
    "range": lambda: range(2**62),
    "generator": lambda: (i for i in itertools.count()),
    "repeat": lambda: itertools.repeat(0.5),
    "mapping": lambda: types.MappingProxyType({"a": 1}),
    "cyclic list": cyclic_list,
    "list twice in itself": lambda: cyclic_list(2),
    "cyclic dict": cyclic_dict,
    "deep list": lambda: nested(lambda value: [value], 10_000),
    "deep tuple": lambda: nested(lambda value: (value,), 10_000),
    "deep dict": lambda: nested(lambda value: {"a": value}, 10_000),
    "shared list": lambda: nested(lambda value: [value, value], 60),
    "shared dict": lambda: nested(lambda value: {"a": value, "b": value}, 60),
    "10^6 numbers": lambda: [0.0] * 10**6,
    "10^6 lists": lambda: [[]] * 10**6,
    "10^5 keys": lambda: {f"key{i}": i for i in range(10**5)},
    "raising": Raising,
    "lying": Lying,
    "endless": Endless,
    "endless list": lambda: EndlessList([1.0]),
    "endless dict": lambda: EndlessDict(a=1.0),
    "list of endless ones": lambda: [Endless(), Endless()],
    "list of raising ones": lambda: [Raising()] * 6,
    "list of lying ones": lambda: [Lying()] * 6,
    "dict of raising ones": lambda: {"a": Raising()},
    "changing dict": changing,
    "real of a subclass": lambda: Real(1.0),
    "object": object,
    "function": lambda: Raising.fail,
    "class": lambda: Raising,
    "class without name": lambda: Nameless,
    "type": lambda: type,
    "module object": lambda: itertools,
    "float16": lambda: np.float16(1),
    "float32": lambda: np.float32(0.5),
    "float64 nan": lambda: np.float64("nan"),
    "longdouble": lambda: np.longdouble("1e4000"),
    "int64": lambda: np.int64(3),
    "uint64": lambda: np.uint64(2**64 - 1),
    "bool_": lambda: np.bool_(True),
    "str_": lambda: np.str_("a"),
    "datetime64": lambda: np.datetime64("now"),
    "void": lambda: np.zeros(1, [("a", "f4")])[0],
    "dtype": lambda: np.dtype("f4"),
    "0-d": lambda: np.array(0.5),
    "0-d object": lambda: np.array(None),
    "empty": lambda: np.zeros((0,)),
    "0 x 0": lambda: np.zeros((0, 0), np.float32),
    "0 x 4 x 4": lambda: np.zeros((0, 4, 4)),
    "1-d": lambda: np.zeros(6),
    "1-d texts": lambda: np.array(["a", "b"]),
    "2 x 3": lambda: np.array([[-0.1] * 3, [0.1] * 3], np.float16),
    "2 x 3, >f8": lambda: np.array([[-0.1] * 3, [0.1] * 3], ">f8"),
    "2 x 3 of an own class": lambda: np.array([[-0.1] * 3, [0.1] * 3]).view(Array),
    "eye": lambda: np.eye(4),
    "eye, float32": lambda: np.eye(4, dtype=np.float32),
    "eye, >f8": lambda: np.eye(4, dtype=">f8"),
    "eye, object": lambda: np.eye(4).astype(object),
    "eye, complex": lambda: np.eye(4, dtype=complex),
    "eye, strided": lambda: np.eye(8)[::2, ::2].T[::-1, ::-1],
    "eye, masked": lambda: np.ma.MaskedArray(np.eye(4), mask=True),
    "eye, read only": lambda: read_only(np.eye(4)),
    "eye, matrix": lambda: np.asmatrix(np.eye(4)),
    "eye, not aligned, own class": lambda: unaligned((4, 4), np.float64).view(Array),
    "4 x 4, zero stride": lambda: np.broadcast_to(np.float64(1), (4, 4)),
    "4 x 4 of nan": lambda: np.full((4, 4), np.nan),
    "4 x 4 of 1e300": lambda: np.full((4, 4), 1e300),
    "2^40, zero stride, float32": lambda: np.broadcast_to(np.float32(1), (2**20, 2**20)),
    "2^40, zero stride, float64": lambda: np.broadcast_to(np.float64(1), (2**20, 2**20)),
    "2^40, zero stride, uint16": lambda: np.broadcast_to(np.uint16(1), (2**20, 2**20)),
    "2^40, zero stride, bool": lambda: np.broadcast_to(np.bool_(True), (2**20, 2**20)),
    "2^40, zero stride, object": lambda: np.broadcast_to(np.array(None), (2**20, 2**20)),
    "2^40 x 3, zero stride, uint8": lambda: np.broadcast_to(np.uint8(1), (2**20, 2**20, 3)),
    "2^40, 1-d": lambda: np.broadcast_to(np.float64(1), (2**40,)),
    "2^40, 3-d, uint8": lambda: np.broadcast_to(np.uint8(2), (2**10, 2**10, 2**20)),
    "2^40, 3-d, float32": lambda: np.broadcast_to(np.float32(0.9), (2**10, 2**10, 2**20)),
    "2^62 x 0": lambda: np.broadcast_to(np.zeros((0,), np.float32), (2**40, 0)),
    "frame": lambda: np.full(SHAPE, np.inf, np.float32),
    "frame of nan": lambda: np.full(SHAPE, np.nan, np.float32),
    "frame of 1e38": lambda: np.full(SHAPE, 1e38, np.float32),
    "frame below 0": lambda: np.full(SHAPE, -1, np.float32),
    "frame, >f4": lambda: np.zeros(SHAPE, ">f4"),
    "frame, float16": lambda: np.zeros(SHAPE, np.float16),
    "frame, float64": lambda: np.zeros(SHAPE),
    "frame, uint16": lambda: np.full(SHAPE, 65535, np.uint16),
    "frame, >u2": lambda: np.full(SHAPE, 500, ">u2"),
    "frame, object": lambda: np.zeros(SHAPE, object),
    "frame, structured": lambda: np.zeros(SHAPE, [("a", "u1"), ("b", "f4")])["b"],
    "frame, masked": lambda: np.ma.MaskedArray(np.zeros(SHAPE, np.float32), mask=True),
    "frame, strided": lambda: np.zeros((12, 24), np.float32)[::-2, ::-3],
    "frame, zero stride": lambda: np.broadcast_to(np.float32(0.5), SHAPE),
    "frame in a file": mapped,
    "frame, not aligned, own class": lambda: unaligned(SHAPE, np.float32).view(Array),
    "mask": lambda: np.ones(SHAPE, bool),
    "mask, zero stride": lambda: np.broadcast_to(np.bool_(True), SHAPE),
    "mask of bytes beyond 1": lambda: np.full(SHAPE, 7, np.uint8).view(bool),
    "color": lambda: np.zeros((*SHAPE, 3), np.uint8),
    "color, zero stride": lambda: np.broadcast_to(np.uint8(9), (*SHAPE, 3)),
    "color, float32": lambda: np.zeros((*SHAPE, 3), np.float32),
    "2 x 2 x 2, uint8": lambda: np.full((2, 2, 2), 2, np.uint8),
    "2 x 2 x 2, states beyond 2": lambda: np.full((2, 2, 2), 200, np.uint8),
    "2 x 2 x 2, float32": lambda: np.full((2, 2, 2), 0.9, np.float32),
    "2 x 2 x 2, nan": lambda: np.full((2, 2, 2), np.nan, np.float32),
    "list of huge arrays": lambda: [np.broadcast_to(np.float64(1), (2**20, 2**20))] * 6,
    "list of poses": lambda: [np.eye(4)] * 3,
}
