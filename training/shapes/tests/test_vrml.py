import numpy as np
import pytest

import vrml
from meshes import Bad

NESTED = b"""#VRML V2.0 utf8
# A triangle in two transforms, and the same one used again, mirrored.
Transform {
  translation 10 0 0
  children [
    Transform {
      rotation 0 0 1 1.5707963267948966
      scale 2 1 1
      center 1 0 0
      children Shape {
        appearance Appearance { material DEF RED Material { diffuseColor 1 0 0 } }
        geometry DEF TRIANGLE IndexedFaceSet {
          creaseAngle 0.5
          coord Coordinate { point [ 0 0 0, 1 0 0, 0 1 0 ] }
          coordIndex [ 0, 1, 2, -1 ]
        }
      }
    }
    Switch { whichChoice 1 choice [
      Shape { geometry Box { } }
      Transform { scale -1 1 1 children [ Shape { geometry USE TRIANGLE appearance Appearance { material USE RED } } ] }
    ] }
  ]
}
Shape { geometry IndexedLineSet { coord Coordinate { point [ 5 5 5, 6 6 6 ] } coordIndex [ 0 1 -1 ] } }
"""


def test_nested_transforms_move_the_points():
    mesh = vrml.read(NESTED)
    # Stretched along x about x = 1, turned by a quarter about the same point, and moved by 10.
    first = [[11, -2, 0], [11, 0, 0], [10, -2, 0]]
    np.testing.assert_allclose(mesh.vertices[mesh.triangles[0]], first, atol=1e-12)


def test_what_a_mirror_shows_keeps_its_front():
    mesh = vrml.read(NESTED)
    assert len(mesh.triangles) == 2
    assert mesh.crosses()[1][2] == pytest.approx(1)
    np.testing.assert_allclose(sorted(map(tuple, mesh.vertices[mesh.triangles[1]])), [(9, 0, 0), (10, 0, 0), (10, 1, 0)])


def faces(fields):
    return f"#VRML V2.0 utf8\nShape {{ geometry IndexedFaceSet {{ {fields} }} }}".encode()


def test_a_polygon_with_a_dent_is_cut_within_it():
    points = "0 0 0, 4 0 0, 4 4 0, 2 1 0, 0 4 0"
    mesh = vrml.read(faces(f"coord Coordinate {{ point [{points}] }} coordIndex [0 1 2 3 4]"))
    assert len(mesh.triangles) == 3
    # 16 less the dent's 6: triangles across the dent would add up to more.
    assert np.abs(mesh.crosses()[:, 2]).sum() / 2 == pytest.approx(10)
    assert (mesh.crosses()[:, 2] > 0).all()


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (b"#VRML V1.0 ascii\n", "instead of b'#VRML V2.0'"),
        (b"#VRML V2.0 utf8\nShape { geometry Sphere { } }", "a Shape is a Sphere"),
        (b"#VRML V2.0 utf8\nShape { geometry USE NOTHING }", "USE NOTHING: no such DEF"),
        (b"#VRML V2.0 utf8\nGroup { children [", "ends within a node"),
        (faces("coord Coordinate { point [0 0 0, 1 0] }"), "5 numbers, no multiple of 3"),
        (faces("coord Coordinate { point [0 0 0] } coordIndex [0 0 1 -1]"), "outside 0 to 0"),
    ],
)
def test_a_wrong_file_says_what_is_wrong(data, why):
    with pytest.raises(Bad, match=why.replace("(", r"\(")):
        vrml.read(data)
