"""Compares forward kinematics of all presets with Pinocchio's, from the same URDF files.

    cargo build -p nextview-robot --example kinematics
    pip install pin
    python check_pin.py PROGRAM

PROGRAM is the example `kinematics`. Exits with 1 if any of 1000 random poses of an arm differs by more than
1e-9, in metres or in any entry of the rotation's matrix.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pinocchio

TOLERANCE = 1e-9
N_POSES = 1000


def largest_difference(program: str, urdf: Path) -> float:
    model = pinocchio.buildModelFromUrdf(str(urdf))
    data = model.createData()
    tool = model.getFrameId("tool0")
    random = np.random.default_rng(1)
    drawn = random.uniform(model.lowerPositionLimit, model.upperPositionLimit, (N_POSES, model.nq))
    lines = "".join(" ".join(map(repr, map(float, values))) + "\n" for values in drawn)
    done = subprocess.run([program, urdf.stem], input=lines, capture_output=True, text=True, check=True)
    poses = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(poses) == N_POSES
    largest = 0.0
    for values, pose in zip(drawn, poses):
        pinocchio.forwardKinematics(model, data, values)
        expected = pinocchio.updateFramePlacement(model, data, tool)
        rotation = pinocchio.Quaternion(np.array(pose["rotation_xyzw"])).toRotationMatrix()
        largest = max(
            largest,
            np.abs(rotation - expected.rotation).max(),
            np.abs(np.array(pose["translation_m"]) - expected.translation).max(),
        )
    return largest


def main() -> int:
    presets = sorted((Path(__file__).parent.parent / "presets").glob("*.urdf"))
    assert presets, "no presets"
    differences = {urdf.stem: largest_difference(sys.argv[1], urdf) for urdf in presets}
    for name, difference in differences.items():
        print(f"{name}: {difference:.1e} over {N_POSES} poses")
    return int(max(differences.values()) > TOLERANCE)


sys.exit(main())
