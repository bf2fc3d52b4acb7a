use super::map::{FREE, Knowledge, OCCUPIED};
use super::rays::Rays;
use super::{Outcome, Slips};
use nextview::Cancel;
use nextview::gain::object_probability;
use nextview::map::{Occupancy, entropy, frontier};

/// The worth of the voxels that rays cross: eqs. (1) and (2).
pub struct Qualities {
    /// By voxel, entropy times the probability that it belongs to the object.
    worth: Vec<f64>,
    /// By voxel, how much of the sight along a ray is left behind it.
    sight: Vec<f64>,
}

impl Qualities {
    /// Those of a map.
    pub fn new(knowledge: &Knowledge, slips: Slips) -> Outcome<Self> {
        let snapshot = &knowledge.snapshot;
        let object = object_probability(snapshot, &frontier(snapshot), &Cancel::default())?;
        let worth = object.iter().zip(&knowledge.probability).map(|(object, &p)| object * entropy(p));
        let occupied = |voxel: usize| snapshot.occupancy()[voxel] == Occupancy::Occupied;
        let sight = knowledge.probability.iter().enumerate().map(|(voxel, &p)| match slips.linear_sight {
            true => ((OCCUPIED - p) / (OCCUPIED - FREE)).clamp(0.0, 1.0),
            false if occupied(voxel) => 0.0,
            false => 1.0 - p,
        });
        Ok(Self { sight: sight.collect(), worth: worth.collect() })
    }

    /// The quality Q of each voxel along a ray; those of no worth and those out of sight are left out.
    pub fn along(&self, voxels: &[u32]) -> impl Iterator<Item = (u32, f64)> {
        let mut sight = 1.0;
        let quality = voxels.iter().map(move |&voxel| {
            let quality = self.worth[voxel as usize] * sight;
            sight *= self.sight[voxel as usize];
            (voxel, quality)
        });
        quality.filter(|&(_, quality)| quality > 0.0)
    }

    /// The local gain of every view, eq. (1).
    pub fn local_gains(&self, rays: &Rays) -> Vec<f64> {
        let sum = |voxels: &Vec<u32>| self.along(voxels).map(|(_, quality)| quality).sum();
        let of_ray: Vec<f64> = rays.voxels.iter().map(sum).collect();
        let of_view = |numbers: &Vec<u32>| numbers.iter().map(|&ray| of_ray[ray as usize]).sum();
        rays.of_view.iter().map(of_view).collect()
    }
}
