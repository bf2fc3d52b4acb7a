#!/usr/bin/env python3
"""Changes files of an open scan, and a folder of scans between two starts.

    .ci/underneath.py target/release/nextview [--python PYTHON] [--node NODE CAMERA]

While a scan is open and has frames, its folder or its journal is removed, replaced by a copy, moved, or made
read-only; then it is given another frame. A cell of the table is "refused" if that was an error that states what
happened, and "kept" if it was acknowledged and is on the disk. If the change is undone, the scan must continue with
all frames. Then the frames or the record of a finished scan are changed, and a scan is started that continues it.
Last, folders of scans are reached under another spelling, from another working directory, and at another place. Fails
if an acknowledged frame is lost, or an error states something else. As root, the processes run as another user, whom
permissions bind.

Python needs an interpreter with the package, the node one with cyclonedds, or they are skipped.
"""

import argparse
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import soak
import two

TABLE = {**soak.LIVE, "live": {**soak.LIVE["live"], "table_z_m": -0.05}}
SAYS = re.compile(r"it was (removed|replaced|moved)|[Pp]ermission denied|[Rr]ead-only|No such file|cannot be read|holds ")
# Who is bound by permissions.
USER = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"] if os.geteuid() == 0 else []


def popen(command, **more):
    environment = {**os.environ, "HOME": "/nonexistent", "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}
    return subprocess.Popen([*USER, *map(str, command)], env=environment, text=True, **more)


class Server:
    """A server and its client."""

    def __init__(self, tools, work):
        self.program, self.dir, self.n_sent = tools.program, work / "scans", 0
        self.start(self.dir, work)

    def start(self, folder, cwd):
        command = [self.program, "serve", "--listen", "127.0.0.1:0", "--dir", folder]
        self.process = popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, cwd=cwd)
        self.client = soak.Client(self.process.stdout.readline().removeprefix("listening on ").strip())

    def begin(self, name, config=TABLE, **more):
        self.scan = name
        status, answer = self.client.ask("POST", "/scans", json.dumps({"id": name, **config, **more}))
        return status == 201, answer.decode()

    def folder(self):
        return self.dir / self.scan

    def take(self):
        status, answer = self.client.ask("GET", f"/scans/{self.scan}/next")
        if status != 200:
            return False, answer.decode()
        next_view = json.loads(answer)
        if next_view["state"] != "view":
            return False, answer.decode()
        pose = next_view["view"]["world_from_camera"]
        numbers = ",".join(repr(number) for row in pose for number in row)
        self.n_sent += 1
        query = f"id=frame-{self.n_sent}&world_from_camera={numbers}&width={soak.WIDTH}&height={soak.HEIGHT}&dtype=f32"
        path = f"/scans/{self.scan}/frames?{query}"
        status, answer = self.client.ask("POST", path, soak.depth_of(pose), "application/octet-stream")
        return status == 200, answer.decode()

    def finish(self):
        for _ in range(soak.LIVE["views"]):
            self.take()
        self.client.json("POST", f"/scans/{self.scan}/finish")

    def begin_after(self, base):
        return self.begin("after", {}, after=base.name)

    def stop(self):
        self.process.kill()
        self.process.communicate()


class Program:
    """A scan of the program, stopped after a frame."""

    def __init__(self, tools, work):
        self.program, self.work, self.process = tools.program, work, None
        (work / "scan.toml").write_text(soak.SCAN)

    def begin(self, name):
        self.out, self.printed = self.work / name, self.work / f"{name}.txt"
        command = [self.program, "scan", "builtin:bracket", "--config", "scan.toml", "--out", self.out]
        with self.printed.open("w") as printed:
            self.process = popen(command, stdout=printed, stderr=subprocess.STDOUT, cwd=self.work)
        while not soak.n_frames(self.printed):
            time.sleep(0.001)
        self.process.send_signal(signal.SIGSTOP)
        return True, ""

    def folder(self):
        return self.out

    def take(self):
        if self.process is None:  # it has ended with an error; the command that it named resumes it
            run = popen([self.program, "scan", "--resume", self.out], stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            said = run.communicate()[0]
            return run.returncode == 0, said
        # One frame may have been on its way.
        enough = soak.n_frames(self.printed) + 2
        self.process.send_signal(signal.SIGCONT)
        while self.process.poll() is None and soak.n_frames(self.printed) < enough:
            time.sleep(0.001)
        code = self.process.poll()
        self.stop()
        self.process = None
        return code is None or code == 0, self.printed.read_text()

    def begin_after(self, base):
        command = [self.program, "scan", "builtin:mug", "--after", base, "--views", "1", "--out", self.work / "after"]
        run = popen([*command, *BASE], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=self.work)
        said = run.communicate()[0]
        return run.returncode == 0, said

    def stop(self):
        if self.process:
            self.process.kill()
            self.process.wait()


# Of the program's scans that stand on a table.
BASE = ["--table", "fit", "--candidates", "30", "--voxel-size-m", "0.01", "--baselines", "off"]


class Python:
    """A program in Python that takes a frame for each line it is sent."""

    SOURCE = """\
import sys, warnings
import numpy as np
import nextview, soak
warnings.simplefilter("ignore")
out, after = sys.argv[1:]
camera = nextview.Camera(soak.WIDTH, soak.HEIGHT, fx=soak.FOCAL, fy=soak.FOCAL, cx=soak.WIDTH / 2 - 0.5, cy=soak.HEIGHT / 2 - 0.5)
more = {"after": after} if after else {}
try:
    box = [[-0.08] * 3, [0.08] * 3]
    scan = nextview.Scan(camera, box, views=5, voxel_size_m=0.01, candidates=40, table=-0.05, out=out, **more)
    print("begun", flush=True)
except nextview.NextviewError as error:
    sys.exit(print("error", error) or 1)
for _ in sys.stdin:
    try:
        view = scan.next_view()
        pose = view.world_from_camera
        depth = np.frombuffer(soak.depth_of(pose.tolist()), "<f4").reshape(soak.HEIGHT, soak.WIDTH)
        print("taken", len([scan.observe(depth, world_from_camera=view)]), flush=True)
    except nextview.NextviewError as error:
        print("error", str(error).replace("\\n", " "), flush=True)
"""

    def __init__(self, tools, work):
        self.python, self.work = tools.python, work
        path = f"import sys\nsys.path.append({str(pathlib.Path(__file__).parent.absolute())!r})\n"
        (work / "take.py").write_text(path + self.SOURCE)

    def begin(self, name, after=""):
        self.out = self.work / name
        command = [self.python, self.work / "take.py", self.out, after]
        self.process = popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        line = self.process.stdout.readline()
        return line.startswith("begun"), line

    def folder(self):
        return self.out

    def take(self):
        self.process.stdin.write("take\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        return line.startswith("taken"), line

    def begin_after(self, base):
        return self.begin("after", base)

    def stop(self):
        self.process.kill()
        self.process.communicate()


class Node:
    """The node of ROS 2 and a robot."""

    def __init__(self, tools, work):
        sys.path.append(str(pathlib.Path(__file__).parents[1] / "crates/nextview-ros2/checks"))
        import robot

        self.node, self.work = tools.node[0], work
        self.robot = robot.Robot(tools.node[1], (610.0, 610.0, 319.5, 239.5))

    def begin(self, name, *more):
        self.out = self.work / name
        given = ["live.box_m:=[-0.08,-0.08,-0.02,0.08,0.08,0.14]", "candidates:=40", "views:=5", f"directory:={self.out}"]
        words = [word for text in (*given, *more) for word in ("-p", text)]
        self.process = popen([self.node, "--ros-args", *words], stderr=subprocess.DEVNULL)
        ready = lambda status: (status["state"] == "view" or status["problems"]) and status["busy"] == 0  # noqa: E731
        status = self.robot.until("first view", ready, meanwhile=self.robot.publish_info)
        return status["state"] == "view", json.dumps(status["problems"])

    def folder(self):
        return self.out

    def take(self):
        self.robot.until("plan", lambda status: status["busy"] == 0)
        time.sleep(0.1)
        self.robot.listen()
        reply = self.robot.capture(self.robot.latest["next_view"].pose)
        return reply.success, reply.message

    def stop(self):
        self.process.kill()
        self.process.wait()
        self.robot.close()


def in_own_network():
    """Runs this again in a network of its own, where nobody disturbs the node."""
    if os.environ.get("NEXTVIEW_OWN_NETWORK") == "1":
        return
    script = 'ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo && exec "$@"'
    user = [] if os.geteuid() == 0 else ["--map-root-user"]
    os.environ["NEXTVIEW_OWN_NETWORK"] = "1"
    os.environ["CYCLONEDDS_URI"] = (
        "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo' multicast='true'/></Interfaces>"
        "<AllowMulticast>true</AllowMulticast></General></Domain></CycloneDDS>"
    )
    os.execvp("unshare", ["unshare", "--net", *user, "sh", "-c", script, "sh", sys.executable, *sys.argv])


def put_copy(path, aside):
    """A copy in the place of a file or folder, which goes aside."""
    path.rename(aside)
    shutil.copytree(aside, path) if aside.is_dir() else shutil.copy2(aside, path)


def change(path, how):
    """Changes it; what undoes that, none if nothing can."""
    aside = path.with_name(f"{path.name}-aside")
    if how == "removed":
        shutil.rmtree(path) if path.is_dir() else path.unlink()
        return None
    if how == "moved":
        path.rename(aside)
        return lambda: aside.rename(path)
    if how == "replaced":
        put_copy(path, aside)

        def back():
            shutil.rmtree(path) if path.is_dir() else path.unlink()
            aside.rename(path)

        return back
    mode = path.stat().st_mode
    path.chmod(mode & 0o555)
    return lambda: path.chmod(mode)


HOW = ("removed", "replaced", "moved", "read-only")


def in_the_open(kind, tools, work, what, how):
    """The cell of an open scan."""
    end = kind(tools, work)
    try:
        begun, said = end.begin("scan")
        if not begun or (kind is not Program and not all(end.take()[0] for _ in range(2))):
            return f"FAILED to begin: {said}"
        folder = end.folder()
        path = folder if what == "folder" else folder / "scan.journal"
        n_before = len(two.kept(folder))
        back = change(path, how)
        is_taken, said = end.take()
        if is_taken:
            n_acknowledged = soak.n_frames(end.printed) if kind is Program else n_before + 1
            n_kept = len(two.kept(folder))
            return "kept" if n_kept >= n_acknowledged else f"LOST: {n_kept} of {n_acknowledged} frames"
        if not SAYS.search(said):
            return f"UNCLEAR: {said}"
        if back:
            back()
            if len(two.kept(folder)) < n_before:
                return f"LOST: {len(two.kept(folder))} of {n_before} frames"
            is_taken, said = end.take()
            if not is_taken:
                return f"STUCK: {said}"
        return "refused"
    finally:
        end.stop()


def of_a_base(kind, tools, work, what, how, base):
    """The cell of a scan that goes on after a finished one."""
    end = kind(tools, work)
    own = work / ("scans/base" if kind is Server else "base")
    try:
        shutil.copytree(base, own)
        if kind is Server:
            shutil.copytree(base, own, dirs_exist_ok=True)
            end.stop()
            end.start(end.dir, work)
        files = sorted((own / "frames" / "depth").iterdir())
        path = own / "record.json" if what == "record" else files[0]
        if how == "replaced":
            record = json.loads((own / "record.json").read_text())
            record["steps"].pop()
            path.write_bytes(files[-1].read_bytes() if what == "frame" else json.dumps(record).encode())
        else:
            change(path, how)
        is_begun, said = end.begin_after(own)
        if is_begun:
            return "read"
        return "refused" if SAYS.search(said) or what == "record" and "line 1" in said else f"UNCLEAR: {said}"
    finally:
        end.stop()


def moved_data(tools, work):
    """Scans of a server, and one of the program, reached in other ways: what is wrong."""
    wrong, home = [], work / "home"
    home.mkdir()
    home.chmod(0o777)
    server = Server(tools, home)
    server.begin("ball")
    taken = sum(server.take()[0] for _ in range(3))
    server.stop()
    program = Program(tools, home)
    program.begin("part")
    n_printed = soak.n_frames(program.printed)
    program.stop()
    (work / "link").symlink_to(home)
    elsewhere = work / "elsewhere"

    def check(name, cwd, place, spelled):
        server.start(spelled, cwd)
        n = server.client.json("GET", "/scans/ball")["n_frames"]
        server.client.json("GET", "/scans/ball/next")
        n = server.client.json("GET", "/scans/ball")["n_frames"]
        server.stop()
        if n != taken:
            wrong.append(f"{name}: {n} of {taken} frames of the server")
        if len(two.kept(place / "part")) < n_printed:
            wrong.append(f"{name}: a frame of the program is gone")

    check("another spelling", home, home, "../home/./scans")
    check("a link", work, home, work / "link/scans")
    check("another working directory", "/", home, home / "scans")
    home.rename(elsewhere)
    check("another place", work, elsewhere, "elsewhere/scans")
    resume = popen([tools.program, "scan", "--resume", "../elsewhere/part"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=elsewhere)
    said = resume.communicate()[0]
    if resume.returncode:
        wrong.append(f"the program, resumed at another place: {said}")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--python", type=pathlib.Path, help="an interpreter with the package nextview")
    parser.add_argument("--node", nargs=2, help="the node, and the simulated camera of its checks")
    tools = parser.parse_args()
    tools.program = tools.program.absolute()
    kinds = [Server, Program]
    kinds += [Python] if tools.python else []
    try:
        import cyclonedds  # noqa: F401

        if tools.node:
            in_own_network()
            kinds.append(Node)
    except ImportError:
        tools.node = None
    for name, is_there in (("Python", tools.python), ("node", tools.node)):
        if not is_there:
            print(f"SKIPPED {name}: see --help", file=sys.stderr)
    failures = []
    print(f"{'what':<10}{'how':<12}" + "".join(f"{kind.__name__.lower():<12}" for kind in kinds))
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        root.chmod(0o755)

        def fresh(name):
            work = root / name
            work.mkdir()
            work.chmod(0o777)
            return work

        rows = [(what, how) for what in ("folder", "journal") for how in HOW]
        for what, how in rows:
            cells = [in_the_open(kind, tools, fresh(f"{what}-{how}-{kind.__name__}"), what, how) for kind in kinds]
            failures += [f"{what} {how}: {cell}" for cell in cells if cell not in ("refused", "kept")]
            print(f"{what:<10}{how:<12}" + "".join(f"{cell.split(':')[0]:<12}" for cell in cells), flush=True)
        # A finished scan of each kind, to go on after.
        server, base = Server(tools, fresh("bases")), {}
        server.begin("base")
        server.finish()
        server.stop()
        base[Server] = base[Python] = server.folder()
        base[Program] = root / "bases" / "mug"
        command = [tools.program, "scan", "builtin:mug", "--views", "3", "--out", base[Program], *BASE]
        subprocess.run([*USER, *map(str, command)], check=True, stdout=subprocess.DEVNULL)
        for what, how in [(what, how) for what in ("frame", "record") for how in HOW]:
            cells = []
            for kind in kinds:
                if kind in base:
                    cells.append(of_a_base(kind, tools, fresh(f"{what}-{how}-{kind.__name__}"), what, how, base[kind]))
                else:
                    cells.append("-")
            failures += [f"{what} {how}: {cell}" for cell in cells if cell not in ("refused", "read", "-")]
            print(f"{what:<10}{how:<12}" + "".join(f"{cell.split(':')[0]:<12}" for cell in cells), flush=True)
        wrong = moved_data(tools, fresh("moved"))
        print(f"moved data: {'nothing lost' if not wrong else 'FAILED'}")
    for failure in [*failures, *wrong]:
        print(failure, file=sys.stderr)
    sys.exit(bool(failures or wrong))


if __name__ == "__main__":
    main()
