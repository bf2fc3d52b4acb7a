use super::Slips;
use super::map::{FREE, Knowledge, OCCUPIED};
use super::rays::PlanningRays;
use crate::Outcome;
use nextview::Cancel;
use nextview::gain::object_probability;
use nextview::map::{Occupancy, entropy, frontier};

/// The value of the voxels along rays: eqs. (1) and (2).
pub struct Qualities {
    /// By voxel, entropy times the probability that it belongs to the object.
    worth: Vec<f64>,
    /// By voxel, the share of sight left behind it along a ray.
    sight: Vec<f64>,
}

impl Qualities {
    /// Computes the qualities of a map.
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

    /// Returns the quality Q of each voxel along a ray, without those of no worth or out of sight.
    pub fn along(&self, voxels: &[u32]) -> impl Iterator<Item = (u32, f64)> {
        let mut sight = 1.0;
        let quality = voxels.iter().map(move |&voxel| {
            let quality = self.worth[voxel as usize] * sight;
            sight *= self.sight[voxel as usize];
            (voxel, quality)
        });
        quality.filter(|&(_, quality)| quality > 0.0)
    }

    /// Returns the local gain of every view, eq. (1).
    pub fn local_gains(&self, rays: &PlanningRays) -> Vec<f64> {
        let sum = |voxels: &Vec<u32>| self.along(voxels).map(|(_, quality)| quality).sum();
        let of_ray: Vec<f64> = rays.voxels.iter().map(sum).collect();
        let of_view = |numbers: &Vec<u32>| numbers.iter().map(|&ray| of_ray[ray as usize]).sum();
        rays.of_view.iter().map(of_view).collect()
    }
}
