"""Scans with a RealSense camera through pyrealsense2.

Without a camera, the SDK's own software device stands in for it, and a simulated mug for the object: with
yours, take `sensor` from `rs.context().query_devices()[0].first_depth_sensor()`, and write `move_to`.
"""

import sys

import numpy as np
from numpy.typing import NDArray

import nextview

try:
    import pyrealsense2 as rs
except ImportError as missing:
    print(f"SKIPPED 03_realsense: {missing}; it is installed by: pip install pyrealsense2")
    sys.exit()

UNITS_M = 0.0005
sim = nextview.SimulatedScene("builtin:mug", sensor="d435i", object_box={"table": "known"})


def software_sensor() -> tuple[rs.software_device, rs.software_sensor]:
    """A depth sensor of the SDK with the optics of the simulated camera."""
    optics = rs.intrinsics()
    optics.width, optics.height = sim.camera.width, sim.camera.height
    optics.fx, optics.fy, optics.ppx, optics.ppy = sim.camera.fx, sim.camera.fy, sim.camera.cx, sim.camera.cy
    optics.model, optics.coeffs = rs.distortion.brown_conrady, [0.0] * 5
    stream = rs.video_stream()
    stream.type, stream.fmt, stream.index, stream.uid = rs.stream.depth, rs.format.z16, 0, 1
    stream.width, stream.height, stream.fps, stream.bpp = optics.width, optics.height, 30, 2
    stream.intrinsics = optics
    device = rs.software_device()
    sensor = device.add_sensor("Stereo Module")
    sensor.add_read_only_option(rs.option.depth_units, UNITS_M)
    sensor.add_video_stream(stream)
    return device, sensor


def move_to(world_from_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """Moves the robot; returns where the camera truly is. This one then has the sensor see the mug."""
    depth, reached = sim.frame(world_from_camera)
    frame = rs.software_video_frame()
    frame.pixels = np.where(np.isfinite(depth), np.round(depth / UNITS_M), 0).astype(np.uint16)
    frame.bpp, frame.stride, frame.depth_units = 2, 2 * depth.shape[1], UNITS_M
    frame.profile = profile
    frame.frame_number = frame.timestamp = len(scan.steps) + 1
    sensor.on_video_frame(frame)
    return reached


device, sensor = software_sensor()
profile = sensor.get_stream_profiles()[0].as_video_stream_profile()
frames = rs.frame_queue(1)
sensor.open(profile)
sensor.start(frames)

optics = profile.get_intrinsics()
camera = nextview.Camera(
    optics.width,
    optics.height,
    fx=optics.fx,
    fy=optics.fy,
    cx=optics.ppx,
    cy=optics.ppy,
    distortion=optics.coeffs if any(optics.coeffs) else [],
    distortion_model=optics.model.name.replace("_", "-"),
    depth_range_m=nextview.Camera.sensor("d435i").depth_range_m,
)
scan = nextview.Scan(camera, first_pose=sim.candidates[0], table="fit", views=8, name="mug")
while (view := scan.next_view()) is not None:
    world_from_camera = move_to(view.world_from_camera)
    image = frames.wait_for_frame().as_depth_frame()
    depth = np.asanyarray(image.get_data())
    step = scan.observe(depth, world_from_camera, depth_scale_m=image.get_units())
    print(f"view {view.number}: {step['occupied_voxels']} occupied voxels")
sensor.stop()
sensor.close()

points = scan.cloud().points
print(f"stopped by {scan.stop_reason}; {len(points)} points")
assert scan.completeness is not None and scan.completeness > 0.7
low, high = np.asarray(sim.box_m)
assert ((points > low - 0.01) & (points < high + 0.01)).all(axis=1).mean() > 0.9
