"""Scans through `nextview serve` with only the standard library; here, a simulated robot takes the place of
yours.

Usage: 09_server.py [ADDRESS [TOKEN]], by default http://127.0.0.1:7878, where no token is needed.
"""

import json
import sys
import urllib.parse
import urllib.request
from typing import Any

import numpy as np

import nextview

server = sys.argv[1] if len(sys.argv) > 1 else "http://127.0.0.1:7878"
token = {"Authorization": f"Bearer {sys.argv[2]}"} if len(sys.argv) > 2 else {}


def ask(method: str, path: str, body: bytes | None = None, kind: str = "application/json") -> Any:
    headers = {"Content-Type": kind, **token}
    request = urllib.request.Request(server + path, data=body, headers=headers, method=method)
    with urllib.request.urlopen(request) as answer:
        return json.load(answer)


# A mug before a RealSense D435i with its noise: replace it by your robot and your camera.
robot = nextview.SimulatedScene("builtin:mug", sensor="d435i")
camera = robot.camera
lowest, highest = robot.box_m
live = {"box_m": [*lowest, *highest], "max_depth_m": camera.depth_range_m[1]}
optics = {key: getattr(camera, key) for key in ("width", "height", "fx", "fy", "cx", "cy")}
new = {"object": "mug", "views": 6, "candidates": 200, "camera": optics, "live": live}
scan = "/scans/" + ask("POST", "/scans", json.dumps(new).encode())["id"]

while (answer := ask("GET", scan + "/next"))["state"] == "view":
    view = answer["view"]
    depth, world_from_camera = robot.frame(np.array(view["world_from_camera"]))
    query = {
        "id": f"view-{view['view']}",
        "world_from_camera": ",".join(repr(float(number)) for number in world_from_camera.flat),
        "width": camera.width,
        "height": camera.height,
        "dtype": "f32",
    }
    frame = np.ascontiguousarray(depth, "<f4").tobytes()
    path = scan + "/frames?" + urllib.parse.urlencode(query)
    step = ask("POST", path, frame, "application/octet-stream")
    print(f"view {step['view']}: {step['new_voxels']} new voxels, {step['occupied_voxels']} in all")

finished = ask("POST", scan + "/finish")
print(f"stopped by {answer['stop_reason']}; {server}{scan}/files/mesh.ply")
assert finished["record"]["views"] == 6 and "mesh.ply" in finished["files"]
