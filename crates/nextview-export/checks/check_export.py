#!/usr/bin/env python3
"""Opens every export of a scan with its tool, or with a reader of the published format:

    crates/nextview-export/checks/check_export.py target/debug/nextview          # COLMAP, PCL; readers for the rest
    crates/nextview-export/checks/check_export.py target/debug/nextview --full   # Open3D and trimesh, too

Needs numpy, pillow, pycolmap and pypcd4, and with --full open3d and trimesh. A mug is scanned with the noise of a
D435i; its frames are given colours that say where each pixel is, and scanned once more. Depth pixels of the object go
through the exported optics and poses, and must hit the exported model: their median distance must be below the noise,
and their mean offset along its normals a small part of that. Colours must be those of the places they hit.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

FORMATS = ["bop", "colmap", "foundationpose", "nerfstudio", "obj", "open3d", "pcd", "tum"]
# Metres: a pixel's noise of a D435i at 0.5 m, and a tenth of it.
NOISE = 0.001
SHIFT = 0.0001
# Colours run through their range within this length, metres.
PERIOD = 0.25


def main() -> None:
    program, full = sys.argv[1], "--full" in sys.argv[2:]
    with tempfile.TemporaryDirectory(prefix="nextview-export-") as work:
        folder = Path(work)
        scanned = scan(program, folder)
        for format in FORMATS:
            run(program, "export", scanned, "--to", format, "--out", folder / format)
        vertices, normals = model(folder / "scan" / "mesh.ply")
        surface = Surface(vertices, normals)
        for format, views in {
            "bop": bop(folder / "bop"),
            "colmap": colmap(folder / "colmap"),
            "foundationpose": foundationpose(folder / "foundationpose", full),
            "nerfstudio": nerfstudio(folder / "nerfstudio"),
            "open3d": open3d(folder / "open3d", full),
            "tum": tum(folder / "tum"),
        }.items():
            check(format, views, surface)
        pcd(folder / "pcd", folder / "scan", full)
        textured("obj", folder / "obj" / "mesh.obj", full)
        textured("foundationpose", folder / "foundationpose" / "model" / "model.obj", full)
        come_back(program, folder)


def run(*words: object) -> str:
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))}\n{done.stdout}{done.stderr}")
    return done.stdout


def scan(program: str, folder: Path) -> Path:
    """A scan with colours: blue for the background."""
    plain = folder / "plain"
    run(program, "scan", "builtin:mug", "--views", 8, "--noise", "d435i", "--baselines", "off", "--out", plain)
    frames = plain / "frames"
    lens = dict(line.split(maxsplit=1) for line in (frames / "intrinsics.txt").read_text().splitlines())
    unit = float(lens["depth_unit_m"])
    rows = np.genfromtxt(frames / "poses.csv", delimiter=",", names=True)
    (frames / "color").mkdir()
    # Where rays of distorted pixels go is the program's business: it says so itself, as a frame without distortion.
    run(program, "export", plain, "--to", "open3d", "--out", folder / "straight")
    intrinsic = json.loads((folder / "straight" / "intrinsic.json").read_text())
    # The frames of the second scan are those without distortion.
    matrix = np.array(intrinsic["intrinsic_matrix"]).reshape(3, 3).T
    lines = [f"{name} {lens[name]}" for name in ["width", "height", "fx", "fy", "cx", "cy"]]
    (frames / "intrinsics.txt").write_text("\n".join([*lines, "depth_unit_m 0.001"]) + "\n")
    for row in rows:
        stem = f"{int(row['frame']):03}"
        straight = folder / "straight" / "depth" / f"{int(row['frame']):06}.png"
        (frames / "depth" / f"{stem}.png").write_bytes(straight.read_bytes())
        depth = np.asarray(Image.open(straight), dtype=float) * 0.001
        pose = np.array([row[f"world_from_camera_{i // 4}{i % 4}"] for i in range(12)]).reshape(3, 4)
        points = world(depth, matrix, np.vstack([pose, [0, 0, 0, 1]]))
        Image.fromarray(color_at(points)).save(frames / "color" / f"{stem}.png")
    assert unit > 0 and not (frames / "mask").exists()
    scanned = folder / "scan"
    box = "-0.13,-0.13,-0.13,0.13,0.13,0.13"
    run(program, "scan", "--frames", frames, "--box-m", box, "--views", 8, "--out", scanned)
    return scanned


def color_at(points: np.ndarray) -> np.ndarray:
    return (255 * np.clip(points / PERIOD + 0.5, 0, 1)).round().astype(np.uint8)


def world(depth: np.ndarray, matrix: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Points of all pixels; the centre of the first is (0, 0)."""
    v, u = np.mgrid[: depth.shape[0], : depth.shape[1]]
    x, y = (u - matrix[0, 2]) / matrix[0, 0], (v - matrix[1, 2]) / matrix[1, 1]
    return np.stack([x * depth, y * depth, depth], axis=-1) @ pose[:3, :3].T + pose[:3, 3]


def model(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and normals of a PLY as a scan writes it."""
    head, body = path.read_bytes().split(b"end_header\n", 1)
    names = {"float": "<f4", "double": "<f8", "uchar": "u1"}
    columns, count = [], 0
    for line in head.decode().splitlines():
        words = line.split()
        if words[:2] == ["element", "vertex"]:
            count = int(words[2])
        elif words[:2] == ["element", "face"]:
            break
        elif words[0] == "property":
            columns.append((words[2], names[words[1]]))
    table = np.frombuffer(body, np.dtype(columns), count)
    return tuple(np.stack([table[name] for name in axes], axis=-1).astype(float) for axes in ["xyz", ("nx", "ny", "nz")])


class Surface:
    """The model as planes through its vertices."""

    def __init__(self, vertices: np.ndarray, normals: np.ndarray) -> None:
        self.vertices, self.normals = vertices, normals

    def offsets(self, points: np.ndarray) -> np.ndarray:
        """Along the normal of the nearest vertex."""
        nearest = np.empty(len(points), dtype=int)
        squares = (self.vertices**2).sum(axis=1)
        for i in range(0, len(points), 256):
            distances = squares - 2 * points[i : i + 256] @ self.vertices.T
            nearest[i : i + 256] = distances.argmin(axis=1)
        return ((points - self.vertices[nearest]) * self.normals[nearest]).sum(axis=1)


def check(format: str, views: list, surface: Surface) -> None:
    """Views: depth in metres, colours or None, mask or None, matrix of the optics, world from camera."""
    assert len(views) == 8, (format, len(views))
    rng = np.random.default_rng(0)
    offsets, differences, n_masked = [], [], 0
    for depth, color, mask, matrix, pose in views:
        points = world(depth, matrix, pose)
        # Without masks: what lies in the box of the mug, which nothing else does.
        chosen = (depth > 0) & (mask if mask is not None else (np.abs(points) < 0.12).all(axis=-1))
        n_masked += chosen.sum()
        chosen = rng.permutation(np.argwhere(chosen))[:1500]
        offsets.append(surface.offsets(points[tuple(chosen.T)]))
        if color is not None:
            at = tuple(chosen.T)
            differences.append(np.abs(color[at].astype(int) - color_at(points[at]).astype(int)).max(axis=-1))
    offsets = np.concatenate(offsets)
    median, mean = np.median(np.abs(offsets)), offsets[np.abs(offsets) < 5 * NOISE].mean()
    wrong = 100 * np.mean(np.concatenate(differences) > 3)
    print(
        f"{format:15} {n_masked:7} pixels of the object, off by {1e3 * median:.3f} mm (median), "
        f"{1e3 * mean:+.3f} mm (mean along the normal), {wrong:.2f} % of another colour"
    )
    assert n_masked > 50_000 and median < NOISE and abs(mean) < SHIFT and wrong < 0.1, format


def png(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path))


def bop(folder: Path) -> list:
    scene = folder / "train" / "000001"
    cameras, poses, infos = (json.loads((scene / f"scene_{name}.json").read_text()) for name in ["camera", "gt", "gt_info"])
    views = []
    for number, camera in cameras.items():
        stem = f"{int(number):06}"
        [pose], [info] = poses[number], infos[number]
        assert pose["obj_id"] == 1
        camera_from_model = np.eye(4)
        camera_from_model[:3, :3] = np.reshape(pose["cam_R_m2c"], (3, 3))
        camera_from_model[:3, 3] = np.array(pose["cam_t_m2c"]) / 1e3
        depth = png(scene / "depth" / f"{stem}.png") * camera["depth_scale"] / 1e3
        mask = png(scene / "mask_visib" / f"{stem}_000000.png") > 0
        whole = png(scene / "mask" / f"{stem}_000000.png") > 0
        rows, columns = np.nonzero(whole)
        x, y, width, height = info["bbox_obj"]
        assert [columns.min(), rows.min(), columns.max() - x + 1, rows.max() - y + 1] == [x, y, width, height]
        assert info["px_count_all"] == whole.sum() and info["px_count_visib"] == mask.sum()
        assert info["px_count_valid"] == (whole & (depth > 0)).sum()
        matrix = np.reshape(camera["cam_K"], (3, 3))
        views.append((depth, png(scene / "rgb" / f"{stem}.png"), mask, matrix, np.linalg.inv(camera_from_model)))
    vertices, _ = model(folder / "models" / "obj_000001.ply")
    info = json.loads((folder / "models" / "models_info.json").read_text())["1"]
    low, size = vertices.min(axis=0), np.ptp(vertices, axis=0)
    assert np.allclose(low, [info[f"min_{axis}"] for axis in "xyz"], atol=1e-3)
    assert np.allclose(size, [info[f"size_{axis}"] for axis in "xyz"], atol=1e-3)
    assert 150 < info["diameter"] < 300, info
    return views


def colmap(folder: Path) -> list:
    import pycolmap

    views = []
    for read in ["read_text", "read_binary"]:
        model = pycolmap.Reconstruction()
        getattr(model, read)(folder / "sparse" / "0")
        [camera] = model.cameras.values()
        assert camera.model_name == "PINHOLE" and model.num_points3D() > 500, model.summary()
        n_seen = 0
        for image in model.images.values():
            for point in image.points2D:
                position = model.points3D[point.point3D_id].xyz
                assert np.linalg.norm(camera.img_from_cam(image.cam_from_world() * position) - point.xy) < 1e-6
                n_seen += 1
        assert n_seen == model.compute_num_observations()
        fx, fy, cx, cy = camera.params
        # There, the centre of the first pixel is (0.5, 0.5).
        matrix = np.array([[fx, 0, cx - 0.5], [0, fy, cy - 0.5], [0, 0, 1]])
        views = []
        for _, image in sorted(model.images.items()):
            pose = np.vstack([image.cam_from_world().inverse().matrix(), [0, 0, 0, 1]])
            color = png(folder / "images" / image.name)
            mask = png(folder / "masks" / f"{image.name}.png") > 0
            # It has no depth images; those of another export have the same names.
            depth = png(folder.parent / "open3d" / "depth" / image.name) * 0.001
            views.append((depth, color, mask, matrix, pose))
    return views


def foundationpose(folder: Path, full: bool) -> list:
    matrix = np.loadtxt(folder / "K.txt")
    views = []
    for path in sorted((folder / "rgb").glob("*.png")):
        # As its training of a neural object field finds them.
        at = lambda name, end: Path(str(path).replace("/rgb/", f"/{name}/")).with_suffix(end)
        depth = png(at("depth_enhanced", ".png")) / 1e3
        assert (depth == png(at("depth", ".png")) / 1e3).all() and (png(at("mask", ".png")) == png(at("masks", ".png"))).all()
        pose = np.loadtxt(at("cam_in_ob", ".txt")).reshape(4, 4)
        views.append((depth, png(path), png(at("mask", ".png")) > 0, matrix, pose))
    return views


def textured(format: str, path: Path, full: bool) -> None:
    """Every point of the mesh has, in the texture, the colour that says where it is."""
    rows = [line.split() for line in path.read_text().splitlines()]
    named = lambda word: [row[1:] for row in rows if row[0] == word]
    material = [line.split() for line in path.with_suffix(".mtl").read_text().splitlines()]
    assert named("mtllib") == [[path.with_suffix(".mtl").name]] and ["newmtl", *named("usemtl")[0]] in material
    image = png(path.parent / next(row[1] for row in material if row[0] == "map_Kd")).astype(float)
    vertices, points = (np.array(named(word), dtype=float) for word in ("v", "vt"))
    faces = np.array([[corner.split("/") for corner in face] for face in named("f")], dtype=int) - 1
    rng = np.random.default_rng(0)
    faces = faces[rng.integers(len(faces), size=20000)]
    weights = rng.dirichlet([1, 1, 1], size=len(faces))[..., None]
    at, uv = ((weights * of[faces[..., k]]).sum(axis=1) for k, of in enumerate([vertices, points]))
    height, width = image.shape[:2]
    u, v = uv[:, 0] * width - 0.5, (1 - uv[:, 1]) * height - 0.5
    left, top = (np.clip(np.floor(x).astype(int), 0, n - 2) for x, n in [(u, width), (v, height)])
    s, t = (u - left)[:, None], (v - top)[:, None]
    upper = (1 - s) * image[top, left] + s * image[top, left + 1]
    lower = (1 - s) * image[top + 1, left] + s * image[top + 1, left + 1]
    differences = np.abs((1 - t) * upper + t * lower - color_at(at)).max(axis=1)
    assert len(vertices) > 1000 and (np.abs(vertices) < 0.13).all()
    # A colour changes by 1 within a millimetre.
    assert np.median(differences) <= 1.5 and (differences > 8).mean() < 0.02, (np.median(differences), differences)
    if full:
        import trimesh

        mesh = trimesh.load(path, force="mesh", process=False)
        assert mesh.visual.material.image.size == (width, height) and len(mesh.faces) == len(named("f"))
    print(f"{format}: the texture has the colour of its place within {np.median(differences):.2f} of 255 in the median")


def nerfstudio(folder: Path) -> list:
    transforms = json.loads((folder / "transforms.json").read_text())
    assert transforms["camera_model"] == "OPENCV" and not any(transforms[k] for k in ["k1", "k2", "p1", "p2"])
    matrix = np.array(
        [[transforms["fl_x"], 0, transforms["cx"] - 0.5], [0, transforms["fl_y"], transforms["cy"] - 0.5], [0, 0, 1]]
    )
    views = []
    for frame in transforms["frames"]:
        # OpenGL axes: y up, z backward.
        pose = np.array(frame["transform_matrix"]) @ np.diag([1, -1, -1, 1])
        depth = png(folder / frame["depth_file_path"]) * 0.001
        views.append((depth, png(folder / frame["file_path"]), png(folder / frame["mask_path"]) > 0, matrix, pose))
    assert len(model(folder / transforms["ply_file_path"])[0]) > 1000
    return views


def open3d(folder: Path, full: bool) -> list:
    columns = lambda numbers, n: np.reshape(numbers, (n, n)).T
    trajectory = json.loads((folder / "camera_trajectory.json").read_text())
    log = (folder / "trajectory.log").read_text().split("\n")
    views = []
    for i, (parameters, path) in enumerate(zip(trajectory["parameters"], sorted((folder / "color").glob("*.png")))):
        pose = np.linalg.inv(columns(parameters["extrinsic"], 4))
        assert log[5 * i] == f"{i} {i} {i + 1}"
        assert np.allclose(np.loadtxt(log[5 * i + 1 : 5 * i + 5]), pose, atol=1e-9)
        matrix = columns(parameters["intrinsic"]["intrinsic_matrix"], 3)
        views.append((png(folder / "depth" / path.name) * 0.001, png(path), None, matrix, pose))
    if full:
        import open3d as o3d

        intrinsic = o3d.io.read_pinhole_camera_intrinsic(str(folder / "intrinsic.json"))
        assert np.allclose(intrinsic.intrinsic_matrix, views[0][3])
        for name in ["camera_trajectory.json", "trajectory.log"]:
            read = o3d.io.read_pinhole_camera_trajectory(str(folder / name)).parameters
            assert len(read) == len(views)
            for parameters, (_, _, _, _, pose) in zip(read, views):
                assert np.allclose(parameters.extrinsic, np.linalg.inv(pose), atol=1e-7), name
        first = sorted((folder / "color").glob("*.png"))[0]
        images = [o3d.io.read_image(str(folder / kind / first.name)) for kind in ["color", "depth"]]
        rgbd = o3d.geometry.RGBDImage.create_from_color_and_depth(*images, depth_trunc=65.0, convert_rgb_to_intensity=False)
        cloud = o3d.geometry.PointCloud.create_from_rgbd_image(rgbd, intrinsic, np.linalg.inv(views[0][4]))
        ours = world(views[0][0], views[0][3], views[0][4])[views[0][0] > 0]
        assert len(cloud.points) == (views[0][0] > 0).sum()
        assert np.abs(np.asarray(cloud.points) - ours).max() < 1e-5
    return views


def tum(folder: Path) -> list:
    lens = dict(line.split(maxsplit=1) for line in (folder / "intrinsics.txt").read_text().splitlines())
    matrix = np.array([[float(lens["fx"]), 0, float(lens["cx"])], [0, float(lens["fy"]), float(lens["cy"])], [0, 0, 1]])
    lists = [dict(line.split() for line in (folder / f"{name}.txt").read_text().splitlines()[1:]) for name in ["depth", "rgb"]]
    views = []
    for line in (folder / "groundtruth.txt").read_text().splitlines()[1:]:
        time, *numbers = line.split()
        x, y, z, qx, qy, qz, qw = map(float, numbers)
        pose = np.eye(4)
        pose[:3, :3] = [
            [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qz * qw), 2 * (qx * qz + qy * qw)],
            [2 * (qx * qy + qz * qw), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qx * qw)],
            [2 * (qx * qz - qy * qw), 2 * (qy * qz + qx * qw), 1 - 2 * (qx * qx + qy * qy)],
        ]
        pose[:3, 3] = [x, y, z]
        views.append((png(folder / lists[0][time]) / 5000, png(folder / lists[1][time]), None, matrix, pose))
    return views


def pcd(folder: Path, scanned: Path, full: bool) -> None:
    from pypcd4 import PointCloud

    cloud = PointCloud.from_path(folder / "cloud.pcd")
    points, normals = model(scanned / "cloud.ply")
    assert np.allclose(cloud.numpy(("x", "y", "z")), points, atol=1e-7)
    red, green, blue = PointCloud.decode_rgb(cloud.numpy(("rgb",))[:, 0]).T.astype(int)
    expected = color_at(points)
    near = np.abs(np.stack([red, green, blue], axis=-1) - expected.astype(int)).max(axis=1)
    assert np.mean(near > 8) < 0.01, np.mean(near > 8)
    if full:
        import open3d as o3d

        read = o3d.io.read_point_cloud(str(folder / "cloud.pcd"))
        assert len(read.points) == len(points) and read.has_colors() and read.has_normals()
        known = np.linalg.norm(normals, axis=1) > 0.5
        assert np.allclose(np.asarray(read.normals)[known], normals[known], atol=1e-6)
    print(f"{'pcd':15} {len(points):7} points")


def come_back(program: str, folder: Path) -> None:
    """The exported sequence as a recording, and the frames of the results."""
    box = "-0.13,-0.13,-0.13,0.13,0.13,0.13"
    clouds = []
    for name, frames in [("back", folder / "tum"), ("again", folder / "scan" / "frames")]:
        words = ["--frames", frames, "--box-m", box, "--views", 8, "--planner", "in-order", "--out", folder / name]
        run(program, "scan", *words)
        clouds.append(model(folder / name / "cloud.ply")[0])
    counts = [len(cloud) for cloud in [model(folder / "scan" / "cloud.ply")[0], *clouds]]
    print(f"{'scanned again':15} {counts[0]} points; from the TUM sequence {counts[1]}, from the results {counts[2]}")
    assert all(abs(count - counts[0]) < 0.01 * counts[0] for count in counts)


if __name__ == "__main__":
    main()
