//! The common input of all benchmarks.

use crate::alignment::OffsetPoints;
use crate::plain_files;
use glam::{DVec2, DVec3};
use nextview::geometry::{Aabb, Lattice};
use nextview::geometry::{Pose, VoxelBlock};
use nextview::map::{Integration, OccupancyMap, RayRule, SensorModel, Snapshot};
use nextview::sensor::{Depth, Frame, Intrinsics};
use nextview::surface::CloudPoint;
use nextview::view::{ViewSpace, generate};
use nextview_model::write_mesh;
use nextview_recording::encode_depth;
use nextview_sim::camera::{Background, SimulatedCamera};
use nextview_sim::mesh::{self, TriangleMesh, Unit};
use std::error::Error;
use std::path::Path;
use std::sync::Arc;

/// Edge of the cube that confines the map and the planning rays, metres: the object's 0.2 m and some margin.
pub const BOX_EDGE: f64 = 0.25;

/// Distance of all cameras from the object's centre, metres.
const CAMERA_DISTANCE: f64 = 0.5;

/// Half the edge of the room around object and cameras in set B, metres.
const ROOM_HALF_EDGE: f64 = 0.6;

/// Length of a unit of depth in PNG files, metres.
pub const DEPTH_UNIT: f64 = 1e-4;

/// Number of depth images.
pub const N_IMAGES: usize = 10;

/// Number of view candidates.
pub const N_VIEWS: usize = 5000;

/// A set of clouds: the object alone (A), or the object in a room (B).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Set {
    /// The object alone: a tenth of the pixels.
    A,
    /// The object in a room: every pixel.
    B,
}

/// An object of 0.2 m at the origin, ten depth cameras around it, their clouds, and 5000 view candidates.
#[derive(Clone, Debug)]
pub struct Workload {
    /// The object, and the same surface with 4 and 16 times as many triangles.
    pub meshes: [Arc<TriangleMesh>; 3],
    /// Poses of the ten depth images (`world_from_camera`).
    pub poses: Vec<Pose>,
    /// The view candidates.
    pub views: ViewSpace,
    /// Points of set A and set B, one cloud per image, metres.
    clouds: [Vec<Vec<DVec3>>; 2],
}

impl Workload {
    /// Creates the workload from a mesh file, or from a built-in object if there is no file with that name.
    ///
    /// # Errors
    /// If the file cannot be read or holds no mesh.
    pub fn around(object: &str) -> Result<Self, Box<dyn Error>> {
        let mesh = match nextview_sim::builtin::by_name(object) {
            Some(mesh) => mesh.scaled(0.2 / mesh.bounds().longest_side())?,
            None => mesh::load(Path::new(object))?.to_metres(Unit::LongestSide(0.2))?.0,
        };
        let mesh = mesh.translated(-mesh.bounds().center())?;
        let finer = subdivided(&mesh)?;
        let meshes = [Arc::new(mesh), Arc::new(finer.clone()), Arc::new(subdivided(&finer)?)];
        let views_on_sphere = |n| generate::fibonacci_sphere(DVec3::ZERO, CAMERA_DISTANCE, n);
        let poses = views_on_sphere(N_IMAGES)?.poses().to_vec();
        let room = Background::Room(Aabb::cube(DVec3::ZERO, ROOM_HALF_EDGE));
        let clouds_before = |background| -> Result<Vec<Vec<DVec3>>, Box<dyn Error>> {
            let camera = SimulatedCamera::new(meshes[0].clone(), intrinsics(), background, 10.0)?;
            poses.iter().map(|pose| Ok(cloud(&camera.capture(pose)?))).collect()
        };
        let clouds = [clouds_before(Background::None)?, clouds_before(room)?];
        Ok(Self { meshes, poses, views: views_on_sphere(N_VIEWS)?, clouds })
    }

    /// Keeps a hundredth of the points and the views, to check that everything runs.
    ///
    /// # Errors
    /// If there are no views.
    pub fn thinned(self) -> Result<Self, Box<dyn Error>> {
        let views = self.views.poses().iter().step_by(100).copied().collect();
        let thin = |cloud: Vec<DVec3>| cloud.into_iter().step_by(100).collect();
        let clouds = self.clouds.map(|set| set.into_iter().map(thin).collect());
        Ok(Self { views: ViewSpace::new(views)?, clouds, ..self })
    }

    /// Reads a workload from a folder of [plain files](plain_files).
    ///
    /// # Errors
    /// If a file is missing or is invalid.
    pub fn read(folder: &Path) -> Result<Self, Box<dyn Error>> {
        let mesh = |i| plain_files::read_mesh(&folder.join(format!("mesh{i}.bin"))).map(Arc::new);
        let set = |name| -> Result<Vec<Vec<DVec3>>, Box<dyn Error>> {
            let path = |i| folder.join(format!("cloud{name}_{i}.f32"));
            (0..N_IMAGES).map(|i| plain_files::read_cloud(&path(i))).collect()
        };
        Ok(Self {
            meshes: [mesh(0)?, mesh(1)?, mesh(2)?],
            poses: plain_files::read_poses(&folder.join("poses.f64"))?,
            views: ViewSpace::new(plain_files::read_poses(&folder.join("views5000.f64"))?)?,
            clouds: [set('A')?, set('B')?],
        })
    }

    /// Writes the workload to an existing folder, for [`read`](Self::read) and for the peers.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Box<dyn Error>> {
        for (i, mesh) in self.meshes.iter().enumerate() {
            plain_files::write_mesh(&folder.join(format!("mesh{i}.bin")), mesh)?;
        }
        plain_files::write_poses(&folder.join("poses.f64"), &self.poses)?;
        plain_files::write_poses(&folder.join("views5000.f64"), self.views.poses())?;
        for (name, clouds) in ['A', 'B'].into_iter().zip(&self.clouds) {
            for (i, cloud) in clouds.iter().enumerate() {
                plain_files::write_cloud(&folder.join(format!("cloud{name}_{i}.f32")), cloud)?;
            }
        }
        let frames = self.frames();
        for (i, frame) in frames.iter().enumerate() {
            plain_files::write_depth(&folder.join(format!("depth_{i}.f32")), frame.image())?;
        }
        plain_files::write(&folder.join("depth.png"), &encode_depth(frames[0].image(), DEPTH_UNIT))?;
        plain_files::write(&folder.join("mesh2.ply"), &self.finest_ply()?)?;
        for (name, points) in ["known", "points"].into_iter().zip(self.alignment().points()) {
            plain_files::write_surface(&folder.join(format!("{name}.f32")), &points)?;
        }
        plain_files::write_poses(&folder.join("motion.f64"), &[OffsetPoints::motion()])
    }

    /// Returns the ten images of the object alone.
    pub fn frames(&self) -> Vec<Frame> {
        let camera = SimulatedCamera::new(self.meshes[0].clone(), intrinsics(), Background::None, 10.0);
        let camera = camera.expect("a sound camera");
        self.poses.iter().map(|pose| camera.capture(pose).expect("a camera outside of the object")).collect()
    }

    /// Returns the last image with the surface that the others show.
    pub fn alignment(&self) -> OffsetPoints {
        OffsetPoints::of(&self.frames(), bounds())
    }

    /// Returns the finest mesh as the bytes of a PLY file.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub fn finest_ply(&self) -> Result<Vec<u8>, Box<dyn Error>> {
        let mut bytes = Vec::new();
        write_mesh(&mut bytes, &self.finest_vertices(), None, self.meshes[2].triangles())?;
        Ok(bytes)
    }

    /// Returns the vertices of the finest mesh, in the form that PLY files are written from.
    pub fn finest_vertices(&self) -> Vec<CloudPoint> {
        self.meshes[2].vertices().iter().map(|&vertex| vertex.into()).collect()
    }

    /// Returns the ten clouds of a set.
    pub fn clouds(&self, set: Set) -> &[Vec<DVec3>] {
        &self.clouds[set as usize]
    }

    /// Returns the map after the first `n_images` clouds of a set, with a ray for every point, confined to
    /// the box.
    pub fn map(&self, set: Set, voxel_size: f64, n_images: usize) -> OccupancyMap {
        let mut map = empty_map(voxel_size);
        let integration =
            Integration { rays: RayRule::EveryPoint, region: Some(block(voxel_size)), ..Default::default() };
        for (cloud, pose) in self.clouds(set).iter().zip(&self.poses).take(n_images) {
            let update = map.integrate_points(cloud, pose.translation(), &integration);
            update.expect("a cloud near the origin");
        }
        map
    }

    /// Returns the snapshot of [`map`](Self::map) for planning.
    pub fn snapshot(&self, set: Set, voxel_size: f64, n_images: usize) -> Snapshot {
        self.map(set, voxel_size, n_images).snapshot(block(voxel_size))
    }
}

/// Returns the camera of the workload: 640 x 480 pixels, 610 pixels of focal length, no distortion.
pub fn intrinsics() -> Intrinsics {
    Intrinsics::pinhole(640, 480, DVec2::splat(610.0), DVec2::new(320.0, 240.0))
        .expect("a camera of sound numbers")
}

/// Returns the distance between rays at the far side of the box, in voxels, that makes them 20 pixels apart:
/// 32 x 24 over the whole image.
pub fn ray_spacing_of_image_grid(voxel_size: f64) -> f64 {
    let farthest = CAMERA_DISTANCE + 0.5 * BOX_EDGE * 3.0_f64.sqrt();
    20.0 / intrinsics().focal().x * farthest / voxel_size
}

/// Returns an empty map with OctoMap's sensor model.
pub fn empty_map(voxel_size: f64) -> OccupancyMap {
    OccupancyMap::new(lattice(voxel_size), SensorModel::default()).expect("the default model is sound")
}

/// Returns the box around the object.
pub fn bounds() -> Aabb {
    Aabb::cube(DVec3::ZERO, 0.5 * BOX_EDGE)
}

/// Returns the voxels of the box around the object.
pub fn block(voxel_size: f64) -> VoxelBlock {
    lattice(voxel_size).block_inside(&bounds()).expect("the box holds voxels of every size measured")
}

fn lattice(voxel_size: f64) -> Lattice {
    Lattice::new(voxel_size).expect("voxel sizes are written in the source")
}

/// The measured points of a frame, rounded to f32 as the peers read them.
fn cloud(frame: &Frame) -> Vec<DVec3> {
    let (image, pose, optics) = (frame.image(), frame.world_from_camera(), frame.intrinsics());
    let pixels = (0..image.height()).flat_map(|v| (0..image.width()).map(move |u| (u, v)));
    let point = |(u, v): (u32, u32)| {
        let Depth::Surface(depth) = image.get(u, v) else { return None };
        let ideal = optics.deproject(DVec2::new(u as f64, v as f64))?;
        Some(pose.transform_point((ideal * depth as f64).extend(depth as f64)).as_vec3().as_dvec3())
    };
    pixels.filter_map(point).collect()
}

/// The same surface with every triangle cut into four at the middles of its edges.
fn subdivided(mesh: &TriangleMesh) -> Result<TriangleMesh, Box<dyn Error>> {
    let mut vertices = mesh.vertices().to_vec();
    let mut middles = std::collections::BTreeMap::new();
    let mut triangles = Vec::with_capacity(4 * mesh.triangles().len());
    for &[a, b, c] in mesh.triangles() {
        let mut middle = |i: u32, j: u32| {
            *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                vertices.push(0.5 * (mesh.vertices()[i as usize] + mesh.vertices()[j as usize]));
                vertices.len() as u32 - 1
            })
        };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    Ok(TriangleMesh::new(vertices, triangles)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_back_the_same() {
        let folder = std::env::temp_dir().join(format!("nextview-workload-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let made = Workload::around("teapot").unwrap();
        made.write(&folder).unwrap();
        let read = Workload::read(&folder).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(made.clouds, read.clouds);
        assert_eq!(made.meshes[2].triangles(), read.meshes[2].triangles());
        assert_eq!(made.views.len(), read.views.len());
        let is_near = |(a, b): (&Pose, &Pose)| a.translation().distance(b.translation()) < 1e-15;
        assert!(made.poses.iter().zip(&read.poses).all(is_near));
    }

    #[test]
    fn a_cloud_lies_on_the_object_or_the_walls() {
        let workload = Workload::around("teapot").unwrap();
        assert!(workload.clouds(Set::A).iter().flatten().all(|p| p.abs().max_element() < 0.11));
        let all_pixels = workload.clouds(Set::B).iter().all(|cloud| cloud.len() == 640 * 480);
        assert!(all_pixels && workload.clouds(Set::A)[0].len() < 100_000);
        let [coarse, fine, finest] = &workload.meshes;
        assert_eq!(16 * coarse.triangles().len(), finest.triangles().len());
        assert!((fine.area() - coarse.area()).abs() < 1e-9);
    }
}
