#!/usr/bin/env python3
"""Times Open3D and small_gicp on a workload: packages.py WORKLOAD PACKAGE

Prints lines PEER,STAGE,CASE,MILLISECONDS: the minimum CPU time of several runs with one thread. Needs numpy and the package.
"""

import os

os.environ["OMP_NUM_THREADS"] = "1"

import pathlib
import sys
import tempfile
import time

import numpy

# As in benchmarks/src: the camera, the box, the cells of the model, and the search distance of an alignment.
WIDTH, HEIGHT, FOCAL, CENTER = 640, 480, 610.0, (320.0, 240.0)
CELL = 0.002
REACH = 0.01
N_IMAGES = 10


def least_ms(work, min_runs=3):
    """Minimum CPU time of several runs, milliseconds; of one run with the variable QUICK."""
    least, spent, runs = float("inf"), 0.0, 0
    quick = "QUICK" in os.environ
    while runs < (1 if quick else min_runs) or (spent < 0.5 and not quick):
        start = time.process_time()
        work()
        seconds = time.process_time() - start
        least, spent, runs = min(least, seconds), spent + seconds, runs + 1
    return 1e3 * least


def report(peer, stage, case, work):
    print(f"{peer},{stage},{case},{least_ms(work):.4f}", flush=True)


def surface(path):
    """Points and normals."""
    numbers = numpy.fromfile(path, dtype="<f4").reshape(-1, 6).astype(float)
    return numbers[:, :3], numbers[:, 3:]


def poses(path):
    return numpy.fromfile(path, dtype="<f8").reshape(-1, 4, 4)


def open3d_stages(workload):
    import open3d

    open3d.utility.set_verbosity_level(open3d.utility.VerbosityLevel.Error)
    tensor = open3d.core.Tensor
    optics = tensor([[FOCAL, 0, CENTER[0]], [0, FOCAL, CENTER[1]], [0, 0, 1]], dtype=open3d.core.float64)
    images = []
    for i, world_from_camera in enumerate(poses(workload / "poses.f64")):
        depth = numpy.fromfile(workload / f"depth_{i}.f32", dtype="<f4").reshape(HEIGHT, WIDTH, 1)
        images.append((open3d.t.geometry.Image(tensor(depth)), tensor(numpy.linalg.inv(world_from_camera))))
    assert len(images) == N_IMAGES

    def fused():
        columns = {"attr_names": ("tsdf", "weight"), "attr_dtypes": (open3d.core.float32,) * 2, "attr_channels": ((1), (1))}
        grid = open3d.t.geometry.VoxelBlockGrid(voxel_size=CELL, block_resolution=16, block_count=10000, **columns)
        for depth, camera_from_world in images:
            where = (depth, optics, camera_from_world, 1.0, 10.0, 2.0)
            grid.integrate(grid.compute_unique_block_coordinates(*where), *where)
        return grid

    grid = fused()
    mesh = lambda: grid.extract_triangle_mesh(weight_threshold=0.5)
    assert len(mesh().vertex.positions) > 1000
    report("open3d", "fuse ten images", "2 mm", fused)
    report("open3d", "mesh of the fused images", "2 mm", mesh)

    target, source = open3d.geometry.PointCloud(), open3d.geometry.PointCloud()
    for cloud, name in [(target, "known.f32"), (source, "points.f32")]:
        points, normals = surface(workload / name)
        cloud.points, cloud.normals = map(open3d.utility.Vector3dVector, (points, normals))
    motion = poses(workload / "motion.f64")[0]
    registration = open3d.pipelines.registration
    to_plane = registration.TransformationEstimationPointToPlane()
    align = lambda: registration.registration_icp(source, target, REACH, motion, to_plane)
    say_error("open3d", align().transformation)
    report("open3d", "align an image", "2 mm", align)

    depth = open3d.io.read_image(str(workload / "depth.png"))
    assert numpy.asarray(depth).dtype == numpy.uint16
    mesh = open3d.io.read_triangle_mesh(str(workload / "mesh2.ply"))
    with tempfile.TemporaryDirectory(prefix="nextview-peer-") as folder:
        report("open3d", "write depth PNG", "640 x 480", lambda: open3d.io.write_image(f"{folder}/depth.png", depth))
        report("open3d", "read depth PNG", "640 x 480", lambda: open3d.io.read_image(str(workload / "depth.png")))
        report("open3d", "write PLY", "16x", lambda: open3d.io.write_triangle_mesh(f"{folder}/mesh.ply", mesh))
        report("open3d", "read PLY", "16x", lambda: open3d.io.read_triangle_mesh(str(workload / "mesh2.ply")))


def small_gicp_stages(workload):
    import small_gicp

    clouds = []
    for name in ["known.f32", "points.f32"]:
        points, _ = surface(workload / name)  # it computes normals of its own
        cloud = small_gicp.PointCloud(points)
        tree = small_gicp.KdTree(cloud, num_threads=1)
        small_gicp.estimate_normals_covariances(cloud, tree, num_neighbors=10, num_threads=1)
        clouds.append((cloud, tree))
    (target, tree), (source, _) = clouds
    motion = poses(workload / "motion.f64")[0]
    options = {"registration_type": "PLANE_ICP", "max_correspondence_distance": REACH, "num_threads": 1}
    align = lambda: small_gicp.align(target, source, tree, motion, **options)
    say_error("small_gicp", align().T_target_source)
    report("small_gicp", "align an image", "2 mm", align)


def say_error(what, motion):
    degrees = numpy.degrees(numpy.arccos(numpy.clip((numpy.trace(motion[:3, :3]) - 1) / 2, -1, 1)))
    print(f"{what}: off by {1e3 * numpy.linalg.norm(motion[:3, 3]):.3f} mm, {degrees:.3f} degrees", file=sys.stderr)


if __name__ == "__main__":
    {"open3d": open3d_stages, "small_gicp": small_gicp_stages}[sys.argv[2]](pathlib.Path(sys.argv[1]))
