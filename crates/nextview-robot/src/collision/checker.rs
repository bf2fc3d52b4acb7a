use super::obstacle::{Barrier, solid_distance};
use super::solid::{self, Placement, Solid};
use super::sweep::sweeps;
use super::{CellError, Contact, Obstacle, ObstacleKind};
use crate::{Arm, Joint, JointKind, JointLimits, Shape};
use std::ops::Range;

/// Something mounted on an arm's flange, such as the body of a camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Attachment {
    /// Name for messages.
    pub name: String,
    /// Its shapes; `link_from_shape` of each is `flange_from_shape`.
    pub shapes: Vec<Shape>,
}

/// Checks an arm and its payload for collisions.
///
/// Everything keeps the clearance from obstacles, and [`SELF_CLEARANCE`](Self::SELF_CLEARANCE) from other
/// parts of the arm. The fixed base of the arm may touch obstacles. Pairs of links in
/// [`may_touch`](Arm::may_touch) may touch, and so may an attachment and the last link.
#[derive(Clone, Debug)]
pub struct Checker {
    arm: Arm,
    parts: Vec<Part>,
    /// All solids, in the frames of their links.
    solids: Vec<(Solid, Placement)>,
    /// Parts that must not touch each other, the one closer to the base first.
    pairs: Vec<[usize; 2]>,
    barriers: Vec<(String, Barrier)>,
    clearance: f64,
}

/// A link or an attachment.
#[derive(Clone, Debug)]
struct Part {
    name: String,
    link: usize,
    solids: Range<usize>,
    /// Maximum motion of its points by each joint, in metres per unit of the joint.
    sweeps: Vec<f64>,
}

/// Maximum motion of parts along a straight line between joint values, in metres.
#[derive(Clone, Debug)]
pub(crate) struct PartMotion {
    of_parts: Vec<f64>,
    /// Motion of the second part of a pair relative to the first.
    of_pairs: Vec<f64>,
}

impl Checker {
    /// Minimum distance between parts of the arm in metres. It is small because the shapes of links are
    /// simplified, and joints often have less play than the clearance from obstacles.
    pub const SELF_CLEARANCE: f64 = 1e-3;

    /// Maximum amount in metres by which distances along a motion may be below the clearance. Without it, a
    /// motion that just keeps the clearance could not be checked in finite time.
    pub const SLACK: f64 = 5e-4;

    /// Creates a checker for an arm with the load `attached` among `obstacles`, at a minimum distance of
    /// `clearance_m`, 0.001..=1; 0.02 suits most arms. Fails if a shape has no size, a joint has no limits,
    /// or the clearance is out of range.
    pub fn new(
        arm: Arm,
        attached: Vec<Attachment>,
        obstacles: Vec<Obstacle>,
        clearance_m: f64,
    ) -> Result<Self, CellError> {
        check(&arm, &attached, &obstacles, clearance_m)?;
        let last = arm.n_joints();
        let links = arm.links.iter().enumerate().map(|(i, link)| {
            let shapes = link.shapes.iter().map(|shape| (shape.link_from_shape, &shape.kind));
            (link.name.clone(), i, shapes.collect::<Vec<_>>())
        });
        let carried = attached.iter().map(|attachment| {
            let shapes = attachment.shapes.iter();
            let shapes = shapes.map(|shape| (arm.last_link_from_flange * shape.link_from_shape, &shape.kind));
            (attachment.name.clone(), last, shapes.collect())
        });
        let (mut parts, mut solids) = (Vec::new(), Vec::new());
        for (name, link, shapes) in links.chain(carried) {
            let first = solids.len();
            solids.extend(shapes.into_iter().map(|(link_from_shape, kind)| {
                let (solid, middle) = Solid::new(kind);
                (solid, Placement::from(link_from_shape).moved(middle))
            }));
            let sweeps = sweeps(&arm, link, &solids[first..]);
            parts.push(Part { name, link, solids: first..solids.len(), sweeps });
        }
        let pairs = pairs(&arm, &parts);
        let barriers = obstacles.into_iter().map(|obstacle| (obstacle.name, obstacle.kind.into())).collect();
        Ok(Self { arm, parts, solids, pairs, barriers, clearance: clearance_m })
    }

    /// The checked arm.
    pub fn arm(&self) -> &Arm {
        &self.arm
    }

    /// Returns the first pair found that is closer than allowed; `None` if there is none.
    ///
    /// # Panics
    ///
    /// If the number of values is not that of joints, or one is not finite.
    pub fn contact(&self, values: &[f64]) -> Option<Contact> {
        self.clear_share(values, &self.motion(values, values), 1.0).err()
    }

    /// Returns a lower bound on the minimum distance in metres between any two things that must not touch,
    /// within 1e-4 of it; 0 if some touch, infinite if there are no such pairs.
    ///
    /// # Panics
    ///
    /// If the number of values is not that of joints, or one is not finite.
    pub fn distance(&self, values: &[f64]) -> f64 {
        let placed = self.place(values);
        let pairs = self.pairs.iter();
        let least = pairs.fold(f64::INFINITY, |least, pair| least.min(self.apart(&placed, *pair, least)));
        let parts = self.moving_parts().flat_map(|part| self.barriers.iter().map(move |b| (part, &b.1)));
        parts.fold(least, |least, (part, barrier)| least.min(self.aside(&placed, part, barrier, least, 0.0)))
    }

    /// Maximum motion of each part on the straight line between joint values.
    pub(crate) fn motion(&self, from: &[f64], to: &[f64]) -> PartMotion {
        let moved = |part: &Part, first: usize| -> f64 {
            let joints = first..part.link;
            joints.map(|i| (to[i] - from[i]).abs() * part.sweeps[i]).sum()
        };
        let of_pair = |[a, b]: &[usize; 2]| moved(&self.parts[*b], self.parts[*a].link);
        PartMotion {
            of_parts: self.parts.iter().map(|part| moved(part, 0)).collect(),
            of_pairs: self.pairs.iter().map(of_pair).collect(),
        }
    }

    /// The guaranteed free share of a motion forwards and backwards from these values, at most `most`; or the
    /// contact there.
    pub(crate) fn clear_share(&self, values: &[f64], motion: &PartMotion, most: f64) -> Result<f64, Contact> {
        let placed = self.place(values);
        let mut share = most;
        for part in self.moving_parts().rev() {
            let moved = motion.of_parts[part];
            for (name, barrier) in &self.barriers {
                let limit = self.clearance + share * moved;
                let distance = self.aside(&placed, part, barrier, limit, self.clearance);
                let free = free_share(distance, self.clearance, moved);
                share = share.min(free.ok_or_else(|| Contact::new(&self.parts[part].name, name))?);
            }
        }
        for (pair, &moved) in self.pairs.iter().zip(&motion.of_pairs) {
            let distance = self.apart(&placed, *pair, Self::SELF_CLEARANCE + share * moved);
            let contact = || Contact::new(&self.parts[pair[0]].name, &self.parts[pair[1]].name);
            share = share.min(free_share(distance, Self::SELF_CLEARANCE, moved).ok_or_else(contact)?);
        }
        Ok(share)
    }

    /// The pairs of links, lower number first, that touch at these joint values and must not.
    pub(super) fn touching(&self, values: &[f64]) -> impl Iterator<Item = [usize; 2]> {
        let placed = self.place(values);
        let touch = move |pair: &[usize; 2]| self.apart(&placed, *pair, Self::SELF_CLEARANCE);
        self.pairs.iter().copied().filter(move |pair| touch(pair) < Self::SELF_CLEARANCE)
    }

    fn moving_parts(&self) -> impl DoubleEndedIterator<Item = usize> {
        (0..self.parts.len()).filter(|part| self.parts[*part].link > 0)
    }

    /// All solids in the frame of the base.
    fn place(&self, values: &[f64]) -> Vec<Placement> {
        let poses = self.arm.link_poses(values);
        let mut placed = Vec::with_capacity(self.solids.len());
        for part in &self.parts {
            let base_from_link = Placement::from(poses[part.link]);
            let solids = self.solids[part.solids.clone()].iter();
            placed.extend(solids.map(|(_, link_from_solid)| base_from_link.times(link_from_solid)));
        }
        placed
    }

    /// A lower bound on the distance of a part from an obstacle: within 1e-4, at least `limit`, or below
    /// `enough`.
    fn aside(&self, placed: &[Placement], part: usize, barrier: &Barrier, limit: f64, enough: f64) -> f64 {
        let nearer =
            |least: f64, i: usize| least.min(barrier.distance(&self.solids[i].0, &placed[i], least, enough));
        self.parts[part].solids.clone().fold(limit, nearer)
    }

    /// A lower bound on the distance of two parts: within 1e-4, or at least `limit`.
    fn apart(&self, placed: &[Placement], [a, b]: [usize; 2], limit: f64) -> f64 {
        let mut least = limit;
        for i in self.parts[a].solids.clone() {
            for j in self.parts[b].solids.clone() {
                let i_from_j = placed[i].inverse_times(&placed[j]);
                least = least.min(solid_distance(&self.solids[i].0, &self.solids[j].0, &i_from_j, least));
            }
        }
        least
    }
}

/// The share of a motion of at most `moved` metres during which the distance stays above the clearance less
/// the slack; `None` if the distance is below the clearance.
fn free_share(distance: f64, clearance: f64, moved: f64) -> Option<f64> {
    (distance >= clearance).then(|| (distance - clearance + Checker::SLACK) / moved)
}

/// Parts of the arm with relative motion that must not touch.
fn pairs(arm: &Arm, parts: &[Part]) -> Vec<[usize; 2]> {
    let n_links = arm.links.len();
    let may_touch = |a: usize, b: usize| b < n_links && arm.may_touch.contains(&[a, b]);
    let mut pairs = Vec::new();
    for b in 0..parts.len() {
        let nearer_base = (0..b).filter(|a| parts[*a].link < parts[b].link && !may_touch(*a, b));
        pairs.extend(nearer_base.map(|a| [a, b]));
    }
    pairs
}

fn check(
    arm: &Arm,
    attached: &[Attachment],
    obstacles: &[Obstacle],
    clearance: f64,
) -> Result<(), CellError> {
    let mut faults = Vec::new();
    if !(1e-3..=1.0).contains(&clearance) {
        faults.push(format!("clearance_m is {clearance}, expected 0.001 to 1"));
    }
    if arm.links.len() != arm.n_joints() + 1 {
        let (n_links, n_joints) = (arm.links.len(), arm.n_joints());
        faults.push(format!("the arm has {n_links} links, expected one more than its {n_joints} joints"));
    }
    faults.extend(arm.joints.iter().filter_map(joint_fault));
    let links = arm.links.iter().map(|link| (&link.name, &link.shapes));
    let carried = attached.iter().map(|attachment| (&attachment.name, &attachment.shapes));
    for (name, shapes) in links.chain(carried) {
        faults.extend(shapes.iter().filter_map(|s| solid::fault(&s.kind)).map(|f| format!("{name}: {f}")));
    }
    for obstacle in obstacles {
        if let ObstacleKind::Solid { kind, .. } = &obstacle.kind {
            faults.extend(solid::fault(kind).map(|fault| format!("{}: {fault}", obstacle.name)));
        }
    }
    CellError::unless_empty(faults)
}

/// The reason why motions of a joint cannot be bounded or timed, if any.
fn joint_fault(joint: &Joint) -> Option<String> {
    let JointLimits { lower, upper, velocity, acceleration } = joint.limits;
    let is_limit = |limit: f64| limit > 0.0 && limit.is_finite();
    if !is_limit(velocity) || !is_limit(acceleration) {
        let found = format!("velocity {velocity} and acceleration {acceleration}");
        return Some(format!("{}: {found}, expected positive numbers", joint.name));
    }
    // A joint may turn without limits, but not slide without limits.
    let is_bounded = joint.kind == JointKind::Revolute || lower.is_finite() && upper.is_finite();
    let is_range = lower <= upper && is_bounded;
    (!is_range).then(|| format!("{}: range {lower} to {upper}, expected a bounded range", joint.name))
}
