"""Clouds, meshes and poses in Open3D, trimesh, PyTorch and SciPy, without conversions before."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import nextview


@pytest.fixture(scope="module")
def done() -> nextview.ScanResult:
    """A scanned mug."""
    return nextview.scan("builtin:mug", views=6, candidates=60, baselines=False, model={"watertight": True})


def test_open3d_takes_cloud_and_mesh(done: nextview.ScanResult, tmp_path: Path) -> None:
    o3d = pytest.importorskip("open3d")
    assert done.cloud is not None and done.mesh is not None
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(done.cloud.points))
    cloud.normals = o3d.utility.Vector3dVector(done.cloud.normals)
    np.testing.assert_array_equal(np.asarray(cloud.points), done.cloud.points)
    mesh = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(done.mesh.vertices),
        o3d.utility.Vector3iVector(done.mesh.triangles.view(np.int32)),
    )
    assert mesh.is_watertight() and mesh.is_vertex_manifold()
    # Cloud and mesh are of one object.
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(o3d.t.geometry.TriangleMesh.from_legacy(mesh))
    distance = scene.compute_distance(done.cloud.points.astype(np.float32)).numpy()
    assert np.percentile(distance, 95) < 0.002
    tensor = o3d.t.geometry.PointCloud(o3d.core.Tensor.from_numpy(done.cloud.points))
    assert len(tensor.point.positions) == len(done.cloud.points)


def test_open3d_makes_the_same_points_of_a_frame() -> None:
    o3d = pytest.importorskip("open3d")
    sim = nextview.SimulatedScene("builtin:mug", voxel_size_m=0.005, candidates=10)
    scan = nextview.Scan(sim.camera, sim.box_m, poses=sim.candidates, views=1, voxel_size_m=0.005)
    view = scan.next_view()
    assert view is not None
    depth = sim.capture(view)
    scan.observe(depth, view)
    camera = sim.camera
    optics = o3d.camera.PinholeCameraIntrinsic(
        camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy
    )
    image = o3d.geometry.Image(np.where(np.isfinite(depth), depth, 0).astype(np.float32))
    camera_from_world = np.linalg.inv(view.world_from_camera)
    theirs = o3d.geometry.PointCloud.create_from_depth_image(
        image, optics, camera_from_world, depth_scale=1.0, depth_trunc=10.0
    )
    low, high = np.asarray(sim.box_m)
    points = np.asarray(theirs.points)
    points = points[((points > low) & (points < high)).all(axis=1)]
    found = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    ours = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(scan.cloud().points))
    assert np.asarray(ours.compute_point_cloud_distance(found)).max() < 2e-3


def test_trimesh_takes_the_mesh(done: nextview.ScanResult, tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    assert done.mesh is not None
    mesh = trimesh.Trimesh(done.mesh.vertices, done.mesh.triangles, process=False)
    assert mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0
    mesh.export(tmp_path / "mug.stl")
    again = nextview.scan(tmp_path / "mug.stl", unit="m", views=2, candidates=20, baselines=False)
    assert again.record["views"] == 2


def test_pytorch_shares_the_memory(done: nextview.ScanResult) -> None:
    torch = pytest.importorskip("torch")
    assert done.cloud is not None and done.mesh is not None and done.map is not None
    for array in (done.cloud.points, done.mesh.vertices, done.map.occupancy, done.map.probability):
        tensor = torch.from_numpy(array)
        assert tuple(tensor.shape) == array.shape and tensor.data_ptr() == array.ctypes.data
    grid = torch.from_numpy(done.map.occupancy)
    assert int((grid == nextview.Map.OCCUPIED).sum()) == done.record["steps"][-1]["occupied_voxels"]


def test_depths_of_pytorch_are_observed() -> None:
    torch = pytest.importorskip("torch")
    sim = nextview.SimulatedScene("builtin:mug", voxel_size_m=0.01, candidates=10)
    scan = nextview.Scan(sim.camera, sim.box_m, poses=sim.candidates, views=1, voxel_size_m=0.01)
    view = scan.next_view()
    assert view is not None
    depth, pose = torch.from_numpy(sim.capture(view)), torch.from_numpy(view.world_from_camera)
    step = scan.observe(depth.numpy(), pose.numpy())
    assert step["hit_voxels"] > 50


def test_scipy_rotations_are_poses(done: nextview.ScanResult) -> None:
    transform = pytest.importorskip("scipy.spatial.transform")
    sim = nextview.SimulatedScene("builtin:mug", voxel_size_m=0.01, candidates=10)
    scan = nextview.Scan(sim.camera, sim.box_m, poses=sim.candidates, views=2, voxel_size_m=0.01)
    view = scan.next_view()
    assert view is not None
    pose = np.eye(4)
    rotation = transform.Rotation.from_matrix(view.world_from_camera[:3, :3])
    pose[:3, :3], pose[:3, 3] = rotation.as_matrix(), view.world_from_camera[:3, 3]
    step = scan.observe(sim.capture(view), pose)
    turned = rotation * transform.Rotation.from_quat(step["quaternion_xyzw"]).inv()
    assert turned.magnitude() < 1e-7
