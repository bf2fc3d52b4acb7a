#!/usr/bin/env python3
"""Arms in front of objects on a table: the share seen of the reachable surface, checked with another library.

    benchmarks/robots/robots.py target/release/nextview OUT MESH ...      # meshes in metres or millimetres, unit guessed

Every object is scanned with a D435i by a UR5e and a KUKA KR 6 R900 in ten views, and again with reach as a sphere
alone, whose views are then tried with the arm. Pinocchio (PyPI `pin`) reads the same URDF, and coal the true mesh: the
joints of every view must bring the camera there, and on the way the arm and its camera must touch neither object nor
table nor another part of the arm. Needs `pin`, `numpy` and `trimesh`. OUT/robots.md has the tables.
"""

import argparse
import csv
import json
import pathlib
import shutil
import statistics
import subprocess

import coal
import numpy as np
import pinocchio
import trimesh

HERE = pathlib.Path(__file__).resolve().parent
PRESETS = HERE / "../../crates/nextview-robot/presets"
ARMS = {"ur5e": 0.85, "kr6_r900": 0.9}
DISTANCE_M = 0.5
CAMERA_BODY = ((-0.045, -0.0125, -0.025), (0.045, 0.0125, 0.0))
STEP_RAD = 0.01


def mesh_in_metres(path):
    mesh = trimesh.load(path, force="mesh")
    if mesh.extents.max() >= 20.0:
        mesh.apply_scale(1e-3)
    return mesh


class Cell:
    """An arm, its camera, the table and the object, as Pinocchio and coal know them."""

    def __init__(self, arm, base, mesh):
        urdf = str(PRESETS / f"{arm}.urdf")
        self.model = pinocchio.buildModelFromUrdf(urdf)
        self.solids = pinocchio.buildGeomFromUrdf(self.model, urdf, pinocchio.GeometryType.COLLISION)
        self.tool = self.model.getFrameId("tool0")
        self.base = np.array(base)
        frame = self.model.frames[self.tool]
        low, high = (np.array(corner) for corner in CAMERA_BODY)
        place = frame.placement * pinocchio.SE3(np.eye(3), (low + high) / 2)
        camera = pinocchio.GeometryObject("camera", frame.parentJoint, place, coal.Box(*(high - low)))
        own = list(range(self.solids.ngeoms)) + [self.solids.addGeometryObject(camera)]
        moving = [i for i in own if self.solids.geometryObjects[i].parentJoint > 0]
        table = coal.Box(4.0, 4.0, 1.0)
        under = pinocchio.SE3(np.eye(3), np.array([0.0, 0.0, -0.5]))
        others = [self.solids.addGeometryObject(pinocchio.GeometryObject("table", 0, under, table))]
        shape = coal.BVHModelOBBRSS()
        shape.beginModel(len(mesh.faces), len(mesh.vertices))
        shape.addVertices(mesh.vertices - self.base)
        for face in mesh.vertices[mesh.faces] - self.base:
            shape.addTriangle(*face)
        shape.endModel()
        there = pinocchio.GeometryObject("object", 0, pinocchio.SE3.Identity(), shape)
        others.append(self.solids.addGeometryObject(there))
        for i in moving:
            for other in others:
                self.solids.addCollisionPair(pinocchio.CollisionPair(i, other))
        # Links that are neighbours touch at their joint.
        for a in own:
            for b in own:
                joints = [self.solids.geometryObjects[i].parentJoint for i in (a, b)]
                if joints[1] - joints[0] >= 2:
                    self.solids.addCollisionPair(pinocchio.CollisionPair(a, b))
        self.data = self.model.createData()
        self.solid_data = pinocchio.GeometryData(self.solids)

    def touches(self, values):
        pinocchio.updateGeometryPlacements(self.model, self.data, self.solids, self.solid_data, values)
        return pinocchio.computeCollisions(self.solids, self.solid_data, True)

    def camera(self, values):
        pinocchio.framesForwardKinematics(self.model, self.data, values)
        place = self.data.oMf[self.tool]
        return place.translation + self.base, place.rotation

    def reaches(self, position, rotation, rng):
        """Whether there are joint values without contact, by damped least squares from forty seeds."""
        wanted = pinocchio.SE3(rotation, position - self.base)
        low, high = self.model.lowerPositionLimit, self.model.upperPositionLimit
        for _ in range(40):
            values = rng.uniform(low, high)
            for _ in range(100):
                pinocchio.framesForwardKinematics(self.model, self.data, values)
                error = pinocchio.log(self.data.oMf[self.tool].actInv(wanted)).vector
                if np.linalg.norm(error) < 1e-6:
                    break
                jacobian = pinocchio.computeFrameJacobian(self.model, self.data, values, self.tool)
                step = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-6 * np.eye(6), error)
                values = values + np.clip(step, -0.5, 0.5)
            values = (values + np.pi) % (2 * np.pi) - np.pi
            inside = (values >= low).all() and (values <= high).all()
            if np.linalg.norm(error) < 1e-6 and inside and not self.touches(values):
                return True
        return False


def rotation_of(quaternion):
    return pinocchio.Quaternion(np.array(quaternion)).toRotationMatrix()


def scan(program, mesh, base, out, options):
    shutil.rmtree(out, ignore_errors=True)
    command = [program, "scan", mesh, "--out", out, "--json", "--table", "known", "--sensor", "d435i",
               "--views", "10", "--candidates", "400", *options]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        print(f"{mesh}: {done.stderr.strip()}")
        return None
    return json.loads(done.stdout)


def check_motion(cell, out):
    """Views and right ones, samples of the way and free ones."""
    views = {row["step"]: row for row in csv.DictReader(open(out / "views.csv", encoding="utf-8"))}
    steps = {}
    for row in csv.DictReader(open(out / "waypoints.csv", encoding="utf-8")):
        steps.setdefault(row["step"], []).append(np.array([float(value) for value in list(row.values())[9:]]))
    n_right, n_samples, n_free = 0, 0, 0
    for step, points in steps.items():
        view = views[step]
        position, rotation = cell.camera(points[-1])
        wanted = np.array([float(view[key]) for key in ("x_m", "y_m", "z_m")])
        turned = rotation_of([float(view[key]) for key in ("qx", "qy", "qz", "qw")])
        is_there = np.abs(position - wanted).max() < 1e-5 and np.abs(rotation - turned).max() < 1e-5
        n_right += is_there and not cell.touches(points[-1])
        for a, b in zip(points, points[1:]):
            n = max(1, int(np.ceil(np.abs(b - a).max() / STEP_RAD)))
            free = [not cell.touches(a + (b - a) * i / n) for i in range(1, n + 1)]
            n_samples, n_free = n_samples + n, n_free + sum(free)
    return len(steps), n_right, n_samples, n_free


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("meshes", nargs="+", type=pathlib.Path)
    options = parser.parse_args()
    lines = ["| arm | object | reachable seen | views right | way free | path m | time s | sphere: seen | sphere: views that "
             "the arm can take |", "|---|---|---|---|---|---|---|---|---|"]
    sums = {arm: [] for arm in ARMS}
    for arm, radius in ARMS.items():
        for path in options.meshes:
            mesh = mesh_in_metres(path)
            low, high = mesh.bounds
            base = [(low[0] + high[0]) / 2 - DISTANCE_M, (low[1] + high[1]) / 2, low[2]]
            text = ",".join(f"{value:.6f}" for value in base)
            base = [float(value) for value in text.split(",")]
            out = options.out / arm / path.stem
            record = scan(options.program, path, base, out, ["--robot", arm, "--robot-base", text])
            sphere_out = options.out / f"{arm}-sphere" / path.stem
            sphere = scan(options.program, path, base, sphere_out, ["--reach", f"{text},{radius}"])
            if record is None or sphere is None:
                lines.append(f"| {arm} | {path.stem} | failed |" + " |" * 6)
                continue
            cell = Cell(arm, base, mesh)
            n, n_right, n_samples, n_free = check_motion(cell, out)
            rng = np.random.default_rng(0)
            taken = list(csv.DictReader(open(sphere_out / "views.csv", encoding="utf-8")))
            n_taken = sum(cell.reaches(np.array([float(v[k]) for k in ("x_m", "y_m", "z_m")]),
                                       rotation_of([float(v[k]) for k in ("qx", "qy", "qz", "qw")]), rng) for v in taken)
            last = record["steps"][-1]
            row = (last["reachable_coverage"], n_right / n, n_free / max(n_samples, 1), last["path_length_m"],
                   last["trajectory_time_s"], sphere["steps"][-1]["reachable_coverage"], n_taken / len(taken))
            sums[arm].append(row)
            cells = [f"{row[0]:.3f}", f"{n_right} of {n}", f"{n_free} of {n_samples}", f"{row[3]:.2f}", f"{row[4]:.1f}",
                     f"{row[5]:.3f}", f"{n_taken} of {len(taken)}"]
            lines.append(f"| {arm} | {path.stem} | " + " | ".join(cells) + " |")
            print(lines[-1], flush=True)
        means = [statistics.mean(column) for column in zip(*sums[arm])]
        lines.append(f"| **{arm}** | mean of {len(sums[arm])} | {means[0]:.3f} | {means[1]:.1%} | {means[2]:.2%} | {means[3]:.2f} "
                     f"| {means[4]:.1f} | {means[5]:.3f} | {means[6]:.1%} |")
        print(lines[-1], flush=True)
    (options.out / "robots.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
