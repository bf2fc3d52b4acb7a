"""Wrong input: an exception of ours that says what was expected and what came, and never an abort."""

from __future__ import annotations

import ctypes
import gc
import itertools
import resource
from pathlib import Path
from typing import Any

import hypothesis.extra.numpy as hnp
import numpy as np
import pytest
from conftest import BOX, CAMERA, begin
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import nextview
from hostile_values import EndlessList, cyclic_dict, cyclic_list, nested

NOTHING = np.full((60, 80), np.inf, dtype=np.float32)
FLIPPED = np.diag([1.0, 1.0, -1.0, 1.0])
SHIFTED = np.eye(4)
SHIFTED[:3, 3] = [np.nan, 0, 0]
POSE = np.diag([1.0, -1.0, -1.0, 1.0])
POSE[2, 3] = 0.4
BOTTOM = np.eye(4)
BOTTOM[3, 0] = 0.5


def unaligned(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """The same numbers, a byte off where numbers of their size begin."""
    moved = np.frombuffer(b"\0" + array.tobytes(), array.dtype, offset=1)
    return moved.reshape(array.shape)


UNALIGNED = unaligned(NOTHING)
PACKED = np.zeros((60, 80), [("flag", np.uint8), ("depth", np.float32), ("units", np.uint16)])

def huge(value: Any, *more: int) -> Any:
    """An array of 2^40 elements, which takes the memory of one."""
    return np.broadcast_to(value, (2**20, 2**20, *more))


WRONG_FRAMES: list[tuple[dict[str, Any], str]] = [
    ({"depth": NOTHING.astype(np.float64)}, "`depth` has the type float64, expected an array of height x"),
    ({"depth": NOTHING[0]}, r"`depth` has the shape \[80\]"),
    ({"depth": [[1.0]]}, "`depth` is of type list"),
    ({"depth": NOTHING.T}, "`depth` is 60 x 80, expected 80 x 60 pixels"),
    ({"depth": np.zeros((60, 80), np.uint16)}, "which needs `depth_scale_m`"),
    ({"depth": NOTHING, "depth_scale_m": 0.001}, "float32 is in metres"),
    ({"depth": np.zeros((60, 80), np.uint16), "depth_scale_m": -1.0}, "`depth_scale_m` is -1, expected"),
    ({"depth": NOTHING.astype(">f4")}, "`depth` has the type >f4"),
    ({"world_from_camera": np.eye(4, dtype=np.float32)}, "has the type float32, expected a 4 x 4 array of float64"),
    ({"world_from_camera": np.eye(3)}, r"has the shape \[3, 3\], expected a 4 x 4"),
    ({"world_from_camera": SHIFTED}, "an entry is NaN, expected finite numbers"),
    ({"world_from_camera": FLIPPED}, "the rotation mirrors: its determinant is -1"),
    ({"world_from_camera": 2 * np.eye(4)}, "the last row is"),
    ({"world_from_camera": np.diag([1.1, 1.0, 1.0, 1.0])}, "the rotation is not rigid"),
    ({"world_from_camera": BOTTOM}, r"the last row is \[0.5, 0.0, 0.0, 1.0\], expected 0 0 0 1; is the"),
    ({"world_from_camera": None}, "a frame without a pose cannot be placed"),
    ({"color": np.zeros((60, 80), np.uint8)}, r"`color` has the shape \[60, 80\]"),
    ({"color": np.zeros((60, 80, 3), np.float32)}, "`color` has the type float32, expected a uint8"),
    ({"color": np.zeros((30, 80, 3), np.uint8)}, "`color` is 80 x 30, expected 80 x 60 pixels"),
    ({"mask": np.zeros((60, 80), np.uint8)}, "`mask` has the type uint8, expected a bool array"),
    ({"depth": UNALIGNED}, r"`depth` is not aligned in memory: pass np.require\(depth, requirements='A'\)"),
    ({"depth": PACKED["depth"]}, "`depth` is not aligned in memory"),
    ({"depth": PACKED["units"], "depth_scale_m": 0.001}, "`depth` is not aligned in memory"),
    ({"world_from_camera": unaligned(np.eye(4))}, "`world_from_camera` is not aligned in memory"),
    ({"depth": np.ma.MaskedArray(NOTHING, mask=True)}, "is a masked array, .*`mask`=np.ma.getmaskarray"),
    ({"depth": huge(np.float32(1))}, "`depth` is 1048576 x 1048576, expected 80 x 60 pixels, as the camera"),
    ({"depth": huge(np.uint16(1)), "depth_scale_m": 0.001}, "`depth` is 1048576 x 1048576, expected 80 x 60"),
    ({"color": huge(np.uint8(1), 3)}, "`color` is 1048576 x 1048576, expected 80 x 60 pixels"),
    ({"mask": huge(np.bool_(True))}, r"`mask` has the shape \[1048576, 1048576\], expected \[60, 80\]"),
    ({"world_from_camera": huge(1.0)}, r"has the shape \[1048576, 1048576\], expected a 4 x 4"),
    ({"mask": np.zeros((80, 60), bool)}, r"`mask` has the shape \[80, 60\], expected \[60, 80\]"),
]


@pytest.mark.parametrize(("wrong", "expected"), WRONG_FRAMES)
def test_a_wrong_frame_changes_nothing(wrong: dict[str, Any], expected: str) -> None:
    scan = begin()
    frame = {"depth": NOTHING, "world_from_camera": np.eye(4), **wrong}
    with pytest.raises(nextview.InputError, match=expected):
        scan.observe(**frame)
    assert scan.steps == []


WRONG_SCANS: list[tuple[dict[str, Any], str]] = [
    ({"planner": "best"}, '`planner` is "best", expected one of most-surface'),
    ({"voxel_size_m": float("nan")}, "`voxel_size_m` is NaN, expected a positive number of metres"),
    ({"voxel_size_m": 1e-5}, "voxel"),
    ({"views": 0}, "`views` is 0, expected 1 to 40"),
    ({"views": 1 << 70}, "`views` is of type int, or out of range"),
    ({"box": [0, 1]}, r"`box` has the shape \[2\], expected its lowest and its highest corner"),
    ({"box": np.transpose(BOX)}, r"`box` has the shape \[3, 2\], expected its lowest and its highest"),
    ({"poses": []}, "`poses` is empty, expected at least one pose .hint: without `poses`, `view_space`"),
    ({"object": "builtin:mug"}, "`object` is not an option of a scan by your own camera, use `name`"),
    ({"live": {"table_z_m": 0.0}}, "`live` is not an option of a scan by your own camera, use `box`, `table`"),
    ({"object_box": {"table": "fit"}}, "`object_box.table` is not an option .*, use `table`"),
    ({"unit": "mm"}, "`unit` is for simulations, not for a camera of your own"),
    ({"candidates": -1}, "`candidates` is -1, expected a whole number, at least 0"),
    ({"stop": 3}, "`stop` is 3, expected a table"),
    ({"box": "here"}, "`box` is 'here'"),
    ({"box": [[0, 0, 0], [0, 0, 0]]}, "`box` is .*, expected finite corners, the lowest first"),
    ({"box": None}, "the pose of a view that shows part of it is needed"),
    ({"table": "found"}, '`object_box.table` is "found"'),
    ({"table": float("inf")}, "`table` is inf, expected a finite number of metres"),
    ({"plannner": 1}, "`plannner` is not a key .hint: did you mean `planner`"),
    ({"stop": {"completenes": 1}}, "did you mean `stop.completeness`"),
    ({"noise": {"model": "d435i"}}, "`noise` is for simulations"),
    ({"planner": "clairvoyant"}, "needs the true object"),
    ({"camera": 3}, "`camera` is of type int"),
    ({"poses": [np.eye(4), np.eye(3)]}, r"`poses\[1\]` has the shape"),
    ({"options": {1: 2}}, "a key of the configuration is 1"),
    ({"seed": object()}, "`seed` is of type object"),
    ({"stop": cyclic_dict()}, "`stop.a.* is nested too deeply, expected at most 40 .*; does it contain itself"),
    ({"stop": nested(lambda value: {"a": value}, 10_000)}, r"`stop.a.a.* is nested too deeply"),
    ({"stop": nested(lambda value: (value,), 10_000)}, "`stop` is nested too deeply"),
    ({"stop": nested(lambda value: [value, value], 30)}, "`stop` is too large for a configuration"),
    ({"stop": cyclic_list(2)}, "`stop` is nested too deeply"),
    ({"stop": EndlessList([1.0])}, "`stop` is too large for a configuration, expected at most 1048576 bytes"),
    ({"reach": {"base_m": np.zeros(3)}}, r"`reach.base_m` is an array of the shape \[3\], .* `tolist"),
    ({"seed": huge(1.0)}, r"`seed` has the shape \[1048576, 1048576\], expected a 4 x 4"),
    ({"box": huge(1.0)}, r"`box` has the shape \[1048576, 1048576\], expected its lowest"),
    ({"poses": itertools.repeat(np.eye(4))}, "`poses` has more than 100000 entries"),
    ({"unit": "\ud800"}, "`unit` is '.ud800', expected Unicode characters"),
    ({"unit": "m" * 5000}, "`unit` is a string of 5000 bytes, expected at most 4096"),
]


@pytest.mark.parametrize(("wrong", "expected"), WRONG_SCANS)
def test_a_wrong_scan_is_refused(wrong: dict[str, Any], expected: str) -> None:
    options = {"camera": CAMERA, "box": BOX, "candidates": 40, **wrong}
    with pytest.raises(nextview.InputError, match=expected) as caught:
        nextview.Scan(**options)
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, nextview.NextviewError)


def test_wrong_cameras_are_refused() -> None:
    good: dict[str, Any] = {"width": 8, "height": 6, "fx": 5.0, "fy": 5.0, "cx": 4.0, "cy": 3.0}
    nextview.Camera(**good)
    wrongs: list[dict[str, Any]] = [
        {"width": 0},
        {"fx": float("nan")},
        {"cx": float("inf")},
        {"distortion": [0.1] * 6},
        {"distortion": [float("nan")]},
        {"distortion_model": "fisheye"},
        {"depth_range_m": (1.0, 0.5)},
    ]
    for wrong in wrongs:
        with pytest.raises(nextview.InputError):
            nextview.Camera(**{**good, **wrong})
    with pytest.raises(nextview.InputError, match="expected d405"):
        nextview.Camera.sensor("d999")


def test_wrong_maps_are_refused(tmp_path: Path) -> None:
    state, p = np.full((2, 2, 2), nextview.Map.OCCUPIED, np.uint8), np.full((2, 2, 2), 0.9, np.float32)
    for wrong, expected in [
        ({"probability": unaligned(p)}, "`probability` is not aligned in memory"),
        ({"probability": p.astype(np.float64)}, "`probability`: expected a grid of X x Y x Z of float32"),
        ({"occupancy": state[0]}, "`occupancy`: expected a grid of X x Y x Z of uint8"),
        ({"occupancy": huge(np.uint8(2), 2)}, "`occupancy` has the shape .*, expected at most 67108864"),
        ({"origin_m": [0.0, 0.0]}, r"`origin_m` has the shape \[2\], expected 3 numbers, metres"),
    ]:
        sound = {"occupancy": state, "probability": p, "origin_m": np.zeros(3), "voxel_size_m": 0.01}
        grid = nextview.Map(**{**sound, **wrong})  # type: ignore[arg-type]
        with pytest.raises(nextview.InputError, match=expected):
            grid.save(tmp_path / "map.ot")


def test_states_and_probabilities_may_be_in_the_same_memory(tmp_path: Path) -> None:
    """Of zero strides, which tell nothing about where they meet."""
    memory = np.frombuffer(np.float32(0.9).tobytes(), np.uint8)
    state = np.broadcast_to(memory[:1], (2, 2, 2))
    p = np.broadcast_to(memory.view(np.float32), (2, 2, 2))
    nextview.Map(state, p, np.zeros(3), 0.01).save(tmp_path / "map.ot")
    assert (nextview.Map.load(tmp_path / "map.ot").occupancy == nextview.Map.OCCUPIED).all()


def test_a_mask_is_true_where_its_bytes_are_not_0() -> None:
    scan, plain = begin(), begin()
    near = np.full((60, 80), 0.3, np.float32)
    scan.observe(near, POSE, mask=np.full((60, 80), 6, np.uint8).view(bool))
    plain.observe(near, POSE, mask=np.ones((60, 80), bool))
    assert scan.map is not None and plain.map is not None
    np.testing.assert_array_equal(scan.map.probability, plain.map.probability)


def test_what_a_value_raises_itself_is_passed_on() -> None:
    class Number:
        def __float__(self) -> float:
            raise RuntimeError("no number today")

    with pytest.raises(RuntimeError, match="no number today"):
        begin(voxel_size_m=Number())


def test_an_empty_list_of_objects_is_refused() -> None:
    for given, objects in [({"name": "x", "objects": []}, None), ("paper-1", [])]:
        with pytest.raises(nextview.InputError, match="objects`? is empty, expected at least one"):
            nextview.bench(given, objects)  # type: ignore[arg-type]
    with pytest.raises(nextview.InputError, match="`objects` is of type str, expected a list"):
        nextview.bench("paper-1", "builtin:mug")


def test_files_that_are_not_there_are_data_errors(tmp_path: Path) -> None:
    with pytest.raises(nextview.DataError, match="no.ply"):
        nextview.scan(tmp_path / "no.ply")
    with pytest.raises(nextview.DataError) as caught:
        nextview.resume(tmp_path)
    assert caught.value.faults[0]["place"]["file"] == str(tmp_path)
    with pytest.raises(nextview.InputError, match="no built-in object 'cup'"):
        nextview.SimulatedScene("builtin:cup")


def test_every_exception_is_one_of_ours_and_can_be_pickled() -> None:
    import pickle

    for kind in (nextview.InputError, nextview.DataError, nextview.InternalError):
        error = kind("a text", [{"message": "a text"}])
        copy = pickle.loads(pickle.dumps(error))
        assert type(copy) is kind and str(copy) == "a text" and copy.faults == error.faults
        assert isinstance(error, nextview.NextviewError)


def release_large_blocks() -> None:
    """From now on, glibc gives large blocks back when they are released, whatever came before: by itself, it
    keeps up to 32 MB of them once it has released one (M_MMAP_THRESHOLD in mallopt(3)).
    """
    set_option = getattr(ctypes.CDLL(None), "mallopt", None)
    if set_option is not None:
        set_option(-3, 128 * 1024)


def resident_mb() -> float:
    """Memory that the process holds now."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1e3
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


ARRAYS = hnp.arrays(
    dtype=st.sampled_from([np.float32, np.float64, np.uint16, np.uint8, np.int32, np.bool_, np.complex64]),
    shape=st.one_of(st.just((4, 4)), st.just((6, 8)), hnp.array_shapes(min_dims=0, max_dims=4, max_side=8)),
)
PLAIN = st.one_of(st.none(), st.integers(), st.floats(), st.text(max_size=5))
VALUES = st.one_of(ARRAYS, PLAIN, st.lists(st.floats(), max_size=4))
KEYS = st.sampled_from(
    ["planner", "voxel_size_m", "candidates", "stop", "map", "seed", "live", "camera", "object_box"]
)
SMALL = nextview.Camera(8, 6, fx=7.0, fy=7.0, cx=3.5, cy=2.5)


ALLOWED = (nextview.NextviewError, TypeError, OverflowError)
Input = tuple[Any, Any, Any, Any, Any, dict[str, Any]]


def observed(scan: nextview.Scan, wrong: Input) -> None:
    """A frame of this input: an exception of the allowed ones, or none."""
    depth, pose, color, scale, mask, _ = wrong
    try:
        scan.observe(depth, pose, color, depth_scale_m=scale, mask=mask)
    except ALLOWED:
        pass


def begun(wrong: Input) -> None:
    """A scan of this input."""
    options = {"candidates": 5, "voxel_size_m": 0.02, **wrong[5]}
    try:
        nextview.Scan(options.pop("camera", SMALL), BOX if wrong[4] is None else wrong[4], **options)
    except ALLOWED:
        pass


def test_no_wrong_input_aborts_or_leaks() -> None:
    """10,000 calls. What hypothesis itself keeps of its examples is none of the package's memory."""
    release_large_blocks()
    scan = nextview.Scan(SMALL, BOX, candidates=5, voxel_size_m=0.02)
    inputs: list[Input] = []
    every = list(HealthCheck)

    @settings(max_examples=1000, database=None, deadline=None, suppress_health_check=every)
    @given(st.tuples(VALUES, VALUES, VALUES, VALUES, VALUES, st.dictionaries(KEYS, VALUES, max_size=3)))
    def call(wrong: Input) -> None:
        observed(scan, wrong)
        inputs.append(wrong)

    call()
    for wrong in inputs[:100]:
        begun(wrong)
    gc.collect()
    before = resident_mb()
    for i in range(10_000):
        wrong = inputs[i % len(inputs)]
        if i % 20 == 0:
            begun(wrong)
        else:
            observed(scan, wrong)
    gc.collect()
    growth = resident_mb() - before
    print(f"memory after 10,000 calls: {growth:+.1f} MB")
    assert growth < 5.0
