#!/usr/bin/env python3
"""Writes the seeds of the fuzzer, a folder for each target: output of the program, and small files in other tools' formats.

    fuzz/seeds.py target/debug/nextview

Python's standard library only. The seeds are in the repository; this script made them.
"""

import io
import json
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

HERE = pathlib.Path(__file__).resolve().parent
SEEDS = HERE / "seeds"
# The camera of the targets: 8 x 6 pixels.
WIDTH, HEIGHT = 8, 6
CONFIG = """\
views = 3
candidates = 12
voxel_size_m = 0.03
baselines = false
camera = { width = 8, height = 6, fx = 7, fy = 7, cx = 3.5, cy = 2.5 }
noise = { model = "d435i", pose_error_mm = 1 }
registration = { enabled = true }
"""


def seed(target, name, content):
    folder = SEEDS / target
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)


def part(content):
    """A part as `Source::part` reads it."""
    return struct.pack("<H", len(content)) + content


def png(rows, color, bits):
    """An image of rows of bytes."""

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    head = struct.pack(">IIBBBBB", WIDTH, len(rows), bits, color, 0, 0, 0)
    pixels = zlib.compress(b"".join(b"\0" + row for row in rows))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


DEPTH = png([struct.pack(">8H", *range(300 + v, 308 + v)) for v in range(HEIGHT)], 0, 16)
COLOR = png([bytes(range(3 * WIDTH))] * HEIGHT, 2, 8)
MASK = png([b"\0\xff" * 4] * HEIGHT, 0, 8)


def meshes():
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
    head = "ply\nformat {}\nelement vertex 4\n{}element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    columns = "".join(f"property float {name}\n" for name in "xyz")
    colored = columns + "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    text = "".join(f"{x} {y} {z} 255 0 9\n" for x, y, z in corners) + "".join(f"3 {a} {b} {c}\n" for a, b, c in faces)
    seed("mesh_ply", "text", head.format("ascii 1.0", colored) + text)
    for order, letter in (("little", "<"), ("big", ">")):
        body = b"".join(struct.pack(letter + "3f", *corner) for corner in corners)
        body += b"".join(struct.pack(letter + "B3i", 3, *face) for face in faces)
        seed("mesh_ply", order, head.format(f"binary_{order}_endian 1.0", columns).encode() + body)
    triangles = [[corners[i] for i in face] for face in faces]
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *sum(triangle, ()), 0) for triangle in triangles)
    seed("mesh_stl", "binary", bytes(80) + struct.pack("<I", 4) + body)
    text = "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join("vertex {} {} {}\n".format(*c) for c in t) + "endloop\nendfacet\n"
        for t in triangles
    )
    seed("mesh_stl", "text", f"solid a\n{text}endsolid a\n")
    text = "".join("{} {} {}\n".format(*c) for c in corners) + "".join("3 {} {} {}\n".format(*f) for f in faces)
    seed("mesh_off", "off", f"OFF\n4 4 0\n{text}")
    seed("mesh_off", "coloff", "COFF # colours\n3 1 0\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n0 1 0 1 0 0 1\n3 0 1 2\n")
    text = "mtllib a.mtl\n" + "".join("v {} {} {}\n".format(*c) for c in corners) + "vt 0 0\nvt 1 0\nvn 0 0 1\nusemtl a\n"
    text += "".join("f {}/1/1 {}/2/1 {}/1/1\n".format(*(i + 1 for i in f)) for f in faces) + "f -1 -2 -3 -4\n"
    library = b"newmtl a\nKd 0.5 0.25 1\nmap_Kd a.png\n"
    seed("mesh_obj", "obj", part(library) + text.encode())
    seed("mesh_obj", "image", part(COLOR) + text.encode())
    numbers = b"".join(struct.pack("<3f", *c) for c in corners) + b"".join(struct.pack("<3H", *f) for f in faces)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [1, 2, 3], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": 4, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0, 1]}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 24},
        ],
        "buffers": [{"byteLength": len(numbers)}],
    }
    binary = json.dumps(document).encode()
    binary += b" " * (-len(binary) % 4)
    chunks = struct.pack("<I4s", len(binary), b"JSON") + binary + struct.pack("<I4s", len(numbers), b"BIN\0") + numbers
    seed("mesh_gltf", "glb", part(b"") + struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
    document["buffers"][0]["uri"] = "a.bin"
    seed("mesh_gltf", "gltf", part(numbers) + json.dumps(document).encode())


class Cdr:
    """A message of ROS 2."""

    def __init__(self):
        self.bytes = io.BytesIO(b"")
        self.bytes.write(b"\0\1\0\0")

    def pack(self, kind, *values):
        size = struct.calcsize(kind)
        for value in values:
            self.bytes.write(b"\0" * (-(self.bytes.tell() - 4) % size) + struct.pack("<" + kind, value))
        return self

    def text(self, text):
        self.pack("I", len(text) + 1)
        self.bytes.write(text.encode() + b"\0")
        return self

    def data(self, content):
        self.pack("I", len(content))
        self.bytes.write(content)
        return self

    def header(self, time):
        return self.pack("i", time).pack("I", 0).text("camera")


def ros():
    info = Cdr().header(5).pack("I", HEIGHT, WIDTH).text("plumb_bob").pack("I", 5).pack("d", *[0.0] * 5)
    info.pack("d", 7, 0, 3.5, 0, 7, 2.5, 0, 0, 1, *[0] * 9, *[0] * 12)
    image = Cdr().header(5).pack("I", HEIGHT, WIDTH).text("16UC1").pack("B", 0).pack("I", 2 * WIDTH)
    image.data(struct.pack("<48H", *range(300, 348)))
    packed = Cdr().header(5).text("16UC1; compressedDepth png").data(bytes(12) + DEPTH)
    pose = Cdr().header(5).pack("d", 0.1, 0.2, 0.3, 0, 0, 0, 1)
    transforms = Cdr().pack("I", 1).header(5).text("world").pack("d", 0.1, 0.2, 0.3, 0, 0, 0, 1)
    kinds = [
        ("camera/camera_info", "sensor_msgs/msg/CameraInfo", info),
        ("camera/image", "sensor_msgs/msg/Image", image),
        ("pose", "geometry_msgs/msg/PoseStamped", pose),
        ("packed/compressedDepth", "sensor_msgs/msg/CompressedImage", packed),
        ("tf", "tf2_msgs/msg/TFMessage", transforms),
    ]

    def text(text):
        return struct.pack("<I", len(text)) + text.encode()

    def record(kind, content):
        return struct.pack("<BQ", kind, len(content)) + content

    def records(kinds):
        found = b""
        for i, (topic, kind, cdr) in enumerate(kinds, 1):
            found += record(3, struct.pack("<H", i) + text(kind) + text("ros2msg") + struct.pack("<I", 0))
            found += record(4, struct.pack("<HH", i, i) + text("/" + topic) + text("cdr") + struct.pack("<I", 0))
            found += record(5, struct.pack("<HIQQ", i, 0, 5, 5) + cdr.bytes.getvalue())
        return found

    magic = b"\x89MCAP0\r\n"
    for name, of in (("plain", kinds[:3]), ("packed", [kinds[0], kinds[2], kinds[3]]), ("transforms", [*kinds[:2], kinds[4]])):
        plain = records(of)
        chunk = struct.pack("<QQQI", 5, 5, len(plain), 0) + text("") + struct.pack("<Q", len(plain)) + plain
        start, end = record(1, text("ros2") + text("")), record(15, bytes(4))
        seed("mcap", name, magic + start + plain + end + magic)
        seed("mcap", f"chunk-{name}", magic + start + record(6, chunk) + end + magic)
    for topic, _, cdr in kinds:
        seed("ros_messages", topic.replace("/", "-"), cdr.bytes.getvalue())


def images():
    seed("depth_image", "depth", b"\0" + part(b"") + DEPTH)
    seed("depth_image", "masked", b"\0" + part(MASK) + DEPTH)
    seed("depth_image", "color", b"\1" + COLOR)
    seed("depth_image", "packed", b"\2\0" + bytes(12) + DEPTH)
    seed("depth_image", "inverse", b"\2\1" + struct.pack("<iff", 0, 1000.0, -99.0) + DEPTH)
    # The marks at which a JPEG decoder branches.
    seed("depth_image", "jpeg", b"\1\xff\xd8\xff\xc0\0\x11\x08\0\6\0\x08\3\1\x11\0\2\x11\0\3\x11\0\xff\xda\0\x0c\3\1\0\2\0\3\0\0\x3f\0\xff\xd9")


def journal(path):
    content = path.read_bytes()[8:]
    contents = []
    while len(content) >= 8:
        (length,) = struct.unpack_from("<I", content)
        contents.append(content[8 : 8 + length])
        content = content[8 + length :]
    seed("journal", "whole", bytes([len(contents)]) + b"".join(part(entry) for entry in contents))
    skip = b'{"skip":{"view":3,"reason":"no path"}}'
    entry = b"\2" + struct.pack("<I", len(skip)) + skip
    seed("journal", "skip", b"\2" + part(contents[0]) + part(entry) + b"damage")


def requests():
    def request(line, body=b"", kind="application/json"):
        head = f"{line} HTTP/1.1\r\nhost: 127.0.0.1:80\r\ncontent-type: {kind}\r\ncontent-length: {len(body)}\r\n\r\n"
        return head.encode() + body

    scan = {
        "id": "a",
        "views": 2,
        "candidates": 6,
        "voxel_size_m": 0.03,
        "live": {"box_m": [-0.1, -0.1, -0.1, 0.1, 0.1, 0.1]},
        "camera": {"width": WIDTH, "height": HEIGHT, "fx": 7, "fy": 7, "cx": 3.5, "cy": 2.5},
    }
    create = request("POST /scans", json.dumps(scan).encode())
    rows = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -0.4], [0, 0, 0, 1]]
    numbers = ",".join(str(number) for row in rows for number in row)
    query = f"POST /scans/a/frames?id=f&world_from_camera={numbers}"
    raw = struct.pack("<48f", *[0.3 + 0.001 * i for i in range(48)])
    head = json.dumps({"id": "g", "world_from_camera": rows}).encode()
    parts = b"".join(
        b'--x\r\ncontent-disposition: form-data; name="' + name + b'"\r\n\r\n' + content + b"\r\n"
        for name, content in ((b"frame", head), (b"depth", DEPTH), (b"color", COLOR), (b"mask", MASK))
    )
    raw_frame = request(f"{query}&width=8&height=6&dtype=f32", raw, "application/octet-stream")
    seed("server", "raw", create + raw_frame + request("GET /scans/a/next"))
    seed("server", "png", create + request(query, DEPTH, "image/png") + request("POST /scans/a/finish"))
    seed("server", "parts", create + request("POST /scans/a/frames", parts + b"--x--\r\n", "multipart/form-data; boundary=x"))
    for i, line in enumerate(("GET /scans/a", "GET /scans/a/next?batch=2", "GET /scans/a/record", "GET /scans/a/scene?after=0", "GET /scans/a/files/map.ot", "DELETE /scans/a")):
        seed("server", f"ask-{i}", create + request(line))
    for name, body in (("skip", {"view": 1, "reason": "no"}), ("accept", {"view": 0}), ("guidance", {"world_from_camera": rows}), ("pause", {})):
        seed("server", name, create + request(f"POST /scans/a/{name}", json.dumps(body).encode()))
    seed("server_scan", "small", json.dumps(scan))
    tracked = {"registration": {"enabled": True, "given_poses": "tracked"}, "live": {"first_pose": rows}, "confirm_views": True}
    seed("server_scan", "tracked", json.dumps({**scan, **tracked}))


def of_program(program, work):
    """What scans and campaigns write."""
    (work / "small.toml").write_text(CONFIG)
    out = work / "out"
    command = [program, "scan", "builtin:bracket", "--config", work / "small.toml", "--out"]
    subprocess.run([*command, out], check=True, stdout=subprocess.DEVNULL)
    for name in ("map.ot", "map.bt"):
        seed("octomap", name, (out / name).read_bytes())
    seed("views", "views.csv", "x_m,y_m,z_m,qx,qy,qz,qw\n0.1,-0.2,0.3,0,0,0,1\n# with a pose each\n")
    seed("views", "positions", "0.1 ,-0.2,0.3\n0.5,0,1e-3\n")
    seed("configuration", "written", (out / "config.toml").read_text())
    seed("configuration", "own", CONFIG)
    record = (out / "record.json").read_bytes()
    seed("records", "scan", b"\0" + record)
    seed("records", "step", b"\1" + (out / "steps.jsonl").read_bytes().split(b"\n")[0])
    frames = out / "frames"
    for path in sorted(frames.glob("*.csv")) + sorted(frames.glob("*.txt")):
        seed("recording_texts", path.name, path.read_bytes())
    seed("recording_texts", "trajectory", "# t\n1.5 0.1 0.2 0.3 0 0 0.7071 0.7071\n2 0 0 0 0 0 0 1\n")
    seed("recording_texts", "images", "1.5 depth/a.png\n1.6 depth/b.png\n")
    seed("recording_texts", "transform", "1 0 0 0.1\n0 1 0 0.2\n0 0 1 0.3\n0 0 0 1\n")
    spec = 'name = "a"\nseeds = [0, 1]\nview_seeds = [0]\nfirst_views = 2\nobjects = ["builtin:mug", { file = "b.stl", unit = "mm" }]\n'
    spec += '[scan]\nviews = 2\ncandidates = 12\nvoxel_size_m = 0.03\nbaselines = false\n'
    spec += '[[variant]]\nlabel = "gamma {max_flow.gamma}"\nscan.planner = "max-flow"\nsweep."max_flow.gamma" = [0, 0.5]\n'
    seed("campaign", "own", spec)
    plain = 'name = "a"\nobjects = ["builtin:mug"]\nscan = { planner = "random", views = 2, candidates = 12, voxel_size_m = 0.03, baselines = false }\n'
    (work / "spec.toml").write_text(plain)
    subprocess.run([program, "bench", work / "spec.toml", "--out", work / "bench"], check=True, stdout=subprocess.DEVNULL)
    seed("campaign", "written", (work / "bench/spec.toml").read_text())
    seed("records", "run", b"\2" + (work / "bench/runs.jsonl").read_bytes().split(b"\n")[0])
    killed = work / "killed"
    process = subprocess.Popen([*command, killed], stdout=subprocess.PIPE, text=True)
    # The table's head, and a line of the first frame.
    next(line for line in process.stdout if line.strip().startswith("1 "))
    process.kill()
    process.wait()
    journal(killed / "scan.journal")


def main():
    shutil.rmtree(SEEDS, ignore_errors=True)
    with tempfile.TemporaryDirectory() as work:
        of_program(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(work))
    meshes()
    ros()
    images()
    requests()
    for preset in ("ur5e", "panda"):
        seed("urdf", preset, (HERE / f"../crates/nextview-robot/presets/{preset}.urdf").read_bytes())
    seed("parameters", "list", "[1, 2.5, true, 'text', \"more\"]")
    seed("parameters", "file", "node:\n  ros__parameters:\n    a: 1\n    b: {c: 0.5}\n")
    tensors = json.dumps({"conv1.weight": {"dtype": "F32", "shape": [1], "data_offsets": [0, 4]}}).encode()
    seed("weights", "tensors", struct.pack("<Q", len(tensors)) + tensors + bytes(4))
    # A session of each kind of object box and lens, plain and noisy.
    for i in range(12):
        frame = bytes([1, 0, 100]) + bytes([0])
        noisy = bytes([1, 1, 0]) + bytes(80 + (7 * j + i) % 40 for j in range(48)) + bytes([0])
        setup = bytes([2 * i, 1, i % 3, i % 3, i % 4, 1 + i % 2, 1, 4, 1 + i % 4, 1, 2])
        seed("session", f"{i:02}", setup + frame + noisy + frame)
    size = sum(path.stat().st_size for path in SEEDS.rglob("*") if path.is_file())
    print(f"{sum(path.is_file() for path in SEEDS.rglob('*'))} seeds, {size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
