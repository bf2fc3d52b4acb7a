"""The optics of a depth camera."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from nextview import _native

if TYPE_CHECKING:
    from typing_extensions import Self

_KEYS = ("width", "height", "fx", "fy", "cx", "cy", "distortion", "distortion_model", "depth_range_m")


class Camera(_native.Camera):
    """A depth camera: image size, optics in pixels, and the depths that it measures.

    `width` and `height` are the size of its images in pixels, `fx` and `fy` its focal lengths, `cx` and `cy`
    its principal point; a pixel's centre has integer coordinates. `distortion` has up to five coefficients in
    the order k1, k2, p1, p2, k3 of OpenCV; those left out are 0. `distortion_model` is "brown-conrady"
    (OpenCV) or "inverse-brown-conrady" (librealsense). `depth_range_m` are the least and the largest depth
    that is measured; up to the largest, a pixel with infinite depth is free space.

    Raises `InputError` if a number is out of its range. Cameras compare by value and can be pickled.

    >>> import nextview
    >>> camera = nextview.Camera(640, 480, fx=600.0, fy=600.0, cx=320.0, cy=240.0)
    >>> camera.fx, camera.depth_range_m
    (600.0, (0.0, 10.0))
    """

    def __new__(
        cls,
        width: int,
        height: int,
        fx: float,
        fy: float,
        cx: float,
        cy: float,
        distortion: Sequence[float] = (),
        distortion_model: str = "brown-conrady",
        depth_range_m: Sequence[float] = (0.0, 10.0),
    ) -> Self:
        """A camera with these optics."""
        return super().__new__(
            cls, width, height, fx, fy, cx, cy, distortion, distortion_model, depth_range_m
        )

    @classmethod
    def sensor(cls, name: str) -> Camera:
        """The camera of this name, with its published optics and range; see `nextview.sensors`.

        >>> import nextview
        >>> nextview.Camera.sensor("d405").width
        848
        """
        return cls(*_native.Camera.of_sensor(name))

    @property
    def width(self) -> int:
        """Width of the images, pixels."""
        return self.numbers()[0]

    @property
    def height(self) -> int:
        """Height of the images, pixels."""
        return self.numbers()[1]

    @property
    def fx(self) -> float:
        """Focal length along x, pixels."""
        return self.numbers()[2]

    @property
    def fy(self) -> float:
        """Focal length along y, pixels."""
        return self.numbers()[3]

    @property
    def cx(self) -> float:
        """Column of the principal point, pixels, at most 32768 outside the image."""
        return self.numbers()[4]

    @property
    def cy(self) -> float:
        """Row of the principal point, pixels, at most 32768 outside the image."""
        return self.numbers()[5]

    @property
    def distortion(self) -> list[float]:
        """The coefficients k1, k2, p1, p2, k3; empty for an ideal pinhole."""
        return self.numbers()[6]

    @property
    def distortion_model(self) -> str:
        """The model of the lens: "none", "brown-conrady" or "inverse-brown-conrady"."""
        return self.numbers()[7]

    @property
    def depth_range_m(self) -> tuple[float, float]:
        """The least and the largest depth that is measured, metres."""
        return self.numbers()[8]

    def __reduce__(self) -> tuple[Any, ...]:
        """Cameras are pickled as their numbers."""
        return type(self), self.numbers()

    def __eq__(self, other: object) -> bool:
        """Whether all numbers are equal."""
        return isinstance(other, Camera) and self.numbers() == other.numbers()

    def __hash__(self) -> int:
        """Equal cameras have equal hashes."""
        return hash(self.numbers()[:6])

    def __repr__(self) -> str:
        """The call that makes this camera."""
        pairs = zip(_KEYS, self.numbers(), strict=True)
        return f"Camera({', '.join(f'{key}={value!r}' for key, value in pairs)})"
