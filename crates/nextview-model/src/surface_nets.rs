use super::SurfaceMesh;
use glam::{DVec3, IVec3};
use nextview::geometry::{Lattice, VoxelBlock};
use nextview::{Cancel, Cancelled};

/// Extracts the surface where a signed distance is zero (naive surface nets, after Gibson 1998). `distance`
/// returns it at the centre of a voxel, by index in the block, in any unit, positive outside; `None` if
/// unknown.
///
/// A cell is the cube between eight voxel centres. Each cell that the surface crosses, with all corners
/// known, has a vertex at the mean of the crossings of its edges, and each crossed edge joins the vertices of
/// the four cells around it. There is no surface where the distance is unknown: holes stay open. Parts
/// thinner than a voxel may give edges with more than two triangles. Vertices and triangles are in the order
/// of their cells.
///
/// ```
/// use glam::{IVec3, UVec3};
/// use nextview::geometry::{Lattice, VoxelBlock};
/// use nextview_model::surface_nets;
///
/// let lattice = Lattice::new(0.01).unwrap();
/// let block = VoxelBlock::new(IVec3::splat(-12), UVec3::splat(24)).unwrap();
/// let ball = surface_nets(&lattice, &block, |i| Some(lattice.center(block.key(i)).length() - 0.1));
/// assert!(ball.vertices.iter().all(|v| (v.length() - 0.1).abs() < 0.001));
/// ```
pub fn surface_nets(
    lattice: &Lattice,
    block: &VoxelBlock,
    distance: impl Fn(usize) -> Option<f64>,
) -> SurfaceMesh {
    surface_nets_unless(lattice, block, distance, &Cancel::default()).expect("nobody cancels")
}

/// As [`surface_nets`], unless cancelled.
pub(super) fn surface_nets_unless(
    lattice: &Lattice,
    block: &VoxelBlock,
    distance: impl Fn(usize) -> Option<f64>,
    cancel: &Cancel,
) -> Result<SurfaceMesh, Cancelled> {
    let mut mesh = SurfaceMesh::default();
    let dims = block.dims().as_ivec3();
    let (n_x, n_y) = (dims.x as usize - 1, dims.y as usize - 1);
    // Edges at the lower sides of a slice also touch the slice below; older ones are done.
    let mut below = Slice { n_x, vertices: Vec::new() };
    for z in 0..dims.z - 1 {
        cancel.check()?;
        let mut slice = Slice { n_x, vertices: vec![None; n_x * n_y] };
        for cell in (0..dims.y - 1).flat_map(|y| (0..dims.x - 1).map(move |x| IVec3::new(x, y, z))) {
            let Some(corners) = corners(block, &distance, cell) else { continue };
            let Some(vertex) = vertex(&corners) else { continue };
            *slice.at_mut(cell) = Some(mesh.vertices.len() as u32);
            mesh.vertices.push(lattice.center(block.min() + cell) + vertex * lattice.voxel_size());
            for axis in 0..3 {
                mesh.add_quad(quad(&corners, axis, cell, [&below, &slice]));
            }
        }
        below = slice;
    }
    Ok(mesh)
}

impl SurfaceMesh {
    /// Adds a quad as two triangles, split along its shorter diagonal.
    fn add_quad(&mut self, quad: Option<[u32; 4]>) {
        let Some([a, b, c, d]) = quad else { return };
        let length = |i: u32, j: u32| self.vertices[i as usize].distance_squared(self.vertices[j as usize]);
        let pair = if length(a, c) <= length(b, d) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
        self.triangles.extend(pair);
    }
}

/// The vertices of one slice of cells, x varying fastest.
struct Slice {
    n_x: usize,
    vertices: Vec<Option<u32>>,
}

impl Slice {
    fn at_mut(&mut self, cell: IVec3) -> &mut Option<u32> {
        &mut self.vertices[cell.y as usize * self.n_x + cell.x as usize]
    }

    fn at(&self, cell: IVec3) -> Option<u32> {
        self.vertices[cell.y as usize * self.n_x + cell.x as usize]
    }
}

/// The offset of corner `i` of a cell, x varying fastest.
fn corner(i: usize) -> IVec3 {
    IVec3::new((i & 1) as i32, (i >> 1 & 1) as i32, (i >> 2) as i32)
}

/// Returns the distances at a cell's corners, if all are known.
fn corners(block: &VoxelBlock, distance: impl Fn(usize) -> Option<f64>, cell: IVec3) -> Option<[f64; 8]> {
    let [x, y, z] = block.strides();
    let first = cell.x as usize * x + cell.y as usize * y + cell.z as usize * z;
    let mut distances = [0.0; 8];
    for (i, corner) in distances.iter_mut().enumerate() {
        *corner = distance(first + (i & 1) * x + (i >> 1 & 1) * y + (i >> 2) * z)?;
    }
    Some(distances)
}

/// Whether the surface crosses between two distances; the surface itself counts as outside.
fn crosses(a: f64, b: f64) -> bool {
    (a < 0.0) != (b < 0.0)
}

/// Returns the mean of the crossings of a cell's edges, relative to its first corner in voxels; `None` if
/// there are none.
fn vertex(corners: &[f64; 8]) -> Option<DVec3> {
    let (mut sum, mut n_crossings) = (DVec3::ZERO, 0);
    for from in 0..8 {
        for axis in (0..3).filter(|axis| from >> axis & 1 == 0) {
            let (a, b) = (corners[from], corners[from | 1 << axis]);
            if crosses(a, b) {
                sum += corner(from).as_dvec3();
                sum[axis] += a / (a - b);
                n_crossings += 1;
            }
        }
    }
    (n_crossings > 0).then(|| sum / n_crossings as f64)
}

/// Returns the vertices of the four cells around the edge from a cell's first corner along an axis; `None` if
/// the surface does not cross it or a cell has no vertex.
fn quad(corners: &[f64; 8], axis: usize, cell: IVec3, [below, slice]: [&Slice; 2]) -> Option<[u32; 4]> {
    let (first, second) = (corners[0], corners[1 << axis]);
    if !crosses(first, second) {
        return None;
    }
    let [u, v] = [1, 2].map(|k| IVec3::AXES[(axis + k) % 3]);
    // Counter-clockwise as seen from the positive end of the axis.
    let mut around = [cell - u - v, cell - v, cell, cell - u];
    if first >= 0.0 {
        around.reverse();
    }
    let vertex = |of: IVec3| {
        let exists = of.min_element() >= 0;
        exists.then(|| if of.z < cell.z { below.at(of) } else { slice.at(of) }).flatten()
    };
    let [a, b, c, d] = around.map(vertex);
    Some([a?, b?, c?, d?])
}
