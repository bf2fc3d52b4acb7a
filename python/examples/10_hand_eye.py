"""Hand-eye calibration: where a camera sits on a robot's flange, from pictures of a ChArUco board.

Move the robot to a dozen poses that look at the board from several sides, turned about all axes. At each, take
a picture and note the pose of the flange. Here pictures are rendered, so that the answer is known.
"""

import sys
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
from numpy.typing import NDArray

try:
    import cv2
except ImportError as missing:
    print(f"SKIPPED 10_hand_eye: {missing}; it is installed by: pip install opencv-contrib-python-headless")
    sys.exit()

Matrix = NDArray[np.float64]

CAMERA = np.array([[900.0, 0.0, 639.5], [0.0, 900.0, 359.5], [0.0, 0.0, 1.0]])
"""Intrinsics of the colour camera, without distortion: with yours, state its coefficients below."""
DISTORTION = np.zeros(5)
BOARD = cv2.aruco.CharucoBoard(
    (8, 6), 0.030, 0.022, cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
)
"""8 x 6 squares of 30 mm; print `BOARD.generateImage(...)`, and measure the squares."""


def rigid(rotation: Matrix, translation: Matrix) -> Matrix:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, translation.ravel()
    return matrix


def camera_from_board(picture: NDArray[np.uint8]) -> Matrix | None:
    """The pose of the board in a picture; None if too little of it is seen."""
    corners, ids, _, _ = cv2.aruco.CharucoDetector(BOARD).detectBoard(picture)
    if ids is None or len(ids) < 12:
        return None
    on_board, in_picture = BOARD.matchImagePoints(corners, ids)
    found, turn, translation = cv2.solvePnP(on_board, in_picture, CAMERA, DISTORTION)
    return rigid(cv2.Rodrigues(turn)[0], translation) if found else None


def hand_eye(base_from_flange: list[Matrix], camera_from_boards: list[Matrix]) -> Matrix:
    """`flange_from_camera`, for a camera on the flange and a board that stays where it is.

    Between two pictures, flange and camera make the same motion, each in its own frame: A X = X B. Rotation and
    then translation are least squares over all pairs of pictures (Park and Martin 1994, IEEE T-RO 10(5)).
    """
    pairs = [(i, j) for i in range(len(base_from_flange)) for j in range(i)]
    a = [np.linalg.inv(base_from_flange[i]) @ base_from_flange[j] for i, j in pairs]
    b = [camera_from_boards[i] @ np.linalg.inv(camera_from_boards[j]) for i, j in pairs]
    turns_a, turns_b = (np.array([cv2.Rodrigues(m[:3, :3])[0].ravel() for m in motions]) for motions in (a, b))
    u, _, vt = np.linalg.svd(turns_a.T @ turns_b)
    rotation = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    left = np.vstack([m[:3, :3] - np.eye(3) for m in a])
    right = np.hstack([rotation @ n[:3, 3] - m[:3, 3] for m, n in zip(a, b, strict=True)])
    return rigid(rotation, np.linalg.lstsq(left, right, rcond=None)[0])


# --- Stand-ins for your robot and your camera: known poses, and pictures of a board on a table.
true_flange_from_camera = rigid(cv2.Rodrigues(np.array([0.1, -0.05, 1.6]))[0], np.array([0.04, -0.02, 0.07]))
base_from_board = rigid(cv2.Rodrigues(np.array([np.pi, 0.0, 0.3]))[0], np.array([0.45, -0.1, 0.0]))
PIXELS_PER_M = 10_000
SHEET = BOARD.generateImage((2400, 1800))
rng = np.random.default_rng(1)


def picture_from(base_from_camera: Matrix) -> NDArray[np.uint8]:
    pose = np.linalg.inv(base_from_camera) @ base_from_board
    picture_from_sheet = CAMERA @ pose[:3, [0, 1, 3]] @ np.diag([1 / PIXELS_PER_M, 1 / PIXELS_PER_M, 1.0])
    # A pixel's centre is at integer coordinates on the sheet as in the picture.
    picture_from_sheet = picture_from_sheet @ np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [0.0, 0.0, 1.0]])
    size, flags = (1280, 720), cv2.INTER_AREA
    picture = cv2.warpPerspective(SHEET, picture_from_sheet, size, flags=flags, borderValue=128)
    noisy: Matrix = cv2.GaussianBlur(picture, (0, 0), 0.8) + rng.normal(0.0, 3.0, picture.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8)


def looking_at_board() -> Matrix:
    middle = base_from_board @ [0.12, 0.09, 0.0, 1.0]
    position = middle[:3] + rng.uniform([-0.2, -0.2, 0.3], [0.2, 0.2, 0.45])
    ahead = (middle[:3] - position) / np.linalg.norm(middle[:3] - position)
    right = np.cross(ahead, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    upright = rigid(np.column_stack([right, np.cross(ahead, right), ahead]), position)
    return upright @ rigid(cv2.Rodrigues(np.array([0.0, 0.0, rng.uniform(-1.2, 1.2)]))[0], np.zeros(3))


# --- The calibration.
flange_poses, boards = [], []
for _ in range(15):
    base_from_camera = looking_at_board()
    seen = camera_from_board(picture_from(base_from_camera))
    if seen is not None:
        flange_poses.append(base_from_camera @ np.linalg.inv(true_flange_from_camera))
        boards.append(seen)
assert len(boards) >= 10, "the board was seen from too few sides"
found_flange_from_camera = hand_eye(flange_poses, boards)

# The board is where it was, seen from every pose: how far these differ is what you know without the truth.
places = [base @ found_flange_from_camera @ board for base, board in zip(flange_poses, boards, strict=True)]
spread_mm = 1e3 * np.std([place[:3, 3] for place in places], axis=0).max()
error = np.linalg.inv(true_flange_from_camera) @ found_flange_from_camera
error_mm = 1e3 * np.linalg.norm(error[:3, 3])
error_deg = np.degrees(np.linalg.norm(cv2.Rodrigues(error[:3, :3])[0]))
print(f"{len(boards)} pictures: the board's place varies by {spread_mm:.2f} mm")
print(f"the camera is off by {error_mm:.2f} mm and {error_deg:.3f} degrees")
path = Path(mkdtemp()) / "flange_from_camera.txt"
np.savetxt(path, found_flange_from_camera)
print(f"{path} is for: nextview scan ... --hand-eye FILE")
assert spread_mm < 1.0 and error_mm < 1.0 and error_deg < 0.1
