use super::chain::Chain;
use super::model::{JointMotion, Model};
use crate::{Arm, Joint, Link, Shape};
use nextview::geometry::Pose;

/// The position of a link of the file: its link of the arm, and its frame there.
#[derive(Clone, Copy)]
struct LinkPosition {
    arm_link: usize,
    arm_from_link: Pose,
}

/// Builds the arm of a chain: each moving joint of the chain begins a link, and everything else belongs to
/// the link connected to it.
pub(super) fn fold(model: &Model, chain: &Chain) -> Arm {
    let link = |link: usize| Link { name: model.links[link].name.clone(), shapes: Vec::new() };
    let mut links = vec![link(chain.base)];
    let mut joints = Vec::new();
    let mut is_on_chain = vec![false; model.joints.len()];
    for &joint in &chain.joints {
        is_on_chain[joint] = true;
        if !matches!(model.joints[joint].motion, JointMotion::Fixed) {
            links.push(link(chain.child[joint]));
        }
    }
    let mut last_link_from_flange = Pose::IDENTITY;
    let mut open = vec![(chain.base, LinkPosition { arm_link: 0, arm_from_link: Pose::IDENTITY })];
    while let Some((link, place)) = open.pop() {
        if link == chain.tip {
            last_link_from_flange = place.arm_from_link;
        }
        let shapes = &model.links[link].shapes;
        links[place.arm_link].shapes.extend(shapes.iter().map(|shape| Shape {
            link_from_shape: place.arm_from_link * shape.link_from_shape,
            kind: shape.kind.clone(),
        }));
        // A stack reverses the order; shapes must be in file order.
        for &number in chain.joints_below[link].iter().rev() {
            let joint = &model.joints[number];
            let parent_from_joint = place.arm_from_link * joint.parent_from_joint;
            let below = match &joint.motion {
                JointMotion::Moves { kind, axis, limits } if is_on_chain[number] => {
                    let (name, kind, axis, limits) = (joint.name.clone(), *kind, *axis, *limits);
                    joints.push(Joint { name, kind, parent_from_joint, axis, limits });
                    LinkPosition { arm_link: place.arm_link + 1, arm_from_link: Pose::IDENTITY }
                }
                motion => {
                    let arm_from_link = parent_from_joint * motion.at_rest();
                    LinkPosition { arm_link: place.arm_link, arm_from_link }
                }
            };
            open.push((chain.child[number], below));
        }
    }
    let may_touch = (1..links.len()).map(|link| [link - 1, link]).collect();
    Arm { name: model.name.clone(), joints, links, last_link_from_flange, may_touch }
}
