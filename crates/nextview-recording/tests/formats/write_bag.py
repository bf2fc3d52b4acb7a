"""Writes a folder of recorded frames as a ROS 2 bag with transforms: write_bag.py FOLDER FORM.

FORM is plain (16UC1), metres (32FC1), compressed (compressedDepth) or png.
"""

import csv
import io
import sys
from pathlib import Path

import numpy as np
from PIL import Image
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

TIME = 1_700_000_000 * 10**9
STEP = 100_000_000

folder, form = Path(sys.argv[1]), sys.argv[2]
store = get_typestore(Stores.ROS2_JAZZY)
types = store.types
Header = types["std_msgs/msg/Header"]
Stamp = types["builtin_interfaces/msg/Time"]
Vector3 = types["geometry_msgs/msg/Vector3"]
Quaternion = types["geometry_msgs/msg/Quaternion"]
Transform = types["geometry_msgs/msg/Transform"]
TransformStamped = types["geometry_msgs/msg/TransformStamped"]
TFMessage = types["tf2_msgs/msg/TFMessage"]
CameraInfo = types["sensor_msgs/msg/CameraInfo"]
RegionOfInterest = types["sensor_msgs/msg/RegionOfInterest"]
DepthImage = types["sensor_msgs/msg/Image"]
CompressedImage = types["sensor_msgs/msg/CompressedImage"]


def header(time, frame):
    return Header(Stamp(time // 10**9, time % 10**9), frame)


def quaternion(m):
    """x, y, z, w of a rotation matrix, by its largest component (Shepperd 1978)."""
    squares = np.array([1 + m[0, 0] - m[1, 1] - m[2, 2], 1 - m[0, 0] + m[1, 1] - m[2, 2],
                        1 - m[0, 0] - m[1, 1] + m[2, 2], 1 + np.trace(m)])
    largest = int(np.argmax(squares))
    root = np.sqrt(squares[largest])
    if largest == 3:
        values = [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], squares[3]]
    else:
        i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
        values = [0.0] * 4
        values[i], values[j], values[k] = squares[i], m[j, i] + m[i, j], m[k, i] + m[i, k]
        values[3] = m[k, j] - m[j, k]
    return np.array(values) / (2 * root)


def transform(time, parent, child, matrix):
    position, rotation = Vector3(*matrix[:3, 3]), Quaternion(*quaternion(matrix[:3, :3]))
    return TransformStamped(header(time, parent), child, Transform(position, rotation))


def png(array):
    file = io.BytesIO()
    Image.fromarray(array).save(file, format="PNG")
    return file.getvalue()


intrinsics = dict(line.split(maxsplit=1) for line in (folder / "intrinsics.txt").read_text().splitlines())
fx, fy, cx, cy = (float(intrinsics[key]) for key in ("fx", "fy", "cx", "cy"))
width, height = int(intrinsics["width"]), int(intrinsics["height"])
world_from_base = np.eye(4)
world_from_base[:3, 3] = [0.5, -0.25, 0.125]

with Writer(folder / form, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
    def topic(name, of):
        connection = writer.add_connection(name, of, typestore=store)
        return lambda time, message: writer.write(connection, time, store.serialize_cdr(message, of))

    static = topic("/tf_static", TFMessage.__msgtype__)
    tf = topic("/tf", TFMessage.__msgtype__)
    info = topic("/camera_0/depth/camera_info", CameraInfo.__msgtype__)
    if form in ("plain", "metres"):
        depth = topic("/camera_0/depth/image", DepthImage.__msgtype__)
    else:
        end = "compressedDepth" if form == "compressed" else "compressed"
        depth = topic(f"/camera_0/depth/image/{end}", CompressedImage.__msgtype__)

    static(TIME, TFMessage([transform(0, "world", "base", world_from_base)]))
    k = np.array([fx, 0, cx, 0, fy, cy, 0, 0, 1])
    p = np.array([fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0])
    info(TIME, CameraInfo(header(TIME, "optical"), height, width, "plumb_bob", np.zeros(5), k, np.eye(3).ravel(), p,
                          0, 0, RegionOfInterest(0, 0, 0, 0, False)))
    with open(folder / "poses.csv") as file:
        for row in csv.DictReader(file):
            time = TIME + STEP * int(row["frame"])
            world_from_camera = np.eye(4)
            for i in range(12):
                world_from_camera[i // 4, i % 4] = float(row[f"world_from_camera_{i // 4}{i % 4}"])
            base_from_camera = np.linalg.inv(world_from_base) @ world_from_camera
            for apart in (-20_000_000, 20_000_000):
                tf(time + apart, TFMessage([transform(time + apart, "base", "optical", base_from_camera)]))
            millimetres = np.array(Image.open(folder / "depth" / f"{int(row['frame']):03}.png")).astype(np.uint16)
            at = header(time, "optical")
            if form == "plain":
                image = DepthImage(at, height, width, "16UC1", 0, 2 * width, millimetres.view(np.uint8).ravel())
            elif form == "metres":
                metres = (millimetres.astype(np.float64) * 0.001).astype(np.float32)
                metres[millimetres == 0] = np.nan
                image = DepthImage(at, height, width, "32FC1", 0, 4 * width, metres.view(np.uint8).ravel())
            else:
                head = bytes(12) if form == "compressed" else b""
                name = "16UC1; compressedDepth png" if form == "compressed" else "16UC1; png compressed "
                image = CompressedImage(at, name, np.frombuffer(head + png(millimetres), dtype=np.uint8))
            depth(time, image)
