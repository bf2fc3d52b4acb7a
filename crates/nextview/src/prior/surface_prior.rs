use super::{Network, VoxelFeatures};
use crate::map::Snapshot;
use crate::{Cancel, Cancelled};
use glam::Vec3;

/// Weights learned from many scans; `docs/planner.md` describes the training.
const WEIGHTS: &[u8] = include_bytes!("weights.bin");

/// The probability of unseen surface in unmeasured voxels, and in free voxels at their border.
///
/// ```
/// use glam::{IVec3, UVec3};
/// use nextview::geometry::{Lattice, VoxelBlock};
/// use nextview::map::Snapshot;
/// use nextview::Cancel;
/// use nextview::prior::SurfacePrior;
///
/// let block = VoxelBlock::new(IVec3::ZERO, UVec3::splat(20)).unwrap();
/// let unknown = Snapshot::from_fn(Lattice::new(0.005).unwrap(), block, |_| None);
/// let estimate = SurfacePrior::default().estimate(&unknown, &Cancel::default()).unwrap();
/// assert_eq!(estimate.len(), 20 * 20 * 20);
/// assert!((0..estimate.len()).all(|i| (0.0..=1.0).contains(&estimate.stops(i))));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SurfacePrior {
    stops: Network,
    shows: Network,
}

/// How well a view sees a voxel: a class of views that the prior does not distinguish.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ViewingClass(u8);

/// The prior's estimate for a snapshot: for each voxel that may hold unseen surface, in the order of their
/// indices.
#[derive(Clone, Debug)]
pub struct SurfaceEstimate {
    voxels: Vec<u32>,
    normals: Vec<Vec3>,
    stops: Vec<f32>,
    /// Class by class, each with all voxels: a view reaches neighbours in sequence, most of them in one
    /// class, and these share cache lines.
    shows: Vec<f32>,
}

impl ViewingClass {
    /// Number of classes.
    pub const N: usize = 25;

    /// Bounds between classes of visibility: the probability that a ray reaches the voxel, 0..=1.
    const VISIBILITIES: [f32; 4] = [0.12, 0.3, 0.6, 0.9];

    /// Bounds between classes of the cosine between the direction to the camera and that to free space.
    const FACINGS: [f32; 4] = [-0.5, -0.15, 0.15, 0.5];

    /// Returns the class of a visibility, 0..=1, and a cosine, -1..=1.
    pub fn new(visibility: f32, facing: f32) -> Self {
        let class = |bounds: &[f32], value: f32| bounds.iter().filter(|&&bound| value >= bound).count();
        let n_facings = Self::FACINGS.len() + 1;
        Self((class(&Self::VISIBILITIES, visibility) * n_facings + class(&Self::FACINGS, facing)) as u8)
    }

    /// The number of the class, below [`N`](Self::N).
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl Default for SurfacePrior {
    /// The prior used for planning.
    fn default() -> Self {
        Self::from_bytes(WEIGHTS).expect("the weights in the library are whole")
    }
}

impl SurfacePrior {
    /// Creates a prior from two networks: `stops` for whether rays end in a voxel, with one output, and
    /// `shows` for whether a view shows new surface in it, with an output for each [`ViewingClass`].
    ///
    /// Panics if a network has another number of outputs.
    pub fn new(stops: Network, shows: Network) -> Self {
        let n_outputs = (stops.n_outputs(), shows.n_outputs());
        assert_eq!(n_outputs, (1, ViewingClass::N), "outputs of the networks of a prior");
        Self { stops, shows }
    }

    /// Reads the bytes written by [`to_bytes`](Self::to_bytes); `None` if they have another length or hold
    /// numbers that are not finite.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (numbers, rest) = bytes.as_chunks::<4>();
        let numbers: Vec<f32> = numbers.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        let (stops, shows) = numbers.split_at_checked(Network::n_numbers(1)).filter(|_| rest.is_empty())?;
        Some(Self::new(Network::from_numbers(stops, 1)?, Network::from_numbers(shows, ViewingClass::N)?))
    }

    /// Returns the numbers of both networks, four bytes each, the least significant first.
    pub fn to_bytes(&self) -> Vec<u8> {
        let numbers = [self.stops.numbers(), self.shows.numbers()].concat();
        numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
    }

    /// Returns the estimate for a snapshot.
    ///
    /// Fails if `cancel` is set.
    pub fn estimate(&self, snapshot: &Snapshot, cancel: &Cancel) -> Result<SurfaceEstimate, Cancelled> {
        let VoxelFeatures { voxels, rows, normals } = VoxelFeatures::new(snapshot, cancel)?;
        let stops = self.stops.probabilities(&rows, cancel)?;
        let shows = self.shows.probabilities(&rows, cancel)?;
        Ok(SurfaceEstimate { voxels, normals, stops, shows: by_class(shows.as_chunks().0) })
    }
}

impl SurfaceEstimate {
    /// Creates an estimate of your own for the voxels of a snapshot, by increasing index. Each has the
    /// direction of free space, of length 1 or 0, the probability, 0..=1, that a ray ends there, and for each
    /// [`ViewingClass`] the probability that a view shows unseen surface in it.
    ///
    /// # Panics
    /// If the numbers of voxels, directions and probabilities differ.
    pub fn new(
        voxels: Vec<u32>,
        normals: Vec<Vec3>,
        stops: Vec<f32>,
        shows: Vec<[f32; ViewingClass::N]>,
    ) -> Self {
        let n = voxels.len();
        assert_eq!((normals.len(), stops.len(), shows.len()), (n, n, n), "as many of each as voxels");
        Self { voxels, normals, stops, shows: by_class(&shows) }
    }

    /// Number of voxels that may hold unseen surface.
    pub fn len(&self) -> usize {
        self.voxels.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.voxels.is_empty()
    }

    /// The voxels, as increasing indices into the snapshot.
    pub fn voxels(&self) -> &[u32] {
        &self.voxels
    }

    /// The direction of free space around the `i`-th voxel, of length 1, or 0 if there is none.
    pub fn normal(&self, i: usize) -> Vec3 {
        self.normals[i]
    }

    /// The probability, 0..=1, that a ray ends in the `i`-th voxel once it has reached it.
    pub fn stops(&self, i: usize) -> f32 {
        self.stops[i]
    }

    /// Multiplies the probabilities that a view shows surface in the `i`-th voxel by this factor, 0..=1.
    pub(crate) fn scale(&mut self, i: usize, factor: f32) {
        let n = self.len();
        self.shows[i..].iter_mut().step_by(n).for_each(|p| *p *= factor);
    }

    /// The probability, 0..=1, that a view newly shows surface in the `i`-th voxel.
    pub fn shows(&self, i: usize, class: ViewingClass) -> f32 {
        self.shows[class.index() * self.len() + i]
    }
}

/// The probabilities class by class, each with all voxels.
fn by_class(of_voxels: &[[f32; ViewingClass::N]]) -> Vec<f32> {
    let n = of_voxels.len();
    let mut by_class = vec![0.0; n * ViewingClass::N];
    for (i, of_voxel) in of_voxels.iter().enumerate() {
        by_class[i..].iter_mut().step_by(n).zip(of_voxel).for_each(|(to, from)| *to = *from);
    }
    by_class
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;
    use crate::geometry::{Lattice, VoxelBlock};
    use crate::map::LogOdds;
    use glam::{IVec3, UVec3};

    fn network(seed: u64, n_outputs: usize) -> Network {
        let mut random = Random::new(seed, 0);
        let numbers: Vec<f32> =
            (0..Network::n_numbers(n_outputs)).map(|_| random.range(-0.5, 0.5) as f32).collect();
        Network::from_numbers(&numbers, n_outputs).unwrap()
    }

    fn prior() -> SurfacePrior {
        SurfacePrior::new(network(1, 1), network(2, ViewingClass::N))
    }

    #[test]
    fn sightings_are_five_classes_of_visibility_times_five_of_facing() {
        let below = |bound: f32| bound.next_down();
        let visibilities =
            [[0.0, below(0.12)], [0.12, below(0.3)], [0.3, below(0.6)], [0.6, below(0.9)], [0.9, 1.0]];
        let facings =
            [[-1.0, below(-0.5)], [-0.5, below(-0.15)], [-0.15, below(0.15)], [0.15, below(0.5)], [0.5, 1.0]];
        let mut index = 0;
        for visibilities in visibilities {
            for facings in facings {
                for (visibility, facing) in visibilities.into_iter().flat_map(|v| facings.map(|f| (v, f))) {
                    assert_eq!(ViewingClass::new(visibility, facing).index(), index, "{visibility} {facing}");
                }
                index += 1;
            }
        }
        assert_eq!(index, ViewingClass::N);
    }

    #[test]
    fn without_a_direction_a_sighting_is_the_lowest_of_its_visibility() {
        assert_eq!(ViewingClass::new(1.0, f32::NAN).index(), 20);
    }

    #[test]
    #[should_panic(expected = "outputs of the networks of a prior")]
    fn networks_change_no_places() {
        SurfacePrior::new(network(1, ViewingClass::N), network(2, 1));
    }

    #[test]
    fn bytes_say_it_all() {
        let prior = prior();
        let bytes = prior.to_bytes();
        assert_eq!(bytes.len(), 4 * (Network::n_numbers(1) + Network::n_numbers(ViewingClass::N)));
        assert_eq!(SurfacePrior::from_bytes(&bytes), Some(prior));
        assert_eq!(SurfacePrior::default().to_bytes(), WEIGHTS);
    }

    #[test]
    fn broken_bytes_are_no_prior() {
        let bytes = prior().to_bytes();
        for len in [0, 1, 4, 4 * Network::n_numbers(1), bytes.len() - 4, bytes.len() - 1] {
            assert_eq!(SurfacePrior::from_bytes(&bytes[..len]), None, "{len} bytes");
        }
        for more in [1, 4] {
            assert_eq!(SurfacePrior::from_bytes(&[&bytes[..], &vec![0; more]].concat()), None);
        }
        for place in [0, bytes.len() - 4] {
            let mut bytes = bytes.clone();
            bytes[place..place + 4].copy_from_slice(&f32::NAN.to_le_bytes());
            assert_eq!(SurfacePrior::from_bytes(&bytes), None, "NaN at {place}");
        }
    }

    #[test]
    fn estimates_what_its_networks_make_of_the_features() {
        let block = VoxelBlock::new(IVec3::splat(-3), UVec3::new(7, 5, 6)).unwrap();
        let snapshot = Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |key| {
            let kind = (key.x + 2 * key.y + 3 * key.z).rem_euclid(7);
            [None, Some(0.85), Some(-0.4)].get(kind as usize).copied().flatten().map(LogOdds)
        });
        let cancel = &Cancel::default();
        let (prior, features) = (prior(), VoxelFeatures::new(&snapshot, cancel).unwrap());
        let estimate = prior.estimate(&snapshot, cancel).unwrap();
        assert!(!estimate.is_empty());
        assert_eq!((estimate.len(), estimate.voxels()), (features.voxels.len(), &features.voxels[..]));
        let class = ViewingClass::new(0.7, 0.2);
        for (i, row) in features.rows.iter().enumerate() {
            assert_eq!(estimate.normal(i), features.normals[i]);
            assert_eq!(estimate.stops(i), prior.stops.probabilities(&[*row], cancel).unwrap()[0]);
            assert_eq!(
                estimate.shows(i, class),
                prior.shows.probabilities(&[*row], cancel).unwrap()[class.index()]
            );
        }
    }
}
