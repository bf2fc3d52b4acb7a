use glam::DVec3;

/// Options for everything that a URDF does not state.
#[derive(Clone, Copy)]
pub struct UrdfOptions<'a> {
    /// The link where the arm begins. Default: the root of the tree.
    pub base_link: Option<&'a str>,
    /// The link whose frame is the flange. Default: the only link that moves and carries no other.
    pub tip_link: Option<&'a str>,
    /// Loads the points of a mesh, in the file's own unit, by its name in the URDF (`package://…/link.stl`),
    /// or returns why it cannot. The shape is the convex hull of the points, scaled as stated in the URDF.
    /// Without points, the mesh takes up no space. By default, every mesh is refused.
    pub load_mesh: &'a dyn Fn(&str) -> Result<Vec<DVec3>, String>,
    /// Time in seconds for a joint to reach full speed from rest, positive; replaces the acceleration limits,
    /// which a URDF does not state. Default 0.5: Franka publishes both limits for its Panda, whose slowest
    /// joint takes 0.29 s, and a camera should not be shaken.
    pub seconds_to_full_speed: f64,
}

impl Default for UrdfOptions<'_> {
    fn default() -> Self {
        Self { base_link: None, tip_link: None, load_mesh: &refuse_mesh, seconds_to_full_speed: 0.5 }
    }
}

fn refuse_mesh(_: &str) -> Result<Vec<DVec3>, String> {
    Err("meshes can be read only if `load_mesh` is given".into())
}
