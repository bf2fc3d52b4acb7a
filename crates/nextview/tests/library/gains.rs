//! The literature's gains: single rays worked out by hand, and whole views against the definitions written
//! out over the voxels of each ray.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::common::{crossed, directions};
use glam::{DVec2, DVec3, IVec3, UVec3};
use nextview::Cancel;
use nextview::gain::{
    Apora, AreaFactor, AverageEntropy, InformationGain, Krainin, OcclusionAware, Potthast, ProximityCount,
    RearSideEntropy, RearSideVoxel, UnobservedVoxel,
};
use nextview::geometry::random::Random;
use nextview::geometry::{Aabb, Lattice, Pose, VoxelBlock};
use nextview::map::{LogOdds, Occupancy, Snapshot, entropy, frontier};
use nextview::sensor::{DepthImage, Frame, Intrinsics};
use nextview::view::look_at;
use nextview::visibility::{Crossing, Ray, RayCaster, RayEnd};
use proptest::prelude::*;
use std::f64::consts::LN_2;

const SPACING: f64 = 1.3;

fn snapshot(min: IVec3, dims: UVec3, state: impl Fn(usize) -> Occupancy) -> Snapshot {
    let block = VoxelBlock::new(min, dims).unwrap();
    Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |key| match state(block.index(key).unwrap()) {
        Occupancy::Unknown => None,
        Occupancy::Free => Some(LogOdds::from_probability(0.4)),
        Occupancy::Occupied => Some(LogOdds::from_probability(0.7)),
    })
}

/// A row of voxels of 1 cm along x: `?` unknown, `.` free (P = 0.4), `#` occupied (P = 0.7).
fn row(text: &str) -> Snapshot {
    let state = |i: usize| match text.as_bytes()[i] {
        b'?' => Occupancy::Unknown,
        b'.' => Occupancy::Free,
        _ => Occupancy::Occupied,
    };
    snapshot(IVec3::ZERO, UVec3::new(text.len() as u32, 1, 1), state)
}

/// The gain of one ray along the row, which takes visibility from all voxels.
fn of_row<G: InformationGain>(text: &str) -> f64 {
    let snapshot = row(text);
    let voxels: Vec<usize> = (0..text.len()).collect();
    let mut tally = G::Tally::default();
    with_ray(&snapshot, &voxels, |ray| {
        G::new(&snapshot, &[], &Cancel::default()).unwrap().add(ray, &mut tally)
    });
    G::total(&tally)
}

/// Makes a ray of the voxels up to the first occupied one.
fn with_ray(snapshot: &Snapshot, voxels: &[usize], visit: impl FnOnce(&Ray<'_>)) {
    let mut crossings = Vec::new();
    let mut visibility = 1.0_f32;
    for &voxel in voxels {
        let crossing = Crossing { voxel: voxel as u32, visibility };
        if snapshot.occupancy()[voxel] == Occupancy::Occupied {
            return visit(&Ray { crossings: &crossings, end: RayEnd::Occupied(crossing) });
        }
        crossings.push(crossing);
        visibility *= 1.0 - snapshot.probability()[voxel];
    }
    visit(&Ray { crossings: &crossings, end: RayEnd::LeftBox });
}

#[track_caller]
fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-6, "{found}, expected {expected}");
}

/// H(0.4) = H(0.6) = 0.673012 and H(0.7) = 0.610864 nats; H(0.5) = ln 2.
const H_FREE: f64 = 0.673_011_667;
const H_OCCUPIED: f64 = 0.610_864_302;

#[test]
fn occlusion_aware_sums_what_is_visible() {
    // P(vis) is 1, then 0.6 behind the free voxel, then 0.3 behind the unknown one; the last voxel is hidden.
    near(of_row::<OcclusionAware>(".?#?"), H_FREE + 0.6 * LN_2 + 0.3 * H_OCCUPIED);
    near(of_row::<OcclusionAware>("??"), 1.5 * LN_2);
}

#[test]
fn unobserved_voxel_sums_the_unknown_only() {
    near(of_row::<UnobservedVoxel>(".?#?"), 0.6 * LN_2);
    near(of_row::<UnobservedVoxel>("?.?"), (1.0 + 0.5 * 0.6) * LN_2);
    near(of_row::<UnobservedVoxel>("..#"), 0.0);
}

#[test]
fn rear_side_voxel_counts_surfaces_met_from_the_unknown() {
    for (text, expected) in
        [("??#", 1.0), (".?#", 1.0), ("?.#", 0.0), ("#", 0.0), ("???", 0.0), ("?#?#", 1.0)]
    {
        assert_eq!(of_row::<RearSideVoxel>(text), expected, "{text}");
    }
}

#[test]
fn rear_side_entropy_sums_the_run_before_the_rear_side() {
    // Visibility 0.5 * 0.6 = 0.3 before the run of two, 0.15 in its second voxel, 0.075 at the surface.
    near(of_row::<RearSideEntropy>("?.??#"), 0.45 * LN_2 + 0.075 * H_OCCUPIED);
    for nothing in ["?.#", "???", "#", "?."] {
        assert_eq!(of_row::<RearSideEntropy>(nothing), 0.0, "{nothing}");
    }
    // The run counts however long it is: 1 + 1/2 + 1/4 + ... is 2 to six digits.
    near(of_row::<RearSideEntropy>("?????????????????????????#"), 2.0 * LN_2);
}

#[test]
fn krainin_and_average_entropy_take_rays_that_end_occupied() {
    near(of_row::<Krainin>("?.?#"), 2.0 * LN_2 + H_FREE + H_OCCUPIED);
    near(of_row::<AverageEntropy>("?.?#"), (2.0 * LN_2 + H_FREE + H_OCCUPIED) / 4.0);
    assert_eq!((of_row::<Krainin>("?.?"), of_row::<AverageEntropy>("?.?")), (0.0, 0.0));
}

#[test]
fn apora_hides_by_its_own_probability() {
    // The second voxel is the frontier, unknown between free and occupied: P(obj) = 1, in full behind free
    // space.
    near(of_row::<Apora>(".?#??"), LN_2);
    near(of_row::<Apora>("...?#"), LN_2);
    // The frontier is voxel 5, which the ray does not reach. Voxels 0 and 1 are at d = 5 and 4: P(obj) is
    // exp(-0.25) = 0.778801 and exp(-0.16) = 0.852144, and 0.778801 + (1 - 0.778801) * 0.852144 = 0.967294.
    near(of_row::<Apora>("??..#?."), 0.967_294 * LN_2);
    // Nothing occupied was seen: the first unknown voxel is the object and hides the rest.
    near(of_row::<Apora>(".???"), LN_2);
    // A surface without a frontier is closed: nothing is left to see.
    near(of_row::<Apora>("???#"), 0.0);
}

#[test]
fn area_factor_weighs_what_rays_meet_first() {
    // Voxel 2 is occplane: its neighbour 1 is free. Voxel 5 is unmarked: its neighbours are not.
    let snapshot = row("..?#???");
    let gain = AreaFactor::new(&snapshot, &[], &Cancel::default()).unwrap();
    let total = |rays: &[&[usize]]| {
        let mut tally = Default::default();
        rays.iter().for_each(|voxels| with_ray(&snapshot, voxels, |ray| gain.add(ray, &mut tally)));
        AreaFactor::total(&tally)
    };
    let (occupied, occplane, unmarked, nothing): (&[usize], &[usize], &[usize], &[usize]) =
        (&[0, 3], &[0, 1, 2], &[5, 6], &[0, 1]);
    near(total(&[]), 0.0);
    near(total(&[nothing, nothing]), 0.0);
    // One in five occupied, four occplane: both factors at their peak; a ray that meets nothing changes no
    // share.
    near(total(&[occupied, occplane, occplane, occplane, occplane, nothing]), 2.0);
    // All occupied is 0 + 0, since f(1, 0.2) = f(0, 0.8) = 0.
    near(total(&[occupied]), 0.0);
    // Half occplane: t = 0.5 / 0.8 = 0.625 and 0.390625 * (3 - 1.25) = 0.683594.
    near(total(&[occplane, unmarked]), 0.683_593_75);
}

/// In unknown space eqs. (5) to (15) have a closed form: v_m = a^(m (m + 1) / 2), and o_m = (1 - v_1 ... v_m)
/// / 2.
#[test]
fn potthast_gains_what_the_closed_form_says_in_unknown_space() {
    let of_first = |n: usize| if n == 0 { 0.0 } else { of_row::<Potthast>(&"?".repeat(n)) };
    for (m, o) in [(1, 0.0005), (10, 0.0988), (15, 0.2468), (20, 0.3929)] {
        let exponent = (m * (m + 1) * (m + 2) / 6) as i32;
        let closed = 0.5 * (1.0 - 0.999_f64.powi(exponent));
        assert!((closed - o).abs() < 1e-4, "{closed} in voxel {m}");
        near(of_first(m) - of_first(m - 1), LN_2 - entropy(closed));
    }
    // Sight falls below 1e-3 in voxel 118, and 0.999^(118 * 119 / 2) is 0.00089.
    assert_eq!(of_first(118), of_first(300));
}

#[test]
fn potthast_hides_what_is_behind_a_surface() {
    // One free voxel: v_1 = 0.999, so o' = 0.0005, and o = 0.4 * 0.0005 / (0.4 * 0.0005 + 0.6 * 0.9995).
    let o = 0.4 * 0.0005 / (0.4 * 0.0005 + 0.6 * 0.9995);
    near(of_row::<Potthast>("."), H_FREE - entropy(o));
    // The ray ends at the surface, and with it the view's gain.
    assert_eq!(of_row::<Potthast>("..#"), of_row::<Potthast>("..#???"));
}

/// Ten times as many voxels of a tenth of the size have ten times the gain, up to what is lost by counting
/// whole voxels.
#[test]
fn potthast_decays_per_metre() {
    let of_voxels = |voxel_size: f64, n: u32| {
        let block = VoxelBlock::new(IVec3::ZERO, UVec3::new(n, 1, 1)).unwrap();
        let unknown = Snapshot::from_fn(Lattice::new(voxel_size).unwrap(), block, |_| None);
        let (gain, mut tally) = (Potthast::new(&unknown, &[], &Cancel::default()).unwrap(), 0.0);
        with_ray(&unknown, &(0..n as usize).collect::<Vec<_>>(), |ray| gain.add(ray, &mut tally));
        tally * voxel_size
    };
    for n in [10, 20, 40, 80] {
        let (coarse, fine) = (of_voxels(0.01, n), of_voxels(0.001, 10 * n));
        assert!((coarse / fine - 1.0).abs() < 0.15, "{coarse} {fine}");
    }
}

/// A camera of one pixel at `x` on the axis of the row, which looks at its other end and measures a surface
/// at `surface`.
fn look_along_row(x: f64, surface: f64) -> Frame {
    let on_axis = |x: f64| DVec3::new(x, 0.005, 0.005);
    let camera = Intrinsics::pinhole(1, 1, DVec2::ONE, DVec2::ZERO).unwrap();
    let image = DepthImage::from_metres(1, 1, vec![(surface - x).abs() as f32]).unwrap();
    Frame::new(image, camera, look_at(on_axis(x), on_axis(surface)).unwrap(), 1.0).unwrap()
}

#[test]
fn proximity_count_falls_behind_the_surface() {
    let snapshot = row("#??.?#");
    let of_frames = |frames: &[Frame]| {
        let mut tally = 0;
        let gain = ProximityCount::new(&snapshot, frames, &Cancel::default()).unwrap();
        with_ray(&snapshot, &[1, 2, 3, 4], |ray| gain.add(ray, &mut tally));
        tally
    };
    // Behind the surface in voxel 0 come voxels 1, 2, (3, which is free,) and 4.
    let left = look_along_row(-0.2, 0.005);
    assert_eq!(of_frames(std::slice::from_ref(&left)), 59 + 58 + 56);
    // From the other side voxel 4 comes first: of 4 and 1 the smaller one counts.
    let right = look_along_row(0.3, 0.055);
    assert_eq!(of_frames(&[left, right]), 59 + 58 + 59);
    // A surface beyond the row leaves all of it in front, and one before it is not in the box.
    assert_eq!(of_frames(&[]), 0);
    assert_eq!(of_frames(&[look_along_row(-0.2, 0.2), look_along_row(-0.2, -0.1)]), 0);
}

#[test]
fn proximity_count_ends_at_d_max() {
    let snapshot = row(&"?".repeat(70));
    let gain = ProximityCount::new(&snapshot, &[look_along_row(-0.2, 0.005)], &Cancel::default()).unwrap();
    let of_voxel = |voxel: usize| {
        let mut tally = 0;
        with_ray(&snapshot, &[voxel], |ray| gain.add(ray, &mut tally));
        tally
    };
    let expected = (0..70).map(|d| if d == 0 { 0 } else { 60_u64.saturating_sub(d) });
    assert!((0..70).map(of_voxel).eq(expected));
}

/// Three small depth images around the origin: surfaces within the box and around it, and pixels that tell
/// nothing.
fn frames(seed: u64) -> Vec<Frame> {
    let mut random = Random::new(seed, 0);
    let camera = Intrinsics::pinhole(8, 6, DVec2::splat(20.0), DVec2::new(3.7, 2.7)).unwrap();
    let mut frame = || {
        let position = (random.in_cube() + 1e-3).normalize() * 0.3;
        let depth = |_| match random.index(10) {
            0 => f32::NAN,
            1 => f32::INFINITY,
            _ => random.range(0.24, 0.36) as f32,
        };
        let depths = (0..camera.n_pixels()).map(depth).collect();
        let image = DepthImage::from_metres(8, 6, depths).unwrap();
        Frame::new(image, camera, look_at(position, DVec3::new(0.001, 0.002, 0.003)).unwrap(), 1.0).unwrap()
    };
    (0..3).map(|_| frame()).collect()
}

/// The voxels of a ray in order, up to and with the first occupied one.
type Walked = Vec<usize>;

/// All rays of a view that meet the box.
fn walked(snapshot: &Snapshot, pose: &Pose) -> Vec<Walked> {
    let (lattice, block) = (snapshot.lattice(), snapshot.block());
    let origin = lattice.to_voxels(pose.translation());
    let (camera, bounds) = (Intrinsics::d435i(), lattice.bounds(&block));
    let directions = directions(&camera, pose, &bounds, SPACING * lattice.voxel_size());
    let ray = |direction: DVec3| {
        let keys = crossed(block, origin, pose.rotation_matrix() * direction);
        let mut voxels: Vec<usize> = keys.into_iter().map(|key| block.index(key).unwrap()).collect();
        let first = voxels.iter().position(|&voxel| snapshot.occupancy()[voxel] == Occupancy::Occupied);
        voxels.truncate(first.map_or(voxels.len(), |first| first + 1));
        voxels
    };
    directions.into_iter().map(ray).filter(|voxels| !voxels.is_empty()).collect()
}

struct Definitions<'a> {
    snapshot: &'a Snapshot,
    frames: &'a [Frame],
    rays: Vec<Walked>,
}

impl Definitions<'_> {
    fn is(&self, voxel: usize, state: Occupancy) -> bool {
        self.snapshot.occupancy()[voxel] == state
    }

    fn p(&self, voxel: usize) -> f64 {
        self.snapshot.probability()[voxel] as f64
    }

    fn h(&self, voxel: usize) -> f64 {
        entropy(self.p(voxel))
    }

    /// P(vis) of the ith voxel of a ray.
    fn vis(&self, ray: &Walked, i: usize) -> f64 {
        ray[..i].iter().map(|&voxel| 1.0 - self.p(voxel)).product()
    }

    fn ends_occupied(&self, ray: &Walked) -> bool {
        ray.last().is_some_and(|&voxel| self.is(voxel, Occupancy::Occupied))
    }

    fn comes_from_behind(&self, ray: &Walked) -> bool {
        self.ends_occupied(ray) && ray.len() > 1 && self.is(ray[ray.len() - 2], Occupancy::Unknown)
    }

    fn sum(&self, counts: impl Fn(&Walked, usize) -> bool, value: impl Fn(&Walked, usize) -> f64) -> f64 {
        let of_ray =
            |ray: &Walked| -> f64 { (0..ray.len()).filter(|&i| counts(ray, i)).map(|i| value(ray, i)).sum() };
        self.rays.iter().map(of_ray).sum()
    }

    fn occlusion_aware(&self) -> f64 {
        self.sum(|_, _| true, |ray, i| self.vis(ray, i) * self.h(ray[i]))
    }

    fn unobserved_voxel(&self) -> f64 {
        let unknown = |ray: &Walked, i: usize| self.is(ray[i], Occupancy::Unknown);
        self.sum(unknown, |ray, i| self.vis(ray, i) * self.h(ray[i]))
    }

    fn rear_side_voxel(&self) -> f64 {
        self.rays.iter().filter(|ray| self.comes_from_behind(ray)).count() as f64
    }

    fn rear_side_entropy(&self) -> f64 {
        let in_run = |ray: &Walked, i: usize| {
            let before_surface = &ray[i..ray.len() - 1];
            self.comes_from_behind(ray) && before_surface.iter().all(|&v| self.is(v, Occupancy::Unknown))
        };
        self.sum(in_run, |ray, i| self.vis(ray, i) * self.h(ray[i]))
    }

    fn krainin(&self) -> f64 {
        self.sum(|ray, _| self.ends_occupied(ray), |ray, i| self.h(ray[i]))
    }

    fn average_entropy(&self) -> f64 {
        let number = self.sum(|ray, _| self.ends_occupied(ray), |_, _| 1.0);
        if number == 0.0 { 0.0 } else { self.krainin() / number }
    }

    /// Eqs. (4) to (15) in voxels of 1 cm, as they stand.
    fn potthast(&self) -> f64 {
        let of_ray = |ray: &Walked| -> f64 {
            let (mut v, mut o, mut gain) = (vec![1.0_f64], vec![0.0_f64], 0.0);
            for m in 1..=ray.len() {
                let (p, before) = (self.p(ray[m - 1]), if m == 1 { 0.5 } else { self.p(ray[m - 2]) });
                let (sees, returns, q) = (0.999_f64.powi(m as i32), 1e-8, 1.0 - before);
                let predicted = sees * v[m - 1] + returns * (1.0 - v[m - 1]);
                v.push(q * predicted / (q * predicted + (1.0 - q) * (1.0 - predicted)));
                let t = (1.0 + v[m]) / 2.0;
                let predicted = t * o[m - 1] + (1.0 - t) * (1.0 - o[m - 1]);
                o.push(p * predicted / (p * predicted + (1.0 - p) * (1.0 - predicted)));
                gain += self.h(ray[m - 1]) - entropy(o[m]);
            }
            gain
        };
        self.rays.iter().map(of_ray).sum::<f64>().max(0.0)
    }

    fn p_obj(&self, voxel: usize) -> f64 {
        let block = self.snapshot.block();
        let distance = |&f: &usize| (block.key(f) - block.key(voxel)).as_dvec3().length() * 0.01;
        let nearest = frontier(self.snapshot).iter().map(distance).fold(f64::INFINITY, f64::min);
        match self.is(voxel, Occupancy::Unknown) {
            true if nearest.is_finite() => (-(0.1 / 0.01 * nearest).powi(2)).exp(),
            true if self.snapshot.count(Occupancy::Occupied) == 0 => 1.0,
            _ => 0.0,
        }
    }

    fn apora(&self) -> f64 {
        let object: Vec<f64> = (0..self.snapshot.block().n_voxels()).map(|voxel| self.p_obj(voxel)).collect();
        let unknown = |ray: &Walked, i: usize| self.is(ray[i], Occupancy::Unknown);
        let unhidden = |ray: &Walked, i: usize| ray[..i].iter().map(|&v| 1.0 - object[v]).product::<f64>();
        self.sum(unknown, |ray, i| self.h(ray[i]) * object[ray[i]] * unhidden(ray, i))
    }

    fn is_occplane(&self, voxel: usize) -> bool {
        let block = self.snapshot.block();
        let faces = [IVec3::X, IVec3::Y, IVec3::Z, IVec3::NEG_X, IVec3::NEG_Y, IVec3::NEG_Z];
        let free =
            |step: &IVec3| block.index(block.key(voxel) + *step).is_some_and(|i| self.is(i, Occupancy::Free));
        self.is(voxel, Occupancy::Unknown)
            && self.snapshot.count(Occupancy::Occupied) > 0
            && faces.iter().any(free)
    }

    /// The measured points in the box, with the camera that saw them, in units of voxels.
    fn measured(&self) -> Vec<(DVec3, DVec3)> {
        let lattice = self.snapshot.lattice();
        let points = |frame: &Frame| {
            let camera = lattice.to_voxels(frame.world_from_camera().translation());
            let ends: Vec<(DVec3, bool)> =
                (0..frame.image().height()).flat_map(|v| frame.row_ray_ends(v)).collect();
            ends.into_iter().filter(|end| end.1).map(move |end| (lattice.to_voxels(end.0), camera))
        };
        let inside = |point: DVec3| self.snapshot.block().index(point.floor().as_ivec3()).is_some();
        self.frames.iter().flat_map(points).filter(|(point, _)| inside(*point)).collect()
    }

    /// d(x): of the surfaces whose rays go on through x, how many faces lie between at least.
    fn behind(&self, voxel: usize, measured: &[(DVec3, DVec3)]) -> Option<i32> {
        let key = self.snapshot.block().key(voxel);
        let cube = Aabb { min: key.as_dvec3(), max: (key + 1).as_dvec3() };
        let goes_through = |(point, camera): &&(DVec3, DVec3)| {
            cube.clip(*point, *point - *camera, f64::INFINITY).is_some_and(|(t_in, t_out)| t_out > t_in)
        };
        let faces = |(point, _): &(DVec3, DVec3)| (point.floor().as_ivec3() - key).abs().element_sum();
        measured.iter().filter(goes_through).map(faces).filter(|&d| d > 0).min()
    }

    fn proximity_count(&self) -> f64 {
        let measured = self.measured();
        let all = 0..self.snapshot.block().n_voxels();
        let nearness: Vec<i32> =
            all.map(|voxel| self.behind(voxel, &measured).map_or(0, |d| (60 - d).max(0))).collect();
        let unknown = |ray: &Walked, i: usize| self.is(ray[i], Occupancy::Unknown);
        self.sum(unknown, |ray, i| nearness[ray[i]] as f64)
    }

    fn area_factor(&self) -> f64 {
        let met: Vec<usize> = self
            .rays
            .iter()
            .filter_map(|ray| ray.iter().copied().find(|&voxel| !self.is(voxel, Occupancy::Free)))
            .collect();
        if met.is_empty() {
            return 0.0;
        }
        let share = |n: usize| n as f64 / met.len() as f64;
        let smooth = |t: f64| 3.0 * t.powi(2) - 2.0 * t.powi(3);
        let f = |a: f64, g: f64| if a < g { smooth(a / g) } else { 1.0 - smooth((a - g) / (1.0 - g)) };
        f(share(met.iter().filter(|&&v| self.is(v, Occupancy::Occupied)).count()), 0.2)
            + f(share(met.iter().filter(|&&v| self.is_occplane(v)).count()), 0.8)
    }
}

fn cast<G: InformationGain>(snapshot: &Snapshot, frames: &[Frame], pose: &Pose) -> f64 {
    let caster = RayCaster::new(snapshot, &Intrinsics::d435i(), SPACING, G::SIGHT).unwrap();
    let (gain, mut tally) = (G::new(snapshot, frames, &Cancel::default()).unwrap(), G::Tally::default());
    caster.cast(pose, |ray| gain.add(&ray, &mut tally));
    G::total(&tally)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn gains_of_views_are_those_of_the_definitions(
        states in prop::collection::vec(0_u8..20, 7 * 8 * 6), n_unknown in 0_u8..20, n_occupied in 0_u8..3,
        x in -0.4..0.4, y in -0.4..0.4, z in 0.15..0.4, seed in any::<u64>(),
    ) {
        let last = states.len() - 1;
        let state = |i: usize| match states[i] {
            _ if i == 0 || i == last => Occupancy::Unknown, // no free margin that clear rays would leave out
            n if n < n_occupied => Occupancy::Occupied,
            n if n < n_occupied + n_unknown => Occupancy::Unknown,
            _ => Occupancy::Free,
        };
        let snapshot = snapshot(IVec3::new(-3, -4, -2), UVec3::new(7, 8, 6), state);
        let pose = look_at(DVec3::new(x, y, z), DVec3::new(0.0034, -0.0021, 0.0057)).unwrap();
        let frames = frames(seed);
        let definitions = Definitions { snapshot: &snapshot, frames: &frames, rays: walked(&snapshot, &pose) };
        for (name, found, expected) in [
            ("oa", cast::<OcclusionAware>(&snapshot, &frames, &pose), definitions.occlusion_aware()),
            ("uv", cast::<UnobservedVoxel>(&snapshot, &frames, &pose), definitions.unobserved_voxel()),
            ("rsv", cast::<RearSideVoxel>(&snapshot, &frames, &pose), definitions.rear_side_voxel()),
            ("rse", cast::<RearSideEntropy>(&snapshot, &frames, &pose), definitions.rear_side_entropy()),
            ("krainin", cast::<Krainin>(&snapshot, &frames, &pose), definitions.krainin()),
            ("ae", cast::<AverageEntropy>(&snapshot, &frames, &pose), definitions.average_entropy()),
            ("potthast", cast::<Potthast>(&snapshot, &frames, &pose), definitions.potthast()),
            ("apora", cast::<Apora>(&snapshot, &frames, &pose), definitions.apora()),
            ("pc", cast::<ProximityCount>(&snapshot, &frames, &pose), definitions.proximity_count()),
            ("area", cast::<AreaFactor>(&snapshot, &frames, &pose), definitions.area_factor()),
        ] {
            prop_assert!((found - expected).abs() <= 1e-6 * expected.max(1e-3), "{}: {} {}", name, found, expected);
        }
    }
}
