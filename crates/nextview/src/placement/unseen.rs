use super::{Rest, rests};
use crate::geometry::{Aabb, Plane};
use crate::map::{Occupancy, Snapshot};
use glam::{DVec3, IVec3};

/// Unseen surface is freed if it looks up, or down by less than this sine: candidates are that low.
const LOWEST_LOOK: f64 = 0.3;

/// Minimum share of the whole surface that a pose must free to be worth the turn.
const LEAST_FREED: f64 = 0.01;

const SIDES: [IVec3; 6] = [IVec3::X, IVec3::NEG_X, IVec3::Y, IVec3::NEG_Y, IVec3::Z, IVec3::NEG_Z];

/// The placement that exposes most of the hidden surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NextPlacement {
    /// The pose in which it will rest; its direction is in the present world frame.
    pub rest: Rest,
    /// Share, 0..=1, of the unseen surface that it frees.
    pub freed_share: f64,
    /// Share, 0..=1, of the surface that is unseen now.
    pub unseen_share: f64,
}

/// Returns the rest pose that frees most of the unseen surface: faces of unknown voxels towards free space,
/// and of occupied and unknown ones towards the table. `None` if no pose frees a hundredth of the surface.
///
/// The object is assumed to be solid and of uniform density where it is not known to be free. The voxels of
/// its snapshot must be much smaller than it.
pub fn next_placement(snapshot: &Snapshot, table: Plane) -> Option<NextPlacement> {
    let solid = OpaqueVoxels::new(snapshot, table)?;
    let unseen = &solid.unseen;
    let n_unseen = unseen.len() as f64;
    let unseen_share = n_unseen / (n_unseen + solid.n_seen as f64);
    // Steeper surface is seen better and counts more, so of two poses the one wins that shows it to most
    // candidates.
    let freed = |down: DVec3| {
        let look = |normal: &DVec3| ((LOWEST_LOOK - normal.dot(down)) / (1.0 + LOWEST_LOOK)).max(0.0);
        unseen.iter().map(look).sum::<f64>() / n_unseen
    };
    let poses = rests(&solid.outline, solid.center_of_mass).into_iter();
    let freed = poses.map(|rest| NextPlacement { rest, freed_share: freed(rest.down), unseen_share });
    let best = freed.max_by(|a, b| a.freed_share.total_cmp(&b.freed_share))?;
    (best.freed_share * unseen_share >= LEAST_FREED).then_some(best)
}

/// The voxels that are not known to be free.
struct OpaqueVoxels {
    /// Centres of those next to free voxels or on the table, metres.
    outline: Vec<DVec3>,
    center_of_mass: DVec3,
    /// Number of faces of the surface that were seen.
    n_seen: usize,
    /// Outward normals of the unseen faces.
    unseen: Vec<DVec3>,
}

impl OpaqueVoxels {
    /// The solid voxels in the box around all occupied ones; `None` if none is occupied or nothing is unseen.
    fn new(snapshot: &Snapshot, table: Plane) -> Option<Self> {
        let (block, lattice) = (snapshot.block(), snapshot.lattice());
        let state = |key: IVec3| block.index(key).map(|i| snapshot.occupancy()[i]);
        let is_in_table = |key: IVec3| key.z < block.min().z || table.height(lattice.center(key)) <= 0.0;
        let occupied = (0..block.n_voxels()).filter(|&i| snapshot.occupancy()[i] == Occupancy::Occupied);
        let bounds = Aabb::around(occupied.map(|i| lattice.center(block.key(i))))?;
        let (mut outline, mut unseen, mut n_seen) = (Vec::new(), Vec::new(), 0);
        let (mut sum, mut n) = (DVec3::ZERO, 0.0);
        let is_solid = |key: &IVec3| {
            let is_inside = bounds.contains(lattice.center(*key)) && !is_in_table(*key);
            is_inside && state(*key) != Some(Occupancy::Free)
        };
        for key in (0..block.n_voxels()).map(|i| block.key(i)).filter(is_solid) {
            let is_unknown = state(key) == Some(Occupancy::Unknown);
            let n_before = unseen.len() + n_seen;
            for side in SIDES {
                let is_free = state(key + side) == Some(Occupancy::Free);
                match is_in_table(key + side) {
                    true => unseen.push(side.as_dvec3()),
                    false if is_free && is_unknown => unseen.push(side.as_dvec3()),
                    false => n_seen += is_free as usize,
                }
            }
            if unseen.len() + n_seen > n_before {
                outline.push(lattice.center(key));
            }
            (sum, n) = (sum + lattice.center(key), n + 1.0);
        }
        (!unseen.is_empty()).then_some(Self { outline, center_of_mass: sum / n, n_seen, unseen })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Lattice, VoxelBlock};
    use crate::map::LogOdds;
    use glam::UVec3;

    const TABLE: f64 = 0.0;

    /// A brick of 20 x 12 x 8 voxels on the table. Its inside and the face on the table are unknown, and so
    /// are the named faces; all others are occupied.
    fn snapshot(unseen: &[IVec3]) -> Snapshot {
        let block = VoxelBlock::new(IVec3::new(-15, -15, 0), UVec3::new(30, 30, 15)).unwrap();
        let (low, high) = (IVec3::new(-10, -6, 0), IVec3::new(9, 5, 7));
        let is_inside = |key: IVec3| key.cmpge(low).all() && key.cmple(high).all();
        Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |key| {
            let seen = |side: &IVec3| *side != IVec3::NEG_Z && !unseen.contains(side);
            match is_inside(key) {
                false => Some(LogOdds::from_probability(0.1)),
                true if SIDES.iter().filter(|side| !is_inside(key + **side)).any(seen) => {
                    Some(LogOdds::from_probability(0.9))
                }
                true => None,
            }
        })
    }

    #[test]
    fn what_stood_on_the_table_comes_up() {
        let table = Plane::horizontal(TABLE).unwrap();
        let next = next_placement(&snapshot(&[]), table).unwrap();
        assert!(next.rest.down.z > 0.999 && next.freed_share > 0.99, "{next:?}");
        let share = 240.0 / (2.0 * (240.0 + 160.0 + 96.0));
        assert!((next.unseen_share - share).abs() < 0.01, "{next:?}, {share}");
    }

    #[test]
    fn a_side_that_no_view_showed_counts_as_well() {
        let table = Plane::horizontal(TABLE).unwrap();
        let next = next_placement(&snapshot(&[IVec3::X, IVec3::Y, IVec3::NEG_X]), table).unwrap();
        assert!(next.freed_share > 0.5 && next.unseen_share > 0.4, "{next:?}");
        let free = Snapshot::from_fn(snapshot(&[]).lattice(), snapshot(&[]).block(), |_| None);
        assert_eq!(next_placement(&free, table), None, "nothing is known");
    }
}
