"""A turntable before a camera that stands still."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Turntable:
    """A turntable before a camera that stands still: the views of a scan are then angles.

    The world of the scan is the plate: its origin is the middle of the plate's surface, z is the axis,
    upwards, and it turns with the object. Angles are counter-clockwise, seen from above.

    - `table_from_camera`: where the camera stands, seen from the plate at angle 0: 4 x 4 float64, metres.
    - `plate_radius_m`: radius of the plate. What the camera shows beside it does not turn, and is left out.
    - `angles`: how many angles there are to choose from, evenly around.

    >>> import nextview, numpy as np
    >>> camera = nextview.Camera(640, 480, fx=600.0, fy=600.0, cx=320.0, cy=240.0)
    >>> above = np.array([[1.0, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0.5], [0, 0, 0, 1]])
    >>> table = nextview.Turntable(above, plate_radius_m=0.15, angles=36)
    >>> scan = nextview.Scan(camera, turntable=table)
    >>> scan.next_view().turntable_angle_deg
    0.0
    """

    table_from_camera: NDArray[np.float64]
    plate_radius_m: float
    angles: int = 72

    def _options(self) -> dict[str, Any]:
        return {"view_space": "ring", "candidates": self.angles}
