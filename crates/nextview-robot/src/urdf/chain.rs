use super::error::{UrdfError, UrdfFault};
use super::model::{JointMotion, Model};
use std::collections::BTreeMap;

/// The tree of a URDF, and the path through it from base to tip.
pub(super) struct Chain {
    /// For each link, the joints that carry a link further out.
    pub joints_below: Vec<Vec<usize>>,
    /// The link below each joint.
    pub child: Vec<usize>,
    pub base: usize,
    pub tip: usize,
    /// The joints from base to tip, including fixed ones.
    pub joints: Vec<usize>,
}

/// The joint above each link and its parent; `None` for the root.
type Above = Vec<Option<(usize, usize)>>;

impl Chain {
    /// # Errors
    ///
    /// All faults that prevent a tree; otherwise those of base and tip; otherwise those of the joints between
    /// them.
    pub fn find(model: &Model, base: Option<&str>, tip: Option<&str>) -> Result<Self, UrdfError> {
        let links = names(model)?;
        let (above, child) = tree(model, &links)?;
        let mut joints_below = vec![Vec::new(); model.links.len()];
        for &(joint, parent) in child.iter().filter_map(|&link| above[link].as_ref()) {
            joints_below[parent].push(joint);
        }
        let root = root(model, &above, &joints_below, &child)?;
        let known = |name: Option<&str>, option: &str| match name.map(|name| (name, links.get(name))) {
            None => Ok(None),
            Some((_, Some(&link))) => Ok(Some(link)),
            Some((name, None)) => {
                let known: Vec<&str> = model.links.iter().map(|link| link.name.as_str()).take(40).collect();
                let problem = format!("{name:?} is not a link, expected one of {}", known.join(", "));
                Err(UrdfFault::new(None, option, problem))
            }
        };
        let base = known(base, "base_link")?.unwrap_or(root);
        let tip = match known(tip, "tip_link")? {
            Some(tip) => tip,
            None => only_tip(model, base, &above, &joints_below)?,
        };
        let joints = way(model, base, tip, &above)?;
        Ok(Self { joints_below, child, base, tip, joints })
    }
}

/// The number of each link by name.
fn names(model: &Model) -> Result<BTreeMap<&str, usize>, UrdfError> {
    let mut faults = Vec::new();
    let mut seen = BTreeMap::new();
    for joint in &model.joints {
        if let Some(line) = seen.insert(joint.name.as_str(), joint.line) {
            faults.push(twice("joint", &joint.name, joint.line, line));
        }
    }
    let mut links = BTreeMap::new();
    for (number, link) in model.links.iter().enumerate() {
        if let Some(earlier) = links.insert(link.name.as_str(), number) {
            faults.push(twice("link", &link.name, link.line, model.links[earlier].line));
        }
    }
    if links.is_empty() {
        faults.push(UrdfFault::new(None, "robot", "has no links, expected at least two"));
    }
    if faults.is_empty() { Ok(links) } else { Err(UrdfError { faults }) }
}

fn twice(what: &str, name: &str, line: u32, earlier: u32) -> UrdfFault {
    let problem =
        format!("the name is already taken by the {what} in line {earlier}, expected a unique name");
    UrdfFault::new(Some(line), format!("{what} {name:?}"), problem)
}

/// The joint above each link, and the link below each joint.
fn tree(model: &Model, links: &BTreeMap<&str, usize>) -> Result<(Above, Vec<usize>), UrdfError> {
    let mut faults = Vec::new();
    let mut above: Above = vec![None; model.links.len()];
    let mut child = Vec::new();
    for (number, joint) in model.joints.iter().enumerate() {
        let mut fault = |problem: String| {
            faults.push(UrdfFault::new(Some(joint.line), format!("joint {:?}", joint.name), problem));
        };
        let mut end = |side: &str, name: &str| {
            let link = links.get(name).copied();
            if link.is_none() {
                fault(format!("its {side} is {name:?}, expected the name of a link of this file"));
            }
            link
        };
        let ends = (end("parent", &joint.parent), end("child", &joint.child));
        let (Some(parent), Some(below)) = ends else { continue };
        child.push(below);
        match above[below] {
            None => above[below] = Some((number, parent)),
            Some((earlier, _)) => fault(format!(
                "link {:?} is already the child of joint {:?}, expected one joint above each link",
                joint.child, model.joints[earlier].name
            )),
        }
    }
    if faults.is_empty() { Ok((above, child)) } else { Err(UrdfError { faults }) }
}

/// The link above all others.
fn root(
    model: &Model,
    above: &Above,
    joints_below: &[Vec<usize>],
    child: &[usize],
) -> Result<usize, UrdfFault> {
    let name = |link: usize| format!("{:?}", model.links[link].name);
    let roots: Vec<usize> = (0..above.len()).filter(|link| above[*link].is_none()).collect();
    let mut is_reached = vec![false; above.len()];
    let mut open = roots.clone();
    while let Some(link) = open.pop() {
        is_reached[link] = true;
        open.extend(joints_below[link].iter().map(|&joint| child[joint]));
    }
    if let Some(link) = is_reached.iter().position(|is_reached| !is_reached) {
        let problem = format!("link {} is in a loop of joints, expected a tree", name(link));
        return Err(UrdfFault::new(Some(model.links[link].line), "robot", problem));
    }
    match roots[..] {
        [root] => Ok(root),
        _ => {
            let roots: Vec<String> = roots.into_iter().map(name).take(40).collect();
            let problem =
                format!("has several trees, with the roots {}, expected one tree", roots.join(", "));
            Err(UrdfFault::new(None, "robot", problem))
        }
    }
}

/// The joints from the base down to a link; `None` if it is not below the base.
fn joints_to(base: usize, link: usize, above: &Above) -> Option<Vec<usize>> {
    let mut joints = Vec::new();
    let mut at = link;
    while at != base {
        let (joint, parent) = above[at]?;
        joints.push(joint);
        at = parent;
    }
    joints.reverse();
    Some(joints)
}

/// The only link that moves relative to the base and has none below it.
fn only_tip(
    model: &Model,
    base: usize,
    above: &Above,
    joints_below: &[Vec<usize>],
) -> Result<usize, UrdfFault> {
    let moves = |joint: &usize| !matches!(model.joints[*joint].motion, JointMotion::Fixed);
    let is_tip = |link: &usize| {
        joints_below[*link].is_empty()
            && joints_to(base, *link, above).is_some_and(|joints| joints.iter().any(moves))
    };
    let tips: Vec<usize> = (0..above.len()).filter(is_tip).collect();
    match tips[..] {
        [tip] => Ok(tip),
        [] => Err(no_joints(&model.links[base].name, "any other link")),
        _ => {
            let name = |&link: &usize| format!("{:?}", model.links[link].name);
            let tips: Vec<String> = tips.iter().map(name).take(40).collect();
            let problem = format!("must be given, because the arm ends in {}", tips.join(", "));
            Err(UrdfFault::new(None, "tip_link", problem))
        }
    }
}

fn no_joints(base: &str, tip: &str) -> UrdfFault {
    let problem = format!("no joint moves between {base:?} and {tip:?}, expected at least one");
    UrdfFault::new(None, "robot", problem)
}

/// The joints from base to tip, all of them fixed or with one value.
fn way(model: &Model, base: usize, tip: usize, above: &Above) -> Result<Vec<usize>, UrdfError> {
    let name = |link: usize| &model.links[link].name;
    let Some(joints) = joints_to(base, tip, above) else {
        let problem = format!("{:?} is not below the base, {:?}", name(tip), name(base));
        return Err(UrdfFault::new(None, "tip_link", problem).into());
    };
    let mut faults = Vec::new();
    for joint in joints.iter().map(|&joint| &model.joints[joint]) {
        if let JointMotion::Unsupported(motion) = joint.motion {
            let expected = "expected revolute, continuous, prismatic or fixed between base and tip";
            let place = format!("joint {:?}", joint.name);
            faults.push(UrdfFault::new(Some(joint.line), place, format!("is {motion}, {expected}")));
        }
    }
    let is_still = |&joint: &usize| matches!(model.joints[joint].motion, JointMotion::Fixed);
    if joints.iter().all(is_still) {
        faults.push(no_joints(name(base), name(tip)));
    }
    if faults.is_empty() { Ok(joints) } else { Err(UrdfError { faults }) }
}
