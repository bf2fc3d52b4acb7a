//! The paper's flow network of a decision: views, rays and voxels.

use crate::plain_files;
use crate::workload::{Set, Workload, intrinsics};
use nextview::Cancel;
use nextview::flow::{BestSets, fewest_sets};
use nextview::gain::LocalGain;
use nextview::visibility::{FreeSpace, RayCaster};
use std::error::Error;
use std::path::Path;

/// Minimum quality of voxels on a ray in the network. The code of the paper's authors uses 0.3; the lower
/// limit gives as many voxels as their largest networks have, about a thousand.
const MIN_QUALITY: f64 = 0.1;

/// Distance between the candidate rays for the network, voxels: small enough for enough rays.
const RAY_SPACING: f64 = 1.5;

/// Rays of the views and the quality of the voxels on them.
#[derive(Clone, Debug)]
pub struct RayNetwork {
    /// The view of every ray, ascending.
    pub view_of_ray: Vec<u32>,
    /// Ray, voxel, quality.
    pub edges: Vec<(u32, u32, f64)>,
    /// Number of views.
    pub n_views: usize,
    /// Number of voxels.
    pub n_voxels: usize,
}

impl RayNetwork {
    /// Creates a network of this many rays with a voxel on them, spread over all views, after the first image
    /// at 1 cm; of fewer rays if there are fewer.
    pub fn of(workload: &Workload, n_rays: usize) -> Self {
        let snapshot = workload.snapshot(Set::A, 0.01, 1);
        let gain = LocalGain::new(&snapshot, &Cancel::default()).expect("nobody cancels");
        let caster = RayCaster::new(&snapshot, &intrinsics(), RAY_SPACING, FreeSpace::Fades)
            .expect("the spacing is written in the source");
        let mut rays = Vec::new();
        for (view, pose) in workload.views.poses().iter().enumerate() {
            caster.cast(pose, |ray| {
                let edges = ray.crossings.iter().map(|crossing| (crossing.voxel, gain.quality(crossing)));
                let edges: Vec<(u32, f64)> = edges.filter(|(_, quality)| *quality > MIN_QUALITY).collect();
                if !edges.is_empty() {
                    rays.push((view as u32, edges));
                }
            });
        }
        let n_voxels = snapshot.block().n_voxels();
        let mut network =
            Self { view_of_ray: Vec::new(), edges: Vec::new(), n_views: workload.views.len(), n_voxels };
        // Every k-th ray, with a fractional k.
        let is_kept =
            |i: usize| i * n_rays / rays.len() != (i + 1) * n_rays / rays.len() || rays.len() <= n_rays;
        for (view, edges) in (0..rays.len()).filter(|&i| is_kept(i)).map(|i| &rays[i]) {
            let ray = network.view_of_ray.len() as u32;
            network.view_of_ray.push(*view);
            network.edges.extend(edges.iter().map(|&(voxel, quality)| (ray, voxel, quality)));
        }
        network
    }

    /// Returns the views of the optimal flow, with a small number of views.
    pub fn solve(&self) -> Vec<u32> {
        let mut best = BestSets::new(self.n_voxels, self.n_views);
        for &(ray, voxel, quality) in &self.edges {
            best.offer(voxel as usize, self.view_of_ray[ray as usize], quality);
        }
        fewest_sets(best.candidates(), &Cancel::default()).expect("nobody cancels")
    }

    /// Writes the network for the peers: numbers of views, rays, voxels and edges (i32), the view of every
    /// ray (i32), ray and voxel of every edge (i32), quality of every edge (f64).
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Box<dyn Error>> {
        let sizes = [self.n_views, self.view_of_ray.len(), self.n_voxels, self.edges.len()];
        let ends = self.edges.iter().flat_map(|&(ray, voxel, _)| [ray, voxel]);
        let whole = sizes.iter().map(|&n| n as u32).chain(self.view_of_ray.iter().copied()).chain(ends);
        let mut bytes: Vec<u8> = whole.flat_map(|n| (n as i32).to_le_bytes()).collect();
        bytes.extend(self.edges.iter().flat_map(|(_, _, quality)| quality.to_le_bytes()));
        plain_files::write(path, &bytes)
    }
}
