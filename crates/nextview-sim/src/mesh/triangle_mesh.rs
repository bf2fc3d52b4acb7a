use super::{Appearance, srgb};
use crate::SimError;
use glam::DVec3;
use nextview::geometry::{Aabb, Pose};
use std::sync::Arc;

/// A surface made of triangles, in metres.
///
/// It has at least one triangle; every triangle has an area and refers to existing vertices; all vertices are
/// finite. It need not be closed, and the triangles' sides have no meaning. It may have colours.
///
/// ```
/// use glam::DVec3;
/// use nextview_sim::mesh::TriangleMesh;
///
/// let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
/// let mesh = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 1, 1]]).unwrap();
/// assert_eq!((mesh.triangles().len(), mesh.n_degenerate()), (1, 1));
/// assert_eq!(mesh.scaled(2.0).unwrap().area(), 2.0);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    n_degenerate: usize,
    bounds: Aabb,
    area: f64,
    appearance: Option<Arc<Appearance>>,
}

impl TriangleMesh {
    /// Upper bound of coordinates, which keeps areas and distances finite.
    const MAX_COORDINATE: f64 = 1e30;

    /// Creates a mesh from vertices in metres and triangles of three vertex indices each, counted from 0.
    ///
    /// Degenerate triangles (without an area) are dropped and counted. Fails on a vertex that is not finite
    /// or beyond 1e30 m, on an index out of range, and if no triangle is left.
    pub fn new(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Self, SimError> {
        Self::with_appearance(vertices, triangles, None)
    }

    /// Creates a mesh with colours. Also fails if their lists do not fit the given vertices and triangles.
    pub fn colored(
        vertices: Vec<DVec3>,
        triangles: Vec<[u32; 3]>,
        appearance: Appearance,
    ) -> Result<Self, SimError> {
        appearance.check(vertices.len(), triangles.len())?;
        Self::with_appearance(vertices, triangles, Some(Arc::new(appearance)))
    }

    fn with_appearance(
        vertices: Vec<DVec3>,
        mut triangles: Vec<[u32; 3]>,
        mut appearance: Option<Arc<Appearance>>,
    ) -> Result<Self, SimError> {
        check_vertices(&vertices)?;
        check_indices(vertices.len(), &triangles)?;
        let n_given = triangles.len();
        let has_area = |t: &[u32; 3]| area(corners(&vertices, t)) > 0.0;
        if let Some(shared) = appearance.as_mut().filter(|look| !look.faces.is_empty())
            && !triangles.iter().all(has_area)
        {
            let mut of_triangle = triangles.iter();
            Arc::make_mut(shared).faces.retain(|_| of_triangle.next().is_some_and(has_area));
        }
        triangles.retain(has_area);
        let n_degenerate = n_given - triangles.len();
        let used = triangles.iter().flat_map(|t| corners(&vertices, t));
        let bounds = Aabb::around(used).ok_or(SimError::NoFaces { n_degenerate })?;
        let area = triangles.iter().map(|t| area(corners(&vertices, t))).sum();
        Ok(Self { vertices, triangles, n_degenerate, bounds, area, appearance })
    }

    /// Returns the vertices in metres; some may belong to no triangle.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Returns the triangles: three indices into [`vertices`](Self::vertices) each.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Returns the corners of triangle `i`, which must be below the number of triangles.
    pub fn corners(&self, i: usize) -> [DVec3; 3] {
        corners(&self.vertices, &self.triangles[i])
    }

    /// Returns the mesh's colours; `None` if it has none.
    pub fn appearance(&self) -> Option<&Appearance> {
        self.appearance.as_deref()
    }

    /// Returns the colour (sRGB) of a point of triangle `i`, which must be below the number of triangles. The
    /// weights of its corners add up to 1. `None` if the mesh has no colours.
    pub fn color(&self, i: usize, weights: [f64; 3]) -> Option<[u8; 3]> {
        self.light(i, weights).map(srgb::to_color)
    }

    /// The colour of a point as linear light, 0 to 1.
    pub(crate) fn light(&self, i: usize, weights: [f64; 3]) -> Option<[f32; 3]> {
        self.appearance.as_ref().map(|look| look.light(self.triangles[i], i, weights))
    }

    /// Returns the number of triangles dropped for lack of area.
    pub fn n_degenerate(&self) -> usize {
        self.n_degenerate
    }

    /// Returns the smallest box around the triangles.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Returns the area of the surface in square metres.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Returns the centroid of the surface, metres.
    pub fn centroid(&self) -> DVec3 {
        // Relative to the middle of the box: sums lose nothing far from the origin.
        let middle = self.bounds.center();
        let weighted = self.triangles.iter().map(|triangle| {
            let [a, b, c] = corners(&self.vertices, triangle).map(|corner| corner - middle);
            area([a, b, c]) * (a + b + c) / 3.0
        });
        middle + weighted.sum::<DVec3>() / self.area
    }

    /// Returns whether the surface is closed and its triangles run clockwise seen from outside, with their
    /// normals pointing inward.
    pub fn is_inside_out(&self) -> bool {
        // The areas of a closed surface cancel each other, and its volume does not depend on the origin.
        // Edges say less: files repeat vertices, and triangles without an area are gone.
        let middle = self.bounds.center();
        let (mut open_area, mut volume) = (DVec3::ZERO, 0.0);
        for triangle in &self.triangles {
            let [a, b, c] = corners(&self.vertices, triangle).map(|corner| corner - middle);
            open_area += 0.5 * (b - a).cross(c - a);
            volume += a.dot(b.cross(c)) / 6.0;
        }
        open_area.length() < CLOSED * self.area && volume < -FLAT * self.area * self.area.sqrt()
    }

    /// Flips every triangle, and drops the colours.
    pub fn turned_over(self) -> Self {
        let triangles = self.triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect();
        Self { triangles, appearance: None, ..self }
    }

    /// Scales the mesh about the origin. Fails if the factor is not a positive number, or so extreme that the
    /// mesh breaks the rules of [`new`](Self::new).
    pub fn scaled(&self, factor: f64) -> Result<Self, SimError> {
        if !(factor > 0.0 && factor.is_finite()) {
            return Err(SimError::parameter("scale", factor, "a positive finite factor"));
        }
        self.moved(|vertex| vertex * factor)
    }

    /// Moves the mesh by an offset in metres. Fails if that breaks the rules of [`new`](Self::new).
    pub fn translated(&self, offset: DVec3) -> Result<Self, SimError> {
        self.moved(|vertex| vertex + offset)
    }

    /// Transforms the mesh to another frame. Fails if that breaks the rules of [`new`](Self::new).
    pub fn transformed(&self, target_from_mesh: &Pose) -> Result<Self, SimError> {
        self.moved(|vertex| target_from_mesh.transform_point(vertex))
    }

    fn moved(&self, transform: impl Fn(DVec3) -> DVec3) -> Result<Self, SimError> {
        let vertices = self.vertices.iter().map(|&v| transform(v)).collect();
        let mut moved = Self::with_appearance(vertices, self.triangles.clone(), self.appearance.clone())?;
        moved.n_degenerate += self.n_degenerate;
        Ok(moved)
    }
}

/// Maximum missing share of a closed surface: files have few digits.
const CLOSED: f64 = 1e-3;

/// Volume, as a share of the area to the power of 1.5, below which a mesh is flat: it has no inside.
const FLAT: f64 = 1e-6;

/// The area of a triangle.
pub(super) fn area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

fn corners(vertices: &[DVec3], triangle: &[u32; 3]) -> [DVec3; 3] {
    triangle.map(|i| vertices[i as usize])
}

fn check_vertices(vertices: &[DVec3]) -> Result<(), SimError> {
    // Written so that NaN counts as bad.
    let is_good = |v: &DVec3| v.abs().cmplt(DVec3::splat(TriangleMesh::MAX_COORDINATE)).all();
    match vertices.iter().position(|v| !is_good(v)) {
        Some(vertex) => Err(SimError::BadVertex { vertex, position: vertices[vertex] }),
        None => Ok(()),
    }
}

fn check_indices(n_vertices: usize, triangles: &[[u32; 3]]) -> Result<(), SimError> {
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&index) = corners.iter().find(|&&i| i as usize >= n_vertices) {
            return Err(SimError::IndexOutOfRange { triangle, index, n_vertices });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Face, Material};

    fn right_angle() -> Vec<DVec3> {
        vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::splat(9.0)]
    }

    #[test]
    fn measures_what_the_triangles_cover() {
        let mesh = TriangleMesh::new(right_angle(), vec![[0, 1, 2]]).unwrap();
        assert_eq!(mesh.area(), 0.5);
        assert_eq!(mesh.bounds().max, DVec3::new(1.0, 1.0, 0.0), "a loose vertex does not count");
        let moved = mesh.translated(DVec3::Z).unwrap();
        assert_eq!((moved.bounds().min.z, moved.bounds().max.z), (1.0, 1.0));
        let third = DVec3::new(1.0, 1.0, 0.0) / 3.0;
        assert!(
            mesh.centroid().distance(third) < 1e-15 && moved.centroid().distance(third + DVec3::Z) < 1e-15
        );
    }

    #[test]
    fn refuses_what_is_no_surface() {
        let with = |triangles| TriangleMesh::new(right_angle(), triangles);
        assert!(matches!(with(vec![]), Err(SimError::NoFaces { n_degenerate: 0 })));
        assert!(matches!(with(vec![[0, 1, 1]]), Err(SimError::NoFaces { n_degenerate: 1 })));
        let bad = with(vec![[0, 1, 2], [0, 4, 1]]);
        assert!(matches!(bad, Err(SimError::IndexOutOfRange { triangle: 1, index: 4, n_vertices: 4 })));
        for x in [f64::NAN, f64::INFINITY, -1e31] {
            let vertices = vec![DVec3::ZERO, DVec3::X * x, DVec3::Y];
            let error = TriangleMesh::new(vertices, vec![[0, 1, 2]]).unwrap_err();
            assert!(matches!(error, SimError::BadVertex { vertex: 1, .. }), "{error}");
        }
    }

    #[test]
    fn a_closed_surface_has_an_outside() {
        let mut corners = right_angle();
        corners[3] = DVec3::Z;
        let tetrahedron = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mesh = TriangleMesh::new(corners.clone(), tetrahedron.clone()).unwrap();
        let far = mesh.translated(DVec3::splat(100.0)).unwrap();
        assert!(!mesh.is_inside_out() && !far.is_inside_out());
        let turned = far.turned_over();
        assert!(turned.is_inside_out() && !turned.turned_over().is_inside_out());
        for open in [vec![[0, 1, 2], [0, 3, 1], [0, 2, 3]], vec![[0, 1, 2], [0, 2, 1]]] {
            assert!(!TriangleMesh::new(corners.clone(), open).unwrap().is_inside_out(), "open or flat");
        }
    }

    #[test]
    fn colours_stay_with_their_triangles() {
        let red = Material { reflectance: [1.0, 0.0, 0.0], image: None };
        let faces = [None, Some(0)].map(|material| Face { material, ..Face::default() });
        let look = Appearance { faces: faces.to_vec(), materials: vec![red], ..Appearance::default() };
        let triangles = vec![[0, 1, 1], [0, 1, 2]];
        let mesh = TriangleMesh::colored(right_angle(), triangles, look.clone()).unwrap();
        let moved = mesh.scaled(0.5).unwrap().translated(DVec3::Y).unwrap();
        assert_eq!(moved.color(0, [0.5, 0.5, 0.0]), Some([255, 0, 0]), "the first has no area");
        assert_eq!(
            TriangleMesh::new(right_angle(), vec![[0, 1, 2]]).unwrap().color(0, [1.0, 0.0, 0.0]),
            None
        );
        assert!(TriangleMesh::colored(right_angle(), vec![[0, 1, 2]], look).is_err());
    }

    #[test]
    fn refuses_scales_that_leave_no_surface() {
        let mesh = TriangleMesh::new(right_angle(), vec![[0, 1, 2]]).unwrap();
        for factor in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300, 1e300] {
            assert!(mesh.scaled(factor).is_err(), "{factor}");
        }
    }
}
