"""Scans an unknown object with your own depth camera; here, a simulated one takes its place.

The scan requests a pose, and the camera reports where it actually is.
"""

import nextview

# A mug on a table before a RealSense D435i with its noise: replace it by your robot and your camera.
robot = nextview.SimulatedScene("builtin:mug", sensor="d435i", object_box={"table": "known"})
here = robot.candidates[0]

scan = nextview.Scan(robot.camera, first_pose=here, table="fit", views=8, name="mug")
while (view := scan.next_view()) is not None:
    depth, world_from_camera = robot.frame(view.world_from_camera)
    step = scan.observe(depth, world_from_camera)
    print(f"view {view.number}: {step['new_voxels']} new voxels, {step['occupied_voxels']} in all")

cloud, mesh = scan.cloud(), scan.mesh()
print(f"stopped by {scan.stop_reason}; {len(cloud.points)} points, {len(mesh.triangles)} triangles")
assert scan.completeness is not None and scan.completeness > 0.7
assert scan.map is not None and (scan.map.occupancy == scan.map.OCCUPIED).sum() > 500
