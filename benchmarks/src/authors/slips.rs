/// Deviations of the authors' program from the paper, one switch each. Numbers are those of the list in
/// `docs/reproduction.md`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slips {
    /// 1. The history weights views by their number: exp(-(view - k)) instead of eq. (4)'s exp(-(it - k)).
    pub history_by_view_number: bool,
    /// 2. Rays end at voxels with log-odds 0, which all unmeasured ones have, instead of at occupied ones.
    pub rays_stop_at_unknown: bool,
    /// 3. Rays are cast only at the first plan, with their roll at that time, and are never extended.
    pub rays_cast_once: bool,
    /// 4. Rays are also cast outside the image.
    pub rays_outside_image: bool,
    /// 5. The box's outline comes from the lens polynomial of deprojection, which is not the projection.
    pub outline_by_deprojection: bool,
    /// 6. Unknown means 0.45 < P < 0.65 instead of never measured.
    pub unknown_by_bands: bool,
    /// 7. Sight through a voxel is 1 below P = 0.45, 0 above 0.65 and linear between; eq. (2) has 1 - P.
    pub linear_sight: bool,
    /// 8. Only qualities above 0.3 enter the flow.
    pub flow_above_threshold: bool,
    /// 9. Visited views stay in the network.
    pub visited_in_flow: bool,
    /// 10. Only hits change the map: a ray past the object frees nothing. The paper does not say.
    pub hits_only: bool,
}

/// The name of a rung and its repair.
pub type Repair = (&'static str, fn(&mut Slips));

impl Slips {
    /// The authors' program: the profile `authors-code`.
    pub const AUTHORS_CODE: Self = Self {
        history_by_view_number: true,
        rays_stop_at_unknown: true,
        rays_cast_once: true,
        rays_outside_image: true,
        outline_by_deprojection: true,
        unknown_by_bands: true,
        linear_sight: true,
        flow_above_threshold: true,
        visited_in_flow: true,
        hits_only: true,
    };

    /// The paper's formulas, in maps of hits only.
    pub const PAPER: Self = Self {
        history_by_view_number: false,
        rays_stop_at_unknown: false,
        rays_cast_once: false,
        rays_outside_image: false,
        outline_by_deprojection: false,
        unknown_by_bands: false,
        linear_sight: false,
        flow_above_threshold: false,
        visited_in_flow: false,
        hits_only: true,
    };

    /// The repair of each slip with the name of its rung, in the order of the ladder.
    pub const REPAIRS: [Repair; 10] = [
        ("1: history by plan", |slips| slips.history_by_view_number = false),
        ("2: rays pass unknown voxels", |slips| slips.rays_stop_at_unknown = false),
        ("3: rays cast at every plan", |slips| slips.rays_cast_once = false),
        ("4: no rays outside the image", |slips| slips.rays_outside_image = false),
        ("5: outline by the projection", |slips| slips.outline_by_deprojection = false),
        ("6: unknown is never measured", |slips| slips.unknown_by_bands = false),
        ("7: sight by 1 - P", |slips| slips.linear_sight = false),
        ("8: all qualities in the flow", |slips| slips.flow_above_threshold = false),
        ("9: visited views leave the flow", |slips| slips.visited_in_flow = false),
        ("10: the background carves", |slips| slips.hits_only = false),
    ];
}
