use crate::Outcome;
use glam::DVec3;
use nextview::geometry::{Aabb, Lattice, VoxelBlock, VoxelKey};
use nextview_octomap::Octree;
use std::fs::File;
use std::path::Path;
use std::str::FromStr;

/// The views of the authors' recorded run, by number.
pub const RECORDED_VIEWS: [usize; 10] = [0, 5, 1, 6, 7, 1012, 2957, 3104, 2204, 1866];

/// Edge of a voxel of the map, in metres.
pub const VOXEL_SIZE: f64 = 0.01;

/// Number of scans of a run.
pub const N_SCANS: usize = RECORDED_VIEWS.len();

/// The authors' recorded Armadillo run: candidates, box, true shape and the map after each scan.
pub struct RecordedRun {
    /// Positions of the candidate cameras, in metres. All look at `center`; the first view is candidate 0.
    pub positions: Vec<DVec3>,
    /// Centre of the object's box, in metres.
    pub center: DVec3,
    /// Half the side of that box, a cube, in metres.
    pub half: f64,
    /// The voxels of 1 cm with their centre in the box, which the program plans with and counts.
    pub block: VoxelBlock,
    /// The voxels that the program creates with log-odds 0 before the first scan: `block` and, because it
    /// steps through the box from the low corner, layers with centres just outside.
    pub created: VoxelBlock,
    /// The voxels of 2 mm that hold surface.
    pub surface: Vec<VoxelKey>,
    /// Number of voxels of 1 cm that hold surface.
    pub n_object_voxels: usize,
    /// By scan, the log-odds of the voxels of `created`; 0 without measurements.
    pub maps: Vec<Vec<f32>>,
}

impl RecordedRun {
    /// Reads the folder; an error names the file and its fault.
    pub fn read(folder: &Path) -> Outcome<Self> {
        let path = folder.join("candidate_views.txt");
        let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let candidates =
            CandidateFile::parse(&text).map_err(|error| format!("{}: {error}", path.display()))?;
        let lattice = Lattice::new(VOXEL_SIZE)?;
        let aabb = Aabb::cube(candidates.center, candidates.half);
        let block = lattice.block_inside(&aabb).ok_or_else(|| {
            format!("{}: a box of half-side {} m holds no voxel of 1 cm", path.display(), candidates.half)
        })?;
        let created = created_voxels(&aabb).ok_or_else(|| {
            format!("{}: a box of {} m is too large", path.display(), 2.0 * candidates.half)
        })?;
        let maps = (0..N_SCANS).map(|scan| recorded_map(&folder.join(format!("octomap{scan}.ot")), created));
        Ok(Self {
            positions: candidates.positions,
            center: candidates.center,
            half: candidates.half,
            block,
            created,
            surface: voxels(&folder.join("ground_truth_2mm.ot"), 0.002)?,
            n_object_voxels: voxels(&folder.join("ground_truth_1cm.ot"), VOXEL_SIZE)?.len(),
            maps: maps.collect::<Outcome<_>>()?,
        })
    }
}

fn created_voxels(aabb: &Aabb) -> Option<VoxelBlock> {
    let low = (aabb.min / VOXEL_SIZE).floor().as_ivec3();
    let steps = (aabb.size() / VOXEL_SIZE).floor();
    let high = (aabb.min / VOXEL_SIZE + steps).floor().as_ivec3();
    VoxelBlock::new(low, (high - low + 1).as_uvec3())
}

/// The content of `candidate_views.txt`.
struct CandidateFile {
    positions: Vec<DVec3>,
    center: DVec3,
    half: f64,
}

impl CandidateFile {
    fn parse(text: &str) -> Outcome<Self> {
        let mut words = text.split_whitespace();
        let n: usize = next(&mut words, "the number of views")?;
        let center = point(&mut words, "the centre of the object")?;
        let half = next(&mut words, "the half-side of the box")?;
        let positions = (0..n).map(|view| point(&mut words, &format!("the position of view {view}")));
        let positions: Vec<_> = positions.collect::<Outcome<_>>()?;
        if let Some(rest) = words.next() {
            return Err(
                format!("'{rest}' follows the last of {n} views, expected the end of the file").into()
            );
        }
        if let Some(&view) = RECORDED_VIEWS.iter().find(|&&view| view >= n) {
            return Err(
                format!("{n} views, expected more, because the recorded run takes view {view}").into()
            );
        }
        Ok(Self { positions, center, half })
    }
}

fn next<'a, T: FromStr>(words: &mut impl Iterator<Item = &'a str>, what: &str) -> Outcome<T> {
    let word = words.next().ok_or_else(|| format!("ends before {what}"))?;
    word.parse().map_err(|_| format!("{what} is '{word}', expected a number").into())
}

fn point<'a>(words: &mut impl Iterator<Item = &'a str>, what: &str) -> Outcome<DVec3> {
    let point = DVec3::new(next(words, what)?, next(words, what)?, next(words, what)?);
    if point.is_finite() && point.length() < 1e3 {
        return Ok(point);
    }
    Err(format!("{what} is {point}, expected a point within 1000 m of the origin").into())
}

fn octree(path: &Path, voxel_size: f64) -> Outcome<Octree> {
    let name = path.display();
    let file = File::open(path).map_err(|error| format!("{name}: {error}"))?;
    let octree = Octree::read(file).map_err(|error| format!("{name}: {error}"))?;
    if octree.voxel_size() != voxel_size {
        return Err(format!("{name}: voxels of {} m, expected {voxel_size} m", octree.voxel_size()).into());
    }
    Ok(octree)
}

/// The voxels of a tree with only occupied ones.
fn voxels(path: &Path, voxel_size: f64) -> Outcome<Vec<VoxelKey>> {
    let tree = octree(path, voxel_size)?.expanded(1 << 20).map_err(|e| format!("{}: {e}", path.display()))?;
    let voxels: Vec<_> = tree.leaves().map(|leaf| leaf.min).collect();
    if voxels.is_empty() {
        return Err(format!("{}: no voxels, expected those of the object", path.display()).into());
    }
    Ok(voxels)
}

fn recorded_map(path: &Path, block: VoxelBlock) -> Outcome<Vec<f32>> {
    let tree = octree(path, VOXEL_SIZE)?;
    let mut log_odds = vec![0.0; block.n_voxels()];
    for leaf in tree.leaves() {
        let Some((low, high)) = leaf.part_between(block.min(), block.max()) else { continue };
        let part = VoxelBlock::new(low, (high - low + 1).as_uvec3());
        let part = part.ok_or_else(|| format!("{}: a leaf of impossible size at {low}", path.display()))?;
        for key in (0..part.n_voxels()).map(|voxel| part.key(voxel)) {
            log_odds[block.index(key).ok_or("a leaf leaves the box")?] = leaf.log_odds;
        }
    }
    Ok(log_odds)
}
