"""What a person would do to get a model: our scan, and what there is without it.

A method is a function of a cell and the numbers of views after which the model is wanted. It yields, for each of them, this
number, the seconds, the model as vertices and triangles in the world of the given poses, and the poses in which its frames
were put together.
"""

import time

import numpy as np
from cell import looking

# A robot's hand moves at a quarter of a metre a second and stands still for half a second for an image.
SPEED_M_PER_S = .25
STILL_S = .5


class Clock:
    """Seconds of the robot, and of the computer as measured."""

    def __init__(self):
        self.seconds, self.position, self.began = 0.0, None, None

    def move(self, pose):
        """The way to a pose, and an image there."""
        position = np.asarray(pose)[:3, 3]
        if self.position is not None:
            self.seconds += np.linalg.norm(position - self.position) / SPEED_M_PER_S
        self.seconds, self.position = self.seconds + STILL_S, position

    def __enter__(self):
        self.began = time.perf_counter()

    def __exit__(self, *_):
        self.seconds += time.perf_counter() - self.began


def even_views(cell, n):
    """n views in three rings on a half sphere around the object, whose place is known."""
    for elevation, count, start in ((20, n // 2, 0.0), (50, n - n // 2 - 1, .3), (80, 1, 0.0)):
        for k in range(count):
            yield looking(cell.center + cell.distance * direction(2 * np.pi * (k + start) / count, np.radians(elevation)), cell.center)


def random_views(cell, n):
    """n views from evenly distributed random places on the half sphere above 10 degrees."""
    for _ in range(n):
        elevation = np.arcsin(cell.rng.uniform(np.sin(np.radians(10)), 1))
        yield looking(cell.center + cell.distance * direction(cell.rng.uniform(0, 2 * np.pi), elevation), cell.center)


def direction(azimuth, elevation):
    """A unit vector."""
    return np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])


def new_scan(cell, first_pose, views):
    """A scan with the defaults."""
    import nextview

    sensor = cell.sensor
    cx, cy = sensor.center_px
    camera = nextview.Camera(sensor.width, sensor.height, fx=sensor.focal_px, fy=sensor.focal_px, cx=cx, cy=cy,
                             depth_range_m=(sensor.least_m, min(sensor.most_m, 3.0)))
    return nextview.Scan(camera, first_pose=first_pose, table="fit", views=views)


def mesh_of(scan):
    """The finished model."""
    mesh = scan.mesh()
    return np.asarray(mesh.vertices), np.asarray(mesh.triangles)


def poses_of(scan, n):
    """The poses of its first frames, aligned where frames are aligned."""
    return [scan.frame(step_idx)[1] for step_idx in range(n)]


def scanned(cell, stages, poses=None):
    """A scan of our own views, or of these; the model after so many views, and at its end."""
    clock, n = Clock(), 0
    requests = iter(poses or ())
    start = looking(cell.center + (cell.distance + .07) * np.array([-.45, .25, .85]), cell.center)
    poses = list(poses or ())
    scan = new_scan(cell, poses[0] if poses else start, len(poses) or 30)
    while True:
        with clock:
            request = next(requests, None) if poses else getattr(scan.next_view(), "world_from_camera", None)
        if request is None:
            break
        clock.move(request)
        depth, given = cell.capture(request)
        with clock:
            scan.observe(depth, world_from_camera=given)
        n += 1
        if n in stages:
            yield n, clock.seconds, mesh_of(scan), poses_of(scan, n)
    if n not in stages:
        yield n, clock.seconds, mesh_of(scan), poses_of(scan, n)


def default(cell, stages):
    """nextview's own views and model, with its defaults. It is told a first pose that looks at the object, nothing else."""
    yield from scanned(cell, stages)


def even(cell, stages):
    """Even views and nextview's model."""
    for n in stages:
        yield from scanned(cell, [n], list(even_views(cell, n)))


def random(cell, stages):
    """Random views and nextview's model."""
    yield from scanned(cell, stages, list(random_views(cell, max(stages))))


def in_open3d(cell, stages, registered):
    """Even views fused by Open3D."""
    for n in stages:
        clock, frames = Clock(), []
        for pose in even_views(cell, n):
            clock.move(pose)
            frames.append(cell.capture(pose))
        with clock:
            frames = aligned(cell, frames) if registered else frames
            model = fused(cell, frames)
        yield n, clock.seconds, model, [pose for _, pose in frames]


def even_open3d(cell, stages):
    """Even views fused by Open3D with the poses as given."""
    yield from in_open3d(cell, stages, registered=False)


def even_multiway(cell, stages):
    """Even views fused by Open3D after its multiway registration."""
    yield from in_open3d(cell, stages, registered=True)


METHODS = {"nextview": default, "even views": even, "random views": random, "even views, Open3D": even_open3d,
           "even views, Open3D multiway": even_multiway}


def fused(cell, frames):
    """The mesh of Open3D's fusion in a grid of voxels, cropped to the object, which the caller knows, without specks."""
    import open3d

    core, sensor = open3d.core, cell.sensor
    voxel = float(np.clip(cell.radius / 50, .001, .003))
    matrix = core.Tensor([[sensor.focal_px, 0, sensor.center_px[0]], [0, sensor.focal_px, sensor.center_px[1]], [0, 0, 1]])
    grid = open3d.t.geometry.VoxelBlockGrid(("tsdf", "weight"), (core.float32, core.float32), ((1), (1)), voxel, 8, 60000)
    low, high = cell.low - .03, cell.high + .03
    for depth, pose in frames:
        image = open3d.t.geometry.Image(np.ascontiguousarray(depth))
        camera_from_world = core.Tensor(np.linalg.inv(pose))
        blocks = grid.compute_unique_block_coordinates(image, matrix, camera_from_world, 1.0, 1.5, 5.0).numpy()
        corners = blocks * voxel * 8
        blocks = blocks[((corners > low - 8 * voxel) & (corners < high)).all(1)]
        if len(blocks):
            grid.integrate(core.Tensor(np.ascontiguousarray(blocks)), image, matrix, camera_from_world, 1.0, 1.5, 5.0)
    mesh = grid.extract_triangle_mesh(2.0).to_legacy()
    low, high = cell.low - .02, cell.high + .02
    low[2] = cell.TABLE_Z + .002
    mesh = mesh.crop(open3d.geometry.AxisAlignedBoundingBox(low, high))
    which, counts, _ = mesh.cluster_connected_triangles()
    which, counts = np.asarray(which), np.asarray(counts)
    if len(counts):
        mesh.remove_triangles_by_mask(counts[which] < max(50, .02 * counts.max()))
        mesh.remove_unreferenced_vertices()
    return np.asarray(mesh.vertices), np.asarray(mesh.triangles)


# Frames that look in directions within this angle of each other are aligned; others show other sides.
MOST_ANGLE = np.radians(75)


def aligned(cell, frames):
    """The frames in the poses that Open3D's multiway registration finds."""
    import open3d

    registration = open3d.pipelines.registration
    clouds = []
    for depth, pose in frames:
        v, u = np.nonzero((depth > 0) & (depth < 1.5))
        points = (cell.rays[v, u] * depth[v, u, None]) @ pose[:3, :3].T + pose[:3, 3]
        points = points[(np.abs(points[:, :2] - cell.PLACE) < cell.radius + .05).all(1)]
        cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points)).voxel_down_sample(.002)
        cloud.estimate_normals(open3d.geometry.KDTreeSearchParamHybrid(.008, 30))
        cloud.orient_normals_towards_camera_location(pose[:3, 3])
        clouds.append(cloud)
    graph = registration.PoseGraph()
    graph.nodes.extend(registration.PoseGraphNode(np.eye(4)) for _ in clouds)
    to_plane = registration.TransformationEstimationPointToPlane()
    for i in range(len(clouds)):
        for j in range(i + 1, len(clouds)):
            if frames[i][1][:3, 2] @ frames[j][1][:3, 2] < np.cos(MOST_ANGLE):
                continue
            motion = np.eye(4)
            for reach in (.015, .004):
                found = registration.registration_icp(clouds[i], clouds[j], reach, motion, to_plane)
                motion = found.transformation
            if found.fitness > .3:
                certainty = registration.get_information_matrix_from_point_clouds(clouds[i], clouds[j], .004, motion)
                graph.edges.append(registration.PoseGraphEdge(i, j, motion, certainty, uncertain=j != i + 1))
    registration.global_optimization(
        graph, registration.GlobalOptimizationLevenbergMarquardt(), registration.GlobalOptimizationConvergenceCriteria(),
        registration.GlobalOptimizationOption(.004, .25, 1.0, 0))
    return [(depth, node.pose @ pose) for (depth, pose), node in zip(frames, graph.nodes)]
