"""A robot with a simulated depth camera, as another implementation of DDS: the node's peer in the checks."""

import atexit
import io
import json
import subprocess
import time

import numpy as np
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from PIL import Image

import ros_messages as ros

CDR = Policy.DataRepresentation(use_cdrv0_representation=True)
RELIABLE = Policy.Reliability.Reliable(duration(seconds=1))
LATCHED = Qos(CDR, RELIABLE, Policy.Durability.TransientLocal, Policy.History.KeepLast(1))
PLENTY = Qos(CDR, RELIABLE, Policy.History.KeepLast(100))
SENSOR = Qos(CDR, Policy.Reliability.BestEffort, Policy.History.KeepLast(1))

OUTPUTS = {
    "next_view": ros.PoseStamped,
    "candidates": ros.PoseArray,
    "path": ros.Path,
    "joint_trajectory": ros.JointTrajectory,
    "octomap_binary": ros.Octomap,
    "octomap_full": ros.Octomap,
    "cloud": ros.PointCloud2,
    "markers": ros.MarkerArray,
    "status": ros.Text,
}
WIDTH, HEIGHT = 640, 480


class Robot:
    """Publishes camera_info, images and transforms; asks the node's services; reads what it publishes."""

    def __init__(self, camera_program, intrinsics):
        self.camera = subprocess.Popen([camera_program], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        atexit.register(self.camera.kill)
        self.intrinsics = intrinsics
        self.participant = DomainParticipant(0)
        self.image = self.writer("depth/image", ros.Image, SENSOR)
        self.compressed = self.writer("depth/image/compressedDepth", ros.CompressedImage, SENSOR)
        self.info = self.writer("depth/camera_info", ros.CameraInfo, SENSOR)
        self.tf = self.writer("tf", ros.TFMessage, PLENTY)
        self.tf_static = self.writer("tf_static", ros.TFMessage, LATCHED)
        self.readers = {name: self.reader(f"rt/nextview/{name}", kind, LATCHED) for name, kind in OUTPUTS.items()}
        self.latest = {}
        self.requests, self.replies, self.number = {}, {}, 0
        for name in ("capture", "plan", "skip", "save", "reset"):
            topic = Topic(self.participant, f"rq/nextview/{name}Request", ros.TriggerRequest)
            self.requests[name] = DataWriter(self.participant, topic, PLENTY)
            self.replies[name] = self.reader(f"rr/nextview/{name}Reply", ros.TriggerReply, PLENTY)
        self.time = 1_700_000_000.0

    def writer(self, name, kind, qos):
        return DataWriter(self.participant, Topic(self.participant, f"rt/{name}", kind), qos)

    def reader(self, name, kind, qos):
        return DataReader(self.participant, Topic(self.participant, name, kind), qos)

    def close(self):
        self.camera.stdin.close()
        self.camera.wait(10)

    # What the robot publishes.

    def header(self, at, frame):
        whole = int(at)
        return ros.Header(ros.Time(whole, round((at - whole) * 1e9)), frame)

    def publish_info(self, width=WIDTH):
        fx, fy, cx, cy = self.intrinsics
        k = [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]
        eye = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
        p = [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]
        header = self.header(self.time, "optical")
        self.info.write(ros.CameraInfo(header, HEIGHT, width, "plumb_bob", [0.0] * 5, k, eye, p))

    def publish_tf(self, pose, at, parent="map", child="optical"):
        position, rotation = pose.position, pose.orientation
        translation = ros.Vector3(position.x, position.y, position.z)
        transform = ros.TransformStamped(self.header(at, parent), child, ros.Transform(translation, rotation))
        self.tf.write(ros.TFMessage([transform]))

    def publish_image(self, metres, at, encoding="32FC1", frame="optical"):
        if encoding == "compressedDepth":
            millimetres = np.nan_to_num(np.round(metres * 1000.0)).astype(np.uint16).reshape(HEIGHT, WIDTH)
            file = io.BytesIO()
            Image.fromarray(millimetres).save(file, format="PNG")
            data = bytes(12) + file.getvalue()
            self.compressed.write(ros.CompressedImage(self.header(at, frame), f"16UC1; {encoding} png", data))
            return
        if encoding == "16UC1":
            pixels = np.nan_to_num(np.round(metres * 1000.0)).astype("<u2")
        else:
            pixels = metres.astype("<f4")
        step = pixels.itemsize * WIDTH
        self.image.write(ros.Image(self.header(at, frame), HEIGHT, WIDTH, encoding, 0, step, pixels.tobytes()))

    def take(self, pose):
        """The image from a pose, metres."""
        p, q = pose.position, pose.orientation
        line = " ".join(repr(float(x)) for x in (p.x, p.y, p.z, q.x, q.y, q.z, q.w))
        self.camera.stdin.write(f"{line}\n".encode())
        self.camera.stdin.flush()
        return np.frombuffer(self.camera.stdout.read(4 * WIDTH * HEIGHT), dtype="<f4")

    # What it hears.

    def listen(self):
        for name, reader in self.readers.items():
            for message in reader.take(100):
                if hasattr(message, "sample_info") and not message.sample_info.valid_data:
                    continue
                self.latest[name] = message

    def status(self):
        self.listen()
        return json.loads(self.latest["status"].data) if "status" in self.latest else None

    def until(self, what, condition, seconds=30.0, meanwhile=lambda: None):
        """Waits until the status satisfies this."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            meanwhile()
            status = self.status()
            if status is not None and condition(status):
                return status
            time.sleep(0.02)
        raise AssertionError(f"no {what} within {seconds} s; the last status: {self.status()}")

    def ask(self, name):
        """Sends a request; its number."""
        self.number += 1
        self.requests[name].write(ros.TriggerRequest(7, self.number))
        return self.number

    def answer(self, name, number, seconds=30.0, meanwhile=lambda: None):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            meanwhile()
            for reply in self.replies[name].take(10):
                if reply.client == 7 and reply.number == number:
                    return reply
            time.sleep(0.01)
        raise AssertionError(f"no answer of {name} within {seconds} s; the last status: {self.status()}")

    def call(self, name, seconds=30.0):
        return self.answer(name, self.ask(name), seconds)

    def capture(self, pose, encoding="32FC1", move=lambda robot, pose, at: robot.publish_tf(pose, at)):
        """Takes an image at a pose as a robot does: asks, publishes it, and says where it was taken."""
        metres = self.take(pose)
        number = self.ask("capture")
        self.until("capturing", lambda status: status["capturing"])
        self.time += 1.0
        self.publish_image(metres, self.time, encoding)
        move(self, pose, self.time)
        reply = self.answer("capture", number)
        return reply
