"""A robot cell: an object on a table in a room, a depth camera with its errors, and a robot that reports wrong poses."""

import dataclasses

import numpy as np
from scipy import ndimage
from surfaces import box, surfaces


@dataclasses.dataclass(frozen=True)
class Sensor:
    """A depth camera. The sources of the values are in docs/sensors.md."""

    width: int
    height: int
    focal_px: float
    least_m: float
    most_m: float
    baseline_m: float = 0.0
    # Of the disparity, pixels: errors that neighbours share, independent ones, and rounding.
    wave_px: float = 0.0
    noise_px: float = 0.0
    step_px: float = 0.0
    # Of the depth itself, metres at 1 m; it grows with the square of the distance.
    noise_m: float = 0.0
    unit_m: float = 1e-3
    # Share of pixels at edges that return nothing, and that return something between both sides.
    edge_loss: float = 0.0
    flying: float = 0.0

    @property
    def center_px(self):
        """The principal point."""
        return (self.width - 1) / 2, (self.height - 1) / 2


SENSORS = {
    "stereo": Sensor(640, 480, 615.0, .17, 6., baseline_m=.05, wave_px=.08, noise_px=.03, step_px=1 / 32, edge_loss=.7),
    "structured": Sensor(612, 512, 640.0, .3, 1.1, noise_m=.22e-3, unit_m=1e-5),
    "time-of-flight": Sensor(640, 576, 504.0, .25, 3.86, noise_m=1.5e-3, flying=.5),
}


@dataclasses.dataclass(frozen=True)
class PoseErrors:
    """Deviations of reported poses on each axis, and the size of the hand-eye error, whose direction is random."""

    mm: float = 0.0
    deg: float = 0.0
    hand_eye_mm: float = 0.0
    hand_eye_deg: float = 0.0


def turned(rotation_vector):
    """The rotation matrix of a rotation vector, radians (Rodrigues)."""
    angle = np.linalg.norm(rotation_vector)
    x, y, z = rotation_vector / max(angle, 1e-300)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def looking(eye, target):
    """The camera pose at a place that looks at a target: x right, y down, z forward."""
    forward = (np.asarray(target, float) - eye) / np.linalg.norm(np.asarray(target, float) - eye)
    right = np.cross(forward, (0, 0, 1))
    right = right / np.linalg.norm(right) if np.linalg.norm(right) > 1e-6 else np.array([1.0, 0, 0])
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, np.cross(forward, right), forward], 1)
    pose[:3, 3] = eye
    return pose


class Cell:
    """An object, given as vertices (metres) and triangles, upright on a table whose height nobody states."""

    TABLE_Z = 0.71
    PLACE = np.array([0.4, 0.1])
    # A robot stops within half a millimetre of where it was sent.
    STOP_M = 5e-4

    def __init__(self, mesh, seed, errors, sensor, missing=0.0):
        vertices, triangles = np.asarray(mesh[0], float), np.asarray(mesh[1])
        low, high = vertices.min(0), vertices.max(0)
        vertices = vertices - (*(low + high)[:2] / 2, low[2]) + (*self.PLACE, self.TABLE_Z)
        self.object, self.low, self.high = (vertices, triangles), vertices.min(0), vertices.max(0)
        self.center, self.radius = (self.low + self.high) / 2, float(np.linalg.norm(self.high - self.low)) / 2
        table = box((*self.PLACE - .5, self.TABLE_Z - .04), (*self.PLACE + .5, self.TABLE_Z))
        room = box((-2, -2, 0), (2, 2, 2.6))
        self.surfaces = surfaces([self.object, table, room])
        self.rng, self.errors, self.sensor, self.missing = np.random.default_rng(seed), errors, sensor, missing
        self.given_from_true = np.eye(4)
        shift, turn = self.rng.normal(size=(2, 3))
        self.given_from_true[:3, 3] = shift / np.linalg.norm(shift) * errors.hand_eye_mm * 1e-3
        self.given_from_true[:3, :3] = turned(turn / np.linalg.norm(turn) * np.radians(errors.hand_eye_deg))
        u, v = np.meshgrid(np.arange(sensor.width), np.arange(sensor.height))
        cx, cy = sensor.center_px
        self.rays = np.stack([(u - cx) / sensor.focal_px, (v - cy) / sensor.focal_px, np.ones_like(u, float)], -1)
        # The true pose of every image.
        self.poses = []

    @property
    def distance(self):
        """From where a person would look at the object, metres."""
        return max(.25, self.sensor.least_m + .03) + self.radius

    def capture(self, requested):
        """The depths (metres, 0: not measured) seen near a requested pose, and the pose that the robot reports."""
        true = np.array(requested, float)
        true[:3, 3] += self.rng.normal(0, self.STOP_M, 3)
        given = true.copy()
        given[:3, 3] += self.rng.normal(0, 1e-3, 3) * self.errors.mm
        given[:3, :3] = turned(self.rng.normal(0, np.radians(1), 3) * self.errors.deg) @ given[:3, :3]
        self.poses.append(true)
        return self.depths(true), given @ self.given_from_true

    def depths(self, pose):
        """The depths that the camera measures."""
        sensor, rng = self.sensor, self.rng
        directions = self.rays @ pose[:3, :3].T
        z, which, normals = self.surfaces.cast(np.broadcast_to(pose[:3, 3], directions.shape), directions)
        cosine = np.abs((directions * normals).sum(-1)) / np.linalg.norm(directions, axis=-1)
        near = np.where(np.isfinite(z), z, 1e3)
        is_edge = ndimage.maximum_filter(near, 5) - ndimage.minimum_filter(near, 5) > .02
        depth = near
        if sensor.baseline_m:
            wave = ndimage.gaussian_filter(rng.normal(size=z.shape), 2.0)
            disparity = sensor.focal_px * sensor.baseline_m / near
            disparity += wave / wave.std() * sensor.wave_px + rng.normal(size=z.shape) * sensor.noise_px
            disparity = np.round(disparity / sensor.step_px) * sensor.step_px
            depth = sensor.focal_px * sensor.baseline_m / np.maximum(disparity, 1e-3)
        depth = depth + rng.normal(size=z.shape) * sensor.noise_m * near ** 2
        if sensor.flying:
            far, close = ndimage.maximum_filter(near, 3), ndimage.minimum_filter(near, 3)
            flies = (far - close > .02 * close) & (far < sensor.most_m) & (rng.random(z.shape) < sensor.flying)
            depth = np.where(flies, close + (far - close) * rng.random(z.shape), depth)
        lost = (near < sensor.least_m) | (near > sensor.most_m) | is_edge & (rng.random(z.shape) < sensor.edge_loss)
        lost |= (cosine < .2) | (cosine < .35) & (rng.random(z.shape) < .5) | (rng.random(z.shape) < .005)
        if self.missing and (which == 0).any():
            patches = ndimage.gaussian_filter(rng.normal(size=z.shape), 8.0)
            lost |= (which == 0) & (patches < np.quantile(patches[which == 0], self.missing))
        return np.where(lost, 0, np.round(depth / sensor.unit_m) * sensor.unit_m).astype(np.float32)
