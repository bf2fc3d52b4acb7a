"""Checks the node against Cyclone, another implementation of DDS, and the messages of `rosbags`.

check_node.py NODE SIMULATED_CAMERA [--full]

Needs Linux, the right to make a network of its own (`unshare`), and the packages cyclonedds, rosbags, numpy and pillow.
"""

import atexit
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

# A network of its own, so that nobody else on this one hears or disturbs the check.
if os.environ.get("NEXTVIEW_OWN_NETWORK") != "1":
    script = ("ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo && exec \"$@\"")
    user = [] if os.geteuid() == 0 else ["--map-root-user"]
    os.environ["NEXTVIEW_OWN_NETWORK"] = "1"
    os.environ["CYCLONEDDS_URI"] = (
        "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo' multicast='true'/></Interfaces>"
        "<AllowMulticast>true</AllowMulticast></General></Domain></CycloneDDS>"
    )
    os.execvp("unshare", ["unshare", "--net", *user, "sh", "-c", script, "sh", sys.executable, *sys.argv])

from robot import HEIGHT, WIDTH, Robot  # noqa: E402
import ros_messages as ros  # noqa: E402

NODE, CAMERA = sys.argv[1], sys.argv[2]
IS_FULL = "--full" in sys.argv
VIEWS = 10
PARAMETERS = ["live.box_m:=[-0.08,-0.08,-0.02,0.08,0.08,0.14]", "candidates:=200"]


class Node:
    """The node as a process; its lines on stderr."""

    def __init__(self, *parameters, views=VIEWS):
        self.log = tempfile.TemporaryFile()
        given = [word for text in (*PARAMETERS, f"views:={views}", *parameters) for word in ("-p", text)]
        environment = {**os.environ, "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}
        self.process = subprocess.Popen([NODE, "--ros-args", *given], stderr=self.log, env=environment)
        atexit.register(self.process.kill)

    def lines(self):
        self.log.seek(0)
        return self.log.read().decode().splitlines()

    def resident_mb(self):
        for line in Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                return int(line.split()[1]) / 1024

    def kill(self):
        self.process.kill()
        self.process.wait(10)

    def stop(self):
        self.process.terminate()
        code = self.process.wait(10)
        assert code == 0, f"the node ended with {code}: {self.lines()}"


def new_robot():
    return Robot(CAMERA, INTRINSICS)


def begin(robot):
    """Until the node has made its first plan."""
    return robot.until("first view", lambda status: status["state"] == "view" and status["busy"] == 0,
                       meanwhile=robot.publish_info)


def next_pose(robot):
    robot.listen()
    return robot.latest["next_view"].pose


def views(robot, n, **capture):
    """Takes so many views, or all; their numbers, and the last status."""
    taken = []
    status = robot.until("view", lambda status: status["busy"] == 0)
    while status["state"] == "view" and len(taken) < n:
        taken.append(status["view"])
        before = status["frames"]
        reply = robot.capture(next_pose(robot), **capture)
        assert reply.success, reply.message
        status = robot.until("frame", lambda status: status["busy"] == 0 and status["frames"] == before + 1)
        assert json.loads(reply.message)["frames"] == before + 1
        # The view of this status is published before it.
        time.sleep(0.05)
    return taken, status


def check_bytes(robot):
    """Each message, written by Cyclone, has the bytes that rosbags reads and writes."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    octomap = "std_msgs/Header header\nbool binary\nstring id\nfloat64 resolution\nint8[] data\n"
    store.register(get_types_from_msg(octomap, "octomap_msgs/msg/Octomap"))
    for name, message in robot.latest.items():
        package, kind = type(message).__idl_typename__.split("::msg::dds_::")
        kind = f"{package}/msg/{kind.removesuffix('_')}"
        content = bytes(message.serialize(use_version_2=False))
        read = store.deserialize_cdr(content, kind)
        again = bytes(store.serialize_cdr(read, kind))
        assert again == content or again == content[: len(again)] and not any(content[len(again):]), name
    return sorted(robot.latest)


def check_ten_views(reference):
    with tempfile.TemporaryDirectory() as folder:
        node, robot = Node(f"directory:={folder}/scan"), new_robot()
        begin(robot)
        taken, status = views(robot, 99)
        assert (status["state"], status["stop_reason"], status["problems"]) == ("finished", "view-limit", {}), status
        assert taken == reference["views"], (taken, reference["views"])
        record = json.loads((Path(folder) / "scan" / "record.json").read_text())
        last = record["steps"][-1]
        known = [last["occupied_voxels"], last["free_voxels"]]
        assert known == reference["known_voxels"], (known, reference["known_voxels"])
        robot.listen()
        for name, file in (("octomap_full", "map.ot"), ("octomap_binary", "map.bt")):
            content = bytes(value & 0xFF for value in robot.latest[name].data)
            written = (Path(folder) / "scan" / file).read_bytes()
            assert written.split(b"\ndata\n", 1)[1] == content, file
        checked = check_bytes(robot)
        # One who comes later hears the last of everything.
        late = new_robot()
        late.until("status", lambda status: status["state"] == "finished")
        late.until("everything", lambda _: len(late.latest) == len(checked))
        assert not late.call("skip").success
        late.close()
        robot.close()
        node.stop()
        assert len(node.lines()) == 1, node.lines()
    return f"views {taken}, {known[0]} occupied and {known[1]} free voxels as in one process; {', '.join(checked)}"


def check_transforms(reference):
    """Transforms late, missing for a while, and out of order: the same views."""
    def disorder(robot, pose, at):
        time.sleep(0.2)
        robot.publish_tf(pose, at + 0.1)
        time.sleep(0.2)
        robot.publish_tf(pose, at - 0.1)

    node, robot = Node(views=4), new_robot()
    begin(robot)
    taken, status = views(robot, 99, move=disorder)
    assert taken == reference["views"][:4] and status["problems"] == {}, (taken, status)
    robot.close()
    node.stop()

    # Images come at 30 Hz, and transforms only later: an image before the first one does not help.
    node, robot = Node("capture_timeout_s:=1.5"), new_robot()
    begin(robot)
    pose = next_pose(robot)
    reply = robot.capture(pose, move=lambda *_: None)
    assert not reply.success and "no transform names the frame 'map'" in reply.message, reply.message
    reply = robot.capture(pose, move=lambda robot, pose, at: robot.publish_tf(pose, at - 0.5))
    assert not reply.success and "is known only until" in reply.message, reply.message
    assert robot.capture(pose).success
    robot.until("plan", lambda status: status["busy"] == 0)
    time.sleep(0.05)
    for encoding in ("compressedDepth", "16UC1"):
        reply = robot.capture(next_pose(robot), encoding)
        assert reply.success, reply.message
    assert json.loads(reply.message)["frames"] == 3, reply
    robot.close()
    node.stop()
    return "late, missing and disordered; compressedDepth and millimetres as well"


def check_restarts(reference):
    """The node is killed after four views, and the robot's program after seven: the same views in the end."""
    with tempfile.TemporaryDirectory() as folder:
        node, robot = Node(f"directory:={folder}/scan"), new_robot()
        begin(robot)
        taken, _ = views(robot, 4)
        node.kill()
        robot.close()
        node, robot = Node(f"directory:={folder}/scan"), new_robot()
        robot.until("resumption", lambda status: status["state"] == "view" and status["frames"] == 4)
        begin(robot)
        taken += views(robot, 3)[0]
        robot.close()
        robot = new_robot()
        robot.time += 1000.0
        begin(robot)
        rest, status = views(robot, 99)
        assert taken + rest == reference["views"], (taken, rest)
        assert status["state"] == "finished" and (Path(folder) / "scan" / "record.json").exists()
        # Anew, with other images.
        assert robot.call("reset").success
        assert robot.until("new scan", lambda status: status["state"] == "view")["frames"] == 0
        robot.close()
        node.stop()
    return "killed node, and a new robot's program"


def check_bad_input():
    """What is wrong is said once, and the scan goes on when it is right."""
    node, robot = Node("capture_timeout_s:=1.5"), new_robot()
    metres = None
    for _ in range(30):
        robot.time += 1 / 30
        robot.publish_image(WALL, robot.time)
        time.sleep(0.02)
    told = robot.until("problem", lambda status: status["problems"])
    assert "no camera_info" in told["problems"]["depth/image"], told
    assert not robot.call("plan").success and not robot.call("reset").success
    begin(robot)
    pose = next_pose(robot)
    metres = robot.take(pose)
    for encoding, problem in (("mono8", "'mono8', expected 16UC1"), ("32FC1", None)):
        for _ in range(10):
            robot.time += 1 / 30
            robot.publish_image(metres, robot.time, encoding)
            time.sleep(0.02)
        status = robot.until("encoding", lambda status: ("depth/image" in status["problems"]) == (problem is not None))
        assert problem is None or problem in status["problems"]["depth/image"], status
    number = robot.ask("capture")
    robot.until("capturing", lambda status: status["capturing"])
    robot.time += 1.0
    robot.publish_tf(pose, robot.time)
    robot.publish_image(metres, robot.time, frame="lens")
    reply = robot.answer("capture", number)
    assert not reply.success and "no transform names the frame 'lens'" in reply.message, reply.message
    # The simulation begins anew.
    robot.time -= 500.0
    reply = robot.capture(pose)
    assert reply.success or "stamp is earlier" in reply.message, reply.message
    if not reply.success:
        assert robot.capture(pose).success
    # Another camera.
    robot.publish_info(width=WIDTH + 2)
    status = robot.until("other camera", lambda status: "scan" in status["problems"])
    assert "camera_info differs from that of the scan" in status["problems"]["scan"], status
    lines = node.lines()
    robot.close()
    node.stop()
    assert len(lines) < 12, lines
    return f"{len(lines)} lines on stderr: " + " | ".join(line[:60] for line in lines)


def check_memory(seconds):
    """30 images and 90 transforms a second, as far as Python is fast enough: the memory does not grow.

    The library for DDS keeps the last 64 images, 39 MB, before it forgets any.
    """
    node, robot = Node(), new_robot()
    begin(robot)
    pose = next_pose(robot)
    metres = robot.take(pose)
    start, sizes, n = time.monotonic(), [], 0
    while time.monotonic() < start + seconds:
        robot.time += 1 / 30
        for i in range(3):
            robot.publish_tf(pose, robot.time + i / 100)
        robot.publish_image(metres, robot.time, "16UC1")
        n += 1
        robot.listen()
        sizes.append(node.resident_mb())
        time.sleep(max(0.0, start + n / 30 - time.monotonic()))
    status = robot.until("images", lambda status: status["images"] > 0)
    robot.close()
    node.stop()
    third = len(sizes) // 3
    early, late = max(sizes[third : 2 * third]), max(sizes[2 * third :])
    assert status["images"] > 0.5 * n, (status["images"], n)
    assert late < 160 and (not IS_FULL or late < 1.02 * early + 2), (early, late)
    return f"{status['images']} of {n} images in {seconds} s; at most {early:.0f} MB in the second third, {late:.0f} in the last"


def check_arm():
    """With an arm, every view comes with a joint trajectory, which begins where the last one ended."""
    base = ["robot.arm:=ur5e", "robot.world_from_base.translation_m:=[-0.5,0.0,-0.1]",
            "robot.world_from_base.rotation_xyzw:=[0.0,0.0,0.0,1.0]"]
    node, robot = Node(*base, views=3), new_robot()
    begin(robot)
    ends = []
    for _ in range(3):
        pose = next_pose(robot)
        trajectory = robot.latest["joint_trajectory"]
        assert len(trajectory.joint_names) == 6 and len(trajectory.points) == len(robot.latest["path"].poses)
        assert not ends or list(trajectory.points[0].positions) == ends[-1], trajectory
        ends.append(list(trajectory.points[-1].positions))
        reply = robot.capture(pose)
        assert reply.success, reply.message
        robot.until("plan", lambda status: status["busy"] == 0 and status["frames"] == len(ends))
        time.sleep(0.05)
    checked = check_bytes(robot)
    assert "joint_trajectory" in checked, checked
    robot.close()
    node.stop()
    return f"three views of a UR5e, {len(set(map(tuple, ends)))} places of its joints"


def check_auto_capture(reference):
    """With auto_capture, the robot only moves and rests."""
    node, robot = Node("auto_capture:=true", views=3), new_robot()
    begin(robot)
    taken = []
    for step in range(3):
        status = robot.until("view", lambda status: status["busy"] == 0 and status["frames"] == step)
        taken.append(status["view"])
        time.sleep(0.05)
        pose = next_pose(robot)
        metres = robot.take(pose)

        def stream():
            robot.time += 1 / 30
            robot.publish_tf(pose, robot.time)
            robot.publish_image(metres, robot.time)
            time.sleep(0.02)

        robot.until("frame", lambda status: status["frames"] == step + 1, meanwhile=stream)
    assert taken == reference["views"][:3], (taken, reference)
    robot.close()
    node.stop()
    return f"views {taken} taken by themselves"


if __name__ == "__main__":
    import numpy as np

    WALL = np.full(WIDTH * HEIGHT, 0.5, dtype="<f4")
    REFERENCE = json.loads(subprocess.run([CAMERA, "scan", str(VIEWS)], capture_output=True, check=True).stdout)
    INTRINSICS = REFERENCE["intrinsics"]
    checks = [
        ("ten views", lambda: check_ten_views(REFERENCE)),
        ("transforms", lambda: check_transforms(REFERENCE)),
        ("bad input", check_bad_input),
        ("auto_capture", lambda: check_auto_capture(REFERENCE)),
        ("arm", check_arm),
    ]
    if IS_FULL:
        checks.append(("restarts", lambda: check_restarts(REFERENCE)))
    checks.append(("memory", lambda: check_memory(60 if IS_FULL else 8)))
    chosen = [argument for argument in sys.argv[3:] if not argument.startswith("--")]
    for name, check in checks:
        if not chosen or name in chosen:
            print(f"{name}: {check()}", flush=True)
