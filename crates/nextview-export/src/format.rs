use nextview_scan::Named;
use std::fmt;

/// An export format for other tools.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A data set of the BOP benchmark with one object and one scene.
    Bop,
    /// A sparse model of COLMAP, as text and binary, with its images.
    Colmap,
    /// Reference views and a model for FoundationPose.
    FoundationPose,
    /// `transforms.json` with its images.
    Nerfstudio,
    /// The mesh with a texture, as Wavefront OBJ.
    Obj,
    /// Images with an Open3D camera trajectory.
    Open3d,
    /// The cloud as a Point Cloud Library file.
    Pcd,
    /// A sequence in the format of the TUM RGB-D benchmark.
    Tum,
}

impl Named for Format {
    const ALL: &'static [Self] = &[
        Self::Bop,
        Self::Colmap,
        Self::FoundationPose,
        Self::Nerfstudio,
        Self::Obj,
        Self::Open3d,
        Self::Pcd,
        Self::Tum,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Bop => "bop",
            Self::Colmap => "colmap",
            Self::FoundationPose => "foundationpose",
            Self::Nerfstudio => "nerfstudio",
            Self::Obj => "obj",
            Self::Open3d => "open3d",
            Self::Pcd => "pcd",
            Self::Tum => "tum",
        }
    }

    fn about(self) -> &'static str {
        match self {
            Self::Bop => "data set of the BOP benchmark: model, images, masks, true poses",
            Self::Colmap => "sparse model of COLMAP, text and binary, with images; for Gaussian splatting",
            Self::FoundationPose => "reference views with masks, and a textured model, for FoundationPose",
            Self::Nerfstudio => "transforms.json with images, for nerfstudio and instant-ngp",
            Self::Obj => "the mesh with a texture from the colour images: .obj, .mtl and .png",
            Self::Open3d => "colour and depth images with a camera trajectory (.json, .log)",
            Self::Pcd => "the cloud for the Point Cloud Library",
            Self::Tum => {
                "sequence in the format of the TUM RGB-D benchmark, which `scan --frames` also reads"
            }
        }
    }
}

impl Format {
    /// The format's files and folders.
    pub(crate) fn entries(self) -> &'static [&'static str] {
        match self {
            Self::Bop => &["camera.json", "models", "train"],
            Self::Colmap => &["images", "masks", "sparse"],
            Self::FoundationPose => &[
                "K.txt",
                "cam_K.txt",
                "select_frames.yml",
                "rgb",
                "depth",
                "depth_enhanced",
                "mask",
                "masks",
                "cam_in_ob",
                "model",
            ],
            Self::Nerfstudio => &["transforms.json", "sparse_pc.ply", "images", "depths", "masks"],
            Self::Obj => &["mesh.obj", "mesh.mtl", "mesh.png"],
            Self::Open3d => &["intrinsic.json", "camera_trajectory.json", "trajectory.log", "color", "depth"],
            Self::Pcd => &["cloud.pcd"],
            Self::Tum => &["intrinsics.txt", "groundtruth.txt", "depth.txt", "rgb.txt", "depth", "rgb"],
        }
    }

    /// Whether the format is useless without colour images.
    pub(crate) fn needs_color(self) -> bool {
        matches!(self, Self::Colmap | Self::FoundationPose | Self::Nerfstudio | Self::Obj)
    }

    /// Whether the format holds pictures.
    pub(crate) fn has_views(self) -> bool {
        !matches!(self, Self::Obj | Self::Pcd)
    }

    /// Whether the format holds the mesh, or masks made from the mesh.
    pub(crate) fn needs_mesh(self) -> bool {
        matches!(self, Self::Bop | Self::Colmap | Self::FoundationPose | Self::Nerfstudio | Self::Obj)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
