"""Where should a depth camera look next, so that an unknown object is scanned completely in as few views as
possible?

Start with `Scan`, a scan by your own camera, or `scan`, a simulated one of a mesh:

>>> import nextview
>>> done = nextview.scan("builtin:mug", views=3, voxel_size_m=0.01, baselines=False)
>>> len(done.record["steps"])
3

Lengths are in metres, angles in radians where no name says otherwise. Transforms are named destination first:
`world_from_camera` takes points of the camera to the world. A camera looks along its z axis, x points right
and y down, as in OpenCV. A depth is the distance along z.
"""

from nextview import errors
from nextview._bench import Bench, bench
from nextview._camera import Camera
from nextview._export import Exported, export
from nextview._model import Cloud, Map, Mesh
from nextview._names import builtin_objects, planners, sensors
from nextview._native import View, __version__
from nextview._page import Page
from nextview._planner import Gain, Planner, Rays, Situation
from nextview._scan import Scan, resume
from nextview._simulated import ScanResult, SimulatedScene, scan
from nextview.errors import DataError, InputError, InternalError, NextviewError

__all__ = [
    "Bench",
    "Camera",
    "Cloud",
    "DataError",
    "Exported",
    "Gain",
    "InputError",
    "InternalError",
    "Map",
    "Mesh",
    "NextviewError",
    "Page",
    "Planner",
    "Rays",
    "Scan",
    "ScanResult",
    "SimulatedScene",
    "Situation",
    "View",
    "__version__",
    "bench",
    "builtin_objects",
    "errors",
    "export",
    "planners",
    "resume",
    "scan",
    "sensors",
]
