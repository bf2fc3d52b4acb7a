use super::InformationGain;
use crate::map::{Occupancy, Snapshot};
use crate::sensor::Frame;
use crate::visibility::{FreeSpace, Ray, RayEnd, Sight};
use crate::{Cancel, Cancelled};

/// The area factor of Vasquez-Gomez et al. (International Journal of Advanced Robotic Systems 2014), 0..=2:
/// how near the shares of occupied and occplane voxels among the voxels that a view sees are to 0.2 and 0.8.
///
/// A ray sees the first voxel on it that is occupied, occplane or unmarked (unknown but not occplane). The
/// shares are relative to the number of rays that see any such voxel. The gain is f(occupied, 0.2) +
/// f(occplane, 0.8), where f(a, g) rises from 0 at a = 0 to 1 at a = g and falls to 0 at a = 1, both as a
/// cubic with zero slope at its ends.
///
/// Occplane, the border between occluded and free space, is published as unknown voxels next to free ones and
/// behind a measured surface. A snapshot does not record which voxels were behind a surface when it was
/// measured. Here every unknown voxel that shares a face with a free one is occplane as soon as any voxel is
/// occupied. (The code of Isler et al. continues behind unmarked voxels to an occplane or occupied one; here
/// the first voxel decides.) The other factors of the publication (distance, registration overlap) are not
/// included.
#[derive(Clone, Debug)]
pub struct AreaFactor {
    sights: Vec<SeenKind>,
}

/// The kind of voxel seen by a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SeenKind {
    Nothing,
    Occplane,
    Unmarked,
}

/// Number of rays by the kind of voxel that they see first.
#[derive(Clone, Copy, Debug, Default)]
pub struct Areas {
    n_occupied: u64,
    n_occplane: u64,
    n_unmarked: u64,
}

impl InformationGain for AreaFactor {
    const SIGHT: Sight = Sight::endless(FreeSpace::Clear);

    type Tally = Areas;

    fn new(snapshot: &Snapshot, _: &[Frame], _: &Cancel) -> Result<Self, Cancelled> {
        let has_surface = snapshot.count(Occupancy::Occupied) > 0;
        let seen = |index: usize| match snapshot.occupancy()[index] {
            Occupancy::Unknown if has_surface && touches_free(snapshot, index) => SeenKind::Occplane,
            Occupancy::Unknown => SeenKind::Unmarked,
            Occupancy::Free | Occupancy::Occupied => SeenKind::Nothing,
        };
        Ok(Self { sights: (0..snapshot.block().n_voxels()).map(seen).collect() })
    }

    fn add(&self, ray: &Ray<'_>, areas: &mut Areas) {
        let mut sights = ray.crossings.iter().map(|crossing| self.sights[crossing.voxel as usize]);
        match sights.find(|&seen| seen != SeenKind::Nothing) {
            Some(SeenKind::Occplane) => areas.n_occplane += 1,
            Some(_) => areas.n_unmarked += 1,
            None => areas.n_occupied += matches!(ray.end, RayEnd::Occupied(_)) as u64,
        }
    }

    fn total(areas: &Areas) -> f64 {
        let n_rays = areas.n_occupied + areas.n_occplane + areas.n_unmarked;
        if n_rays == 0 {
            return 0.0;
        }
        let share = |n: u64| n as f64 / n_rays as f64;
        peak(share(areas.n_occupied), 0.2) + peak(share(areas.n_occplane), 0.8)
    }
}

fn touches_free(snapshot: &Snapshot, index: usize) -> bool {
    let (block, key) = (snapshot.block(), snapshot.block().key(index));
    let is_face = |&neighbor: &usize| (block.key(neighbor) - key).abs().element_sum() == 1;
    block.neighbors(index).filter(is_face).any(|i| snapshot.occupancy()[i] == Occupancy::Free)
}

/// f(a, g): 0 at the ends of 0..=1, 1 at g, cubics with zero slope at their ends in between.
fn peak(a: f64, g: f64) -> f64 {
    let t = if a <= g { a / g } else { (1.0 - a) / (1.0 - g) };
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_is_where_and_as_published() {
        for g in [0.2, 0.8] {
            assert_eq!((peak(0.0, g), peak(g, g), peak(1.0, g)), (0.0, 1.0, 0.0));
            let slope = |a: f64, b: f64| (peak(b, g) - peak(a, g)) / (b - a);
            let flat = [slope(0.0, 1e-6), slope(g - 1e-6, g), slope(g, g + 1e-6), slope(1.0 - 1e-6, 1.0)];
            assert!(flat.iter().all(|slope| slope.abs() < 1e-4), "{flat:?}");
        }
        // Half way up, t = 1/2: 1/4 (3 - 1) = 1/2. Three quarters of the way down, t = 1/4: 1/16 (3 - 1/2) =
        // 5/32.
        assert!((peak(0.1, 0.2) - 0.5).abs() < 1e-15);
        assert!((peak(0.8, 0.2) - 5.0 / 32.0).abs() < 1e-15);
    }
}
