use super::*;
use glam::{IVec3, UVec3};
use nextview::geometry::random::Random;
use proptest::prelude::*;
use std::cmp::Ordering;
use std::collections::BTreeSet;

/// A fraction with a positive denominator.
#[derive(Clone, Copy, Debug)]
struct Fraction(i128, i128);

impl Fraction {
    fn new(n: i128, d: i128) -> Self {
        let (mut a, mut b) = (n.abs(), d.abs());
        while b != 0 {
            (a, b) = (b, a % b);
        }
        let divisor = a.max(1) * d.signum();
        Self(n / divisor, d / divisor)
    }

    fn cmp(self, whole: i32) -> Ordering {
        self.0.cmp(&(self.1 * whole as i128))
    }
}

/// The intersection of the line from `a` to `b` with a plane at a whole number on an axis, which must exist.
fn crossing(a: [Fraction; 3], b: [Fraction; 3], axis: usize, at: i32) -> [Fraction; 3] {
    let minus = |a: Fraction, b: Fraction| Fraction::new(a.0 * b.1 - b.0 * a.1, a.1 * b.1);
    let times = |a: Fraction, b: Fraction| Fraction::new(a.0 * b.0, a.1 * b.1);
    let (way, whole) = (minus(Fraction(at as i128, 1), a[axis]), minus(b[axis], a[axis]));
    let share = Fraction::new(way.0 * whole.1, way.1 * whole.0);
    std::array::from_fn(|i| {
        let step = times(share, minus(b[i], a[i]));
        minus(a[i], Fraction(-step.0, step.1))
    })
}

/// The slow reference clips the triangle to the closed voxel in fractions (Sutherland & Hodgman 1974). If a
/// part below the upper face of each axis remains, the mean of these parts is in the half-open voxel.
fn meets_in_fractions(corners: [[Fraction; 3]; 3], voxel: VoxelKey) -> bool {
    let mut polygon = corners.to_vec();
    for axis in 0..3 {
        for (at, outside) in [(voxel[axis], Ordering::Less), (voxel[axis] + 1, Ordering::Greater)] {
            let mut clipped = Vec::new();
            for (i, &b) in polygon.iter().enumerate() {
                let a = polygon[(i + polygon.len() - 1) % polygon.len()];
                if (a[axis].cmp(at) == outside) != (b[axis].cmp(at) == outside) {
                    clipped.push(crossing(a, b, axis, at));
                }
                if b[axis].cmp(at) != outside {
                    clipped.push(b);
                }
            }
            polygon = clipped;
        }
    }
    let is_below = |axis: usize| polygon.iter().any(|p| p[axis].cmp(voxel[axis] + 1) == Ordering::Less);
    !polygon.is_empty() && (0..3).all(is_below)
}

fn voxels_of(corners: [DVec3; 3], block: &VoxelBlock) -> BTreeSet<[i32; 3]> {
    let (mut voxels, mut n) = (BTreeSet::new(), 0);
    VoxelTriangle::new(corners, &Lattice::new(1.0).unwrap()).for_each_voxel(block, |voxel| {
        n += 1;
        voxels.insert(voxel.to_array());
    });
    assert_eq!(n, voxels.len(), "each voxel is visited once");
    voxels
}

fn block(min: i32, size: u32) -> VoxelBlock {
    VoxelBlock::new(IVec3::splat(min), UVec3::splat(size)).unwrap()
}

proptest! {
    /// Corners in quarters of a voxel: many triangles lie in faces of voxels, touch their edges and corners,
    /// or are lines or points.
    #[test]
    fn meets_what_clipping_in_fractions_leaves(quarters in prop::array::uniform9(-9_i32..22)) {
        let coordinate = |i: usize| quarters[i] as f64 / 4.0;
        let corners = [0, 3, 6].map(|i| DVec3::new(coordinate(i), coordinate(i + 1), coordinate(i + 2)));
        let in_fractions = [0, 3, 6].map(|i| [0, 1, 2].map(|j| Fraction::new(quarters[i + j] as i128, 4)));
        let block = block(-2, 7);
        let all = (0..block.n_voxels()).map(|i| block.key(i));
        let expected: BTreeSet<[i32; 3]> =
            all.filter(|voxel| meets_in_fractions(in_fractions, *voxel)).map(|voxel| voxel.to_array()).collect();
        prop_assert_eq!(voxels_of(corners, &block), expected);
    }

    /// Coarse numbers: flat triangles in and between the layers of voxels, and triangles seen as lines.
    #[test]
    fn meets_the_same_where_nearly_all_corners_are_corners_of_voxels(whole in prop::array::uniform9(0_i32..4)) {
        let corners = [0, 3, 6].map(|i| DVec3::new(whole[i] as f64, whole[i + 1] as f64, whole[i + 2] as f64));
        let in_fractions = [0, 3, 6].map(|i| [0, 1, 2].map(|j| Fraction(whole[i + j] as i128, 1)));
        let block = block(-1, 5);
        let all = (0..block.n_voxels()).map(|i| block.key(i));
        let expected: BTreeSet<[i32; 3]> =
            all.filter(|voxel| meets_in_fractions(in_fractions, *voxel)).map(|voxel| voxel.to_array()).collect();
        prop_assert_eq!(voxels_of(corners, &block), expected);
    }

    #[test]
    fn the_order_of_the_corners_does_not_matter(c in prop::array::uniform9(-3.0..9.0)) {
        let [p, q, r] = [0, 3, 6].map(|i| DVec3::new(c[i], c[i + 1], c[i + 2]));
        let block = block(-4, 14);
        let voxels = voxels_of([p, q, r], &block);
        for corners in [[q, r, p], [r, p, q], [p, r, q], [q, p, r], [r, q, p]] {
            prop_assert_eq!(&voxels_of(corners, &block), &voxels);
        }
    }
}

#[test]
fn every_point_of_a_triangle_is_in_a_visited_voxel() {
    let mut random = Random::new(5, 0);
    let (lattice, block) = (Lattice::new(0.003).unwrap(), block(-40, 80));
    for size in [0.1, 0.01, 0.001] {
        for _ in 0..40 {
            let middle = 0.01 * random.in_cube();
            let corners = [(); 3].map(|()| middle + size * random.in_cube());
            let mut is_visited = vec![false; block.n_voxels()];
            let triangle = VoxelTriangle::new(corners, &lattice);
            triangle.for_each_voxel(&block, |voxel| is_visited[block.index(voxel).unwrap()] = true);
            for _ in 0..2000 {
                let (u, v) = (random.unit().sqrt(), random.unit());
                let [a, b, c] = corners;
                let point = a + u * (1.0 - v) * (b - a) + u * v * (c - a);
                assert!(block.index(lattice.key(point)).is_none_or(|index| is_visited[index]), "{point}");
            }
        }
    }
}

/// An object's face between two voxels belongs to the upper voxel, as its points do.
#[test]
fn a_triangle_between_two_layers_is_in_the_upper_one() {
    let corners = [DVec3::new(0.5, 0.5, 2.0), DVec3::new(2.5, 0.5, 2.0), DVec3::new(0.5, 2.5, 2.0)];
    let layers: BTreeSet<i32> = voxels_of(corners, &block(0, 5)).iter().map(|voxel| voxel[2]).collect();
    assert_eq!(layers, BTreeSet::from([2]));
}

#[test]
fn corners_that_only_touch_from_below_do_not_count() {
    // The upper corner of the voxel at the origin is (1, 1, 1), which belongs to the next voxel.
    let corners = [DVec3::ONE, DVec3::new(1.5, 1.0, 1.2), DVec3::new(1.0, 1.5, 1.2)];
    assert_eq!(voxels_of(corners, &block(0, 3)), BTreeSet::from([[1, 1, 1]]));
    // From above, they do: the lowest corner is the voxel's own.
    let corners = [DVec3::ONE, DVec3::new(0.5, 0.9, 0.8), DVec3::new(0.9, 0.5, 0.8)];
    assert_eq!(voxels_of(corners, &block(0, 3)), BTreeSet::from([[0, 0, 0], [1, 1, 1]]));
}

#[test]
fn a_margin_takes_in_the_voxels_that_are_nearly_touched() {
    let square = [DVec3::new(0.5, 0.5, 2.0), DVec3::new(1.5, 0.5, 2.0), DVec3::new(0.5, 1.5, 2.0)];
    let layers = |offset: f64, margin: f64| {
        let corners = square.map(|corner| corner + DVec3::Z * offset);
        let mut layers = BTreeSet::new();
        let triangle = VoxelTriangle::new(corners, &Lattice::new(1.0).unwrap());
        triangle.for_each_voxel_within(margin, &block(0, 5), |voxel| _ = layers.insert(voxel.z));
        layers
    };
    assert_eq!(layers(0.0, 0.001), BTreeSet::from([1, 2]));
    assert_eq!(layers(0.0005, 0.001), BTreeSet::from([1, 2]));
    assert_eq!(layers(-0.0005, 0.001), BTreeSet::from([1, 2]));
    assert_eq!((layers(0.01, 0.001), layers(-0.01, 0.001)), (BTreeSet::from([2]), BTreeSet::from([1])));
}

#[test]
fn lines_and_points_meet_voxels_too() {
    let (a, b) = (DVec3::new(0.5, 0.5, 0.5), DVec3::new(3.5, 0.5, 0.5));
    let row: BTreeSet<[i32; 3]> = (0..4).map(|x| [x, 0, 0]).collect();
    assert_eq!(voxels_of([a, b, a], &block(0, 5)), row);
    assert_eq!(voxels_of([a, b, (a + b) / 2.0], &block(0, 5)), row);
    assert_eq!(voxels_of([a; 3], &block(0, 5)), BTreeSet::from([[0, 0, 0]]));
    assert_eq!(voxels_of([DVec3::ONE; 3], &block(0, 5)), BTreeSet::from([[1, 1, 1]]));
}

#[test]
fn only_voxels_of_the_block_are_visited() {
    let far = 1e30;
    let corners = [DVec3::new(-far, -far, 0.5), DVec3::new(far, -far, 0.5), DVec3::new(0.0, far, 0.5)];
    assert_eq!(voxels_of(corners, &block(0, 3)).len(), 9, "one layer of three by three");
    assert!(voxels_of(corners.map(|c| c + DVec3::Z * 7.0), &block(0, 3)).is_empty());
}
