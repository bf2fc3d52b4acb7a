import numpy as np
import pytest

import shapes
from meshes import Bad, Mesh, odd_lines, ply, read_obj, read_stl, signature

CUBE = b"""v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
f 4/1 3/2 2/3 1/4\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf -8 -4 -1 -5\n"""


def ball(n=24, scale=(1, 1, 1), of=1.0):
    """A ball, or its upper share, of 2 n (n - 1) triangles."""
    up, around = np.meshgrid(np.linspace(0, np.pi * of, n), np.linspace(0, 2 * np.pi, n + 1)[:-1], indexing="ij")
    points = np.stack([np.sin(up) * np.cos(around), np.sin(up) * np.sin(around), np.cos(up)], axis=2).reshape(-1, 3)
    a = (np.arange(n - 1)[:, None] * n + np.arange(n)).ravel()
    b = (np.arange(n - 1)[:, None] * n + (np.arange(n) + 1) % n).ravel()
    return Mesh(points * scale, np.concatenate([np.stack([a, a + n, b], 1), np.stack([b, a + n, b + n], 1)])).welded()


def test_obj_has_polygons_and_numbers_that_count_back():
    mesh = read_obj(CUBE)
    assert len(mesh.triangles) == 12
    assert np.abs(mesh.crosses()).sum() / 2 == pytest.approx(6)
    np.testing.assert_allclose(mesh.crosses().sum(0), 0)


@pytest.mark.parametrize(("data", "why"), [(b"v 0 0 zero\n", "line 1"), (b"v 0 0 0\nf 1 1 2\n", "outside 1 to 1")])
def test_a_wrong_obj_says_what_is_wrong(data, why):
    with pytest.raises(Bad, match=why):
        read_obj(data)


def test_stl_is_read_and_must_have_its_length():
    record = np.zeros(1, [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    record["corners"] = [[0, 0, 0], [2, 0, 0], [0, 2, 0]]
    data = bytes(80) + (1).to_bytes(4, "little") + record.tobytes()
    assert read_stl(data).sides().tolist() == [2, 2, 0]
    with pytest.raises(Bad, match="133 bytes, where 1 triangles take 134"):
        read_stl(data[:-1])


def test_welding_makes_one_of_equal_corners_and_drops_what_has_no_area():
    cube = read_obj(CUBE)
    soup = Mesh(cube.vertices[cube.triangles].reshape(-1, 3), np.arange(36).reshape(-1, 3))
    doubled = Mesh(soup.vertices, np.concatenate([soup.triangles, soup.triangles[:, ::-1], [[0, 0, 1]]]))
    mesh = doubled.welded()
    assert (len(mesh.vertices), len(mesh.triangles)) == (8, 12)


def test_a_closed_surface_has_no_odd_lines_and_a_sheet_has():
    assert odd_lines(ball()) == 0
    seams = ball()
    seams = Mesh(seams.vertices[seams.triangles].reshape(-1, 3), np.arange(3 * len(seams.triangles)).reshape(-1, 3))
    assert odd_lines(seams) == 0
    # A thin cup: vertical lines meet it once, others twice.
    assert 0.3 < odd_lines(ball(of=0.5)) < 0.6


@pytest.mark.parametrize(
    ("mesh", "why"),
    [
        (ball(), None),
        (ball(scale=(1, 0.3, 0.11)), None),
        (ball(scale=(1, 0.3, 0.09)), "flat"),
        (ball(8), "few triangles"),
        (ball(of=0.5), "open"),
        (Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]])).welded(), "no surface"),
    ],
)
def test_filters_name_their_reason(mesh, why):
    assert shapes.fault(mesh) == why


def test_the_signature_knows_copies_of_any_size_and_place():
    mesh = ball(scale=(3, 2, 1))
    copy = Mesh(mesh.vertices[:, [1, 2, 0]] * 0.01 + 5, mesh.triangles)
    np.testing.assert_allclose(signature(copy), signature(mesh), atol=1e-4)
    assert np.abs(signature(ball(scale=(3, 2, 1.2))) - signature(mesh)).max() > 0.02


def test_ply_has_single_precision_and_its_unit():
    data = ply(read_obj(CUBE))
    header, body = data.split(b"end_header\n")
    assert b"comment unit: metres" in header
    assert len(body) == 8 * 12 + 12 * 13
