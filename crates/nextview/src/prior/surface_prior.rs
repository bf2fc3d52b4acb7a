use super::{Network, VoxelFeatures};
use crate::map::Snapshot;
use glam::Vec3;

/// What learning made of many scans: `docs/planner.md` tells how.
const WEIGHTS: &[u8] = include_bytes!("weights.bin");

/// How probable unseen surface is where nothing is measured, and in free voxels at its border.
///
/// ```
/// use glam::{IVec3, UVec3};
/// use nextview::geometry::{Lattice, VoxelBlock};
/// use nextview::map::Snapshot;
/// use nextview::prior::SurfacePrior;
///
/// let block = VoxelBlock::new(IVec3::ZERO, UVec3::splat(20)).unwrap();
/// let unknown = Snapshot::from_fn(Lattice::new(0.005).unwrap(), block, |_| None);
/// let estimate = SurfacePrior::default().estimate(&unknown);
/// assert_eq!(estimate.len(), 20 * 20 * 20);
/// assert!((0..estimate.len()).all(|i| (0.0..=1.0).contains(&estimate.stops(i))));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SurfacePrior {
    stops: Network,
    shows: Network,
}

/// How well a view sees a voxel: a class of views that are alike to the prior.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sighting(u8);

/// What the prior makes of a snapshot: for each voxel that may hold unseen surface, in the order of their indices.
#[derive(Clone, Debug)]
pub struct SurfaceEstimate {
    voxels: Vec<u32>,
    normals: Vec<Vec3>,
    stops: Vec<f32>,
    shows: Vec<f32>,
}

impl Sighting {
    /// How many classes there are.
    pub const N: usize = 25;

    /// Bounds between classes of visibility: how likely a ray comes to the voxel, 0..=1.
    const VISIBILITIES: [f32; 4] = [0.12, 0.3, 0.6, 0.9];

    /// Bounds between classes of the cosine between the direction to the camera and that to free space.
    const FACINGS: [f32; 4] = [-0.5, -0.15, 0.15, 0.5];

    /// The class of a visibility, 0..=1, and a cosine, -1..=1.
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
    /// The prior that planning uses.
    fn default() -> Self {
        Self::from_bytes(WEIGHTS).expect("the weights in the library are whole")
    }
}

impl SurfacePrior {
    /// The prior of these two networks: whether rays stop in a voxel, with one output, and whether a view shows new surface in it, with an output for
    /// each [`Sighting`].
    pub fn new(stops: Network, shows: Network) -> Self {
        Self { stops, shows }
    }

    /// Reads what [`to_bytes`](Self::to_bytes) wrote; none if it is of another length or holds numbers that are not finite.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (numbers, rest) = bytes.as_chunks::<4>();
        let numbers: Vec<f32> = numbers.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        let (stops, shows) = numbers.split_at_checked(Network::n_numbers(1)).filter(|_| rest.is_empty())?;
        Some(Self {
            stops: Network::from_numbers(stops, 1)?,
            shows: Network::from_numbers(shows, Sighting::N)?,
        })
    }

    /// The numbers of both networks, four bytes each, the least significant first.
    pub fn to_bytes(&self) -> Vec<u8> {
        let numbers = [self.stops.numbers(), self.shows.numbers()].concat();
        numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
    }

    /// What is probable under what the snapshot knows.
    pub fn estimate(&self, snapshot: &Snapshot) -> SurfaceEstimate {
        let VoxelFeatures { voxels, rows, normals } = VoxelFeatures::new(snapshot);
        let stops = self.stops.probabilities(&rows);
        let shows = self.shows.probabilities(&rows);
        SurfaceEstimate { voxels, normals, stops, shows }
    }
}

impl SurfaceEstimate {
    /// How many voxels may hold unseen surface.
    pub fn len(&self) -> usize {
        self.voxels.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.voxels.is_empty()
    }

    /// The voxels, as indices into the snapshot, increasing.
    pub fn voxels(&self) -> &[u32] {
        &self.voxels
    }

    /// Where free space lies around the `i`-th voxel: a direction of length 1, or 0 where there is none.
    pub fn normal(&self, i: usize) -> Vec3 {
        self.normals[i]
    }

    /// The probability, 0..=1, that a ray ends in the `i`-th voxel once it has come there.
    pub fn stops(&self, i: usize) -> f32 {
        self.stops[i]
    }

    /// The probability, 0..=1, that a view shows surface in the `i`-th voxel that was not seen before.
    pub fn shows(&self, i: usize, sighting: Sighting) -> f32 {
        self.shows[i * Sighting::N + sighting.index()]
    }
}
