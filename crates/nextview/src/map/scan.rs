use super::integration::{Background, Integration, RayRule};
use super::key_box::KeyBox;
use crate::geometry::{Lattice, VoxelKey};
use crate::instructions::instructions;
use crate::sensor::Frame;
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

/// The content of a scan, in units of voxels: the ends of its rays and the voxels with a surface.
#[derive(Default)]
pub(super) struct VoxelScan {
    pub ends: Vec<DVec3>,
    /// The voxels with a surface; they may occur several times.
    pub hits: Vec<VoxelKey>,
    /// The voxel, as integers, in which the last ray ended, and the last voxel hit.
    last_end: Option<DVec3>,
    last_hit: Option<DVec3>,
}

/// The rules for the rays of a scan.
#[derive(Clone, Copy)]
pub(super) struct ScanRules {
    /// The start of all rays, in units of voxels.
    pub origin: DVec3,
    pub region: Option<KeyBox>,
    lattice: Lattice,
    integration: Integration,
}

impl ScanRules {
    pub fn new(lattice: Lattice, origin: DVec3, integration: &Integration) -> Self {
        Self {
            origin: lattice.to_voxels(origin),
            region: integration.region.map(KeyBox::of),
            lattice,
            integration: *integration,
        }
    }

    /// Returns the scan of a frame.
    pub fn scan_of_frame(&self, frame: &Frame) -> VoxelScan {
        let rows = (0..frame.image().height()).into_par_iter();
        let parts = rows.map(|v| self.scan(frame.row_ray_ends(v)));
        VoxelScan::union(parts.collect(), self)
    }

    /// Returns the scan with these ray ends, in world coordinates, each with whether it is a surface.
    pub fn scan(&self, ends: impl Iterator<Item = (DVec3, bool)>) -> VoxelScan {
        let mut scan = VoxelScan::default();
        instructions().dispatch(
            #[inline(always)]
            || {
                for (end, hit) in ends {
                    self.add(&mut scan, end, hit);
                }
            },
        );
        scan
    }

    #[inline(always)]
    fn add(&self, scan: &mut VoxelScan, end: DVec3, hit: bool) {
        let hit = hit && self.integration.ground.is_none_or(|ground| ground.height(end) > 0.0);
        let end = self.lattice.to_voxels(end);
        // Not yet a key: conversion to integers costs more than everything else here.
        let floor = end.floor();
        let is_in = self.region.is_none_or(|region| region.contains_floor(floor));
        if is_in && hit && scan.last_hit != Some(floor) {
            scan.hits.push(floor.as_ivec3());
            scan.last_hit = Some(floor);
        }
        let end = match self.integration.rays {
            RayRule::EveryPoint => end,
            // Neighbours in the image mostly end in the same voxel.
            RayRule::OnePerEndVoxel if scan.last_end == Some(floor) => return,
            RayRule::OnePerEndVoxel => floor + 0.5,
        };
        scan.last_end = Some(floor);
        let counts = is_in
            || self.integration.background == Background::Carve
                && self.region.is_none_or(|region| region.is_near(self.origin, end));
        if counts {
            scan.ends.push(end);
        }
    }
}

/// Rays are cut at this distance from the lattice's origin, in voxels along each axis: far beyond all keys,
/// and near enough for exact integers.
const FAR: f64 = (1_u64 << 45) as f64;

impl ScanRules {
    /// Returns the end of a ray, or the point at which it is cut; `None` if the end is not a number.
    fn shortened(&self, end: DVec3) -> Option<DVec3> {
        if end.abs().cmple(DVec3::splat(FAR)).all() {
            return Some(end);
        }
        let along = end - self.origin;
        along.is_finite().then(|| self.origin + along * (0.5 * FAR / along.abs().max_element()))
    }
}

impl VoxelScan {
    /// Merges several scans into one; each end counts once if the rule says so.
    pub fn union(parts: Vec<Self>, rules: &ScanRules) -> Self {
        let ends = parts.iter().flat_map(|part| &part.ends);
        let mut ends: Vec<DVec3> = ends.filter_map(|end| rules.shortened(*end)).collect();
        if rules.integration.rays == RayRule::OnePerEndVoxel {
            let mut seen = FxHashSet::with_capacity_and_hasher(ends.len(), Default::default());
            ends.retain(|end| seen.insert((end - 0.5).as_ivec3()));
        }
        Self { ends, hits: parts.into_iter().flat_map(|part| part.hits).collect(), ..Self::default() }
    }

    /// Returns the part of the scan that affects a box.
    pub fn within(&self, origin: DVec3, keys: &KeyBox) -> Self {
        Self {
            ends: self.ends.iter().filter(|end| keys.is_near(origin, **end)).copied().collect(),
            hits: self.hits.iter().filter(|hit| keys.contains(**hit)).copied().collect(),
            ..Self::default()
        }
    }

    /// Returns the box of all voxels that the rays may cross; `None` if there are no rays.
    pub fn reach(&self, origin: DVec3) -> Option<KeyBox> {
        let start = origin.floor().as_ivec3();
        let grow = |reach: KeyBox, end: &DVec3| reach.with(end.floor().as_ivec3());
        (!self.ends.is_empty()).then(|| self.ends.iter().fold(KeyBox { min: start, max: start }, grow))
    }
}
