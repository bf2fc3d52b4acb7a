use super::line::line_contact;
use super::timing::between;
use crate::Arm;
use crate::collision::Checker;
use nextview::geometry::random::Random;
use nextview::{Cancel, Cancelled};
use std::f64::consts::PI;

/// Maximum growth of a tree per step in any joint, radians or metres.
const STEP: f64 = 0.5;

/// Free joint values, and the free lines between them.
struct JointTree {
    /// Values, and the number of the preceding node; the root is its own.
    nodes: Vec<(Vec<f64>, usize)>,
}

/// Result of growing a tree towards joint values.
enum Grown {
    Blocked,
    /// Number of the new node.
    Nearer(usize),
    There(usize),
}

/// Finds a free path with two trees that grow towards each other (RRT-Connect, Kuffner and LaValle 2000), and
/// returns its corners; `None` after `n_samples`.
pub(super) fn connect(
    checker: &Checker,
    from: &[f64],
    to: &[f64],
    random: &mut Random,
    n_samples: usize,
    cancel: &Cancel,
) -> Result<Option<Vec<Vec<f64>>>, Cancelled> {
    let mut trees = [from, to].map(|root| JointTree { nodes: vec![(root.to_vec(), 0)] });
    for i in 0..n_samples {
        let sample = sample(checker.arm(), from, to, random);
        let [growing, other] = &mut trees;
        let (mine, theirs) = if i % 2 == 0 { (growing, other) } else { (other, growing) };
        let (Grown::Nearer(node) | Grown::There(node)) = mine.grow(checker, &sample, cancel)? else {
            continue;
        };
        let meeting = mine.nodes[node].0.clone();
        let met = loop {
            match theirs.grow(checker, &meeting, cancel)? {
                Grown::Nearer(_) => {}
                Grown::There(met) => break Some(met),
                Grown::Blocked => break None,
            }
        };
        if let Some(met) = met {
            let mut corners = mine.to_root(node);
            corners.reverse();
            corners.extend(theirs.to_root(met).into_iter().skip(1));
            if i % 2 == 1 {
                corners.reverse();
            }
            return Ok(Some(corners));
        }
    }
    Ok(None)
}

/// Samples values in a box of random size around both ends: most paths stay near their ends, and some lead
/// far away.
fn sample(arm: &Arm, from: &[f64], to: &[f64], random: &mut Random) -> Vec<f64> {
    let margin = PI * random.unit();
    let ends = from.iter().zip(to);
    let ranges = arm.joints.iter().zip(ends).map(|(joint, (from, to))| {
        let (low, high) = (from.min(*to) - margin, from.max(*to) + margin);
        (low.max(joint.limits.lower), high.min(joint.limits.upper))
    });
    ranges.map(|(low, high)| random.range(low, high)).collect()
}

impl JointTree {
    /// Adds a node towards these values, from the nearest one.
    fn grow(&mut self, checker: &Checker, to: &[f64], cancel: &Cancel) -> Result<Grown, Cancelled> {
        cancel.check()?;
        let nearest = self.nearest(checker.arm(), to);
        let from = &self.nodes[nearest].0;
        let farthest = from.iter().zip(to).map(|(a, b)| (b - a).abs()).fold(0.0, f64::max);
        if farthest == 0.0 {
            return Ok(Grown::There(nearest));
        }
        let is_there = farthest <= STEP;
        let new = if is_there { to.to_vec() } else { between(from, to, STEP / farthest) };
        if line_contact(checker, from, &new, cancel)?.is_some() {
            return Ok(Grown::Blocked);
        }
        self.nodes.push((new, nearest));
        let node = self.nodes.len() - 1;
        Ok(if is_there { Grown::There(node) } else { Grown::Nearer(node) })
    }

    /// The node from which the joints reach these values soonest in total.
    fn nearest(&self, arm: &Arm, to: &[f64]) -> usize {
        let away = |node: &[f64]| -> f64 {
            let each = arm.joints.iter().zip(node.iter().zip(to));
            each.map(|(joint, (a, b))| ((b - a) / joint.limits.velocity).powi(2)).sum()
        };
        let mut best = (0, f64::INFINITY);
        for (i, (values, _)) in self.nodes.iter().enumerate() {
            let away = away(values);
            if away < best.1 {
                best = (i, away);
            }
        }
        best.0
    }

    /// The values from a node to the root, inclusive.
    fn to_root(&self, mut node: usize) -> Vec<Vec<f64>> {
        let mut way = vec![self.nodes[node].0.clone()];
        while node != 0 {
            node = self.nodes[node].1;
            way.push(self.nodes[node].0.clone());
        }
        way
    }
}
