"""A fixed camera in front of a turntable: the scan requests angles. Here, a simulated one takes its place.

A wall behind the table does not turn, and does not get into the model.
"""

import numpy as np

import nextview

# The object on its plate, whose origin is the middle of its surface: z up.
simulated = nextview.SimulatedScene("builtin:mug", sensor="d435i", object_box={"table": "known"})
lowest, highest = (np.array(corner) for corner in simulated.box_m)
simulated_from_plate = np.eye(4)
simulated_from_plate[:3, 3] = [*(lowest + highest)[:2] / 2, simulated.room_m[0][2]]

# The camera, 45 cm from the axis and 30 cm above the plate, looks at the object: x right, y down, z ahead.
position, middle = np.array([0.45, 0.0, 0.30]), np.array([0.0, 0.0, 0.05])
ahead = (middle - position) / np.linalg.norm(middle - position)
right = np.cross(ahead, [0.0, 0.0, 1.0]) / np.linalg.norm(np.cross(ahead, [0.0, 0.0, 1.0]))
table_from_camera = np.eye(4)
table_from_camera[:3, :3] = np.column_stack([right, np.cross(ahead, right), ahead])
table_from_camera[:3, 3] = position

scan = nextview.Scan(
    simulated.camera,
    turntable={"table_from_camera": table_from_camera, "plate_radius_m": 0.15},
    view_space="ring",
    candidates=72,  # every 5 degrees
    views=8,
    voxel_size_m=0.004,
    name="mug",
)
while (view := scan.next_view()) is not None:
    assert view.turntable_angle_deg is not None
    seen_from = scan.turntable_pose(view.turntable_angle_deg)  # turn the plate here, and wait
    depth = simulated.capture(simulated_from_plate @ seen_from)
    depth[depth > 1.0] = 1.0  # the wall
    step = scan.observe(depth, seen_from)
    print(f"{step['turntable_angle_deg']:5.0f} degrees: {step['new_voxels']} new voxels")

points = scan.cloud().points
farthest = np.linalg.norm(points[:, :2], axis=1).max()
print(f"stopped by {scan.stop_reason}; {len(points)} points, the farthest {farthest:.3f} m from the axis")
assert len(points) > 1000 and farthest < 0.15
assert scan.completeness is not None and scan.completeness > 0.8
