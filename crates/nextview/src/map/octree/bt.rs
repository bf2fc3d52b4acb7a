use super::header::{Encoding, write_header};
use super::node_reader::NodeReader;
use super::preorder::DEPTH;
use super::tree::{Node, Octree};
use crate::Error;
use crate::map::{LogOdds, SensorModel};
use std::io::{BufWriter, Read, Write};

/// The meaning of the two bits of a child, child 0 in the lowest bits of an inner node's little-endian word.
/// OctoMap's comments print the bits in the order of their weight, 10 for free.
const UNKNOWN: u16 = 0;
const FREE: u16 = 1;
const OCCUPIED: u16 = 2;
const INNER: u16 = 3;

impl Octree {
    /// Writes a `.bt` file, which holds the maximum likelihood map: leaves with P >= 0.5 become occupied, the
    /// rest free, then equal ones are merged as by [`pruned`](Self::pruned). Probabilities and colours are
    /// lost; a tree that is a single leaf loses its occupancy, too.
    pub fn write_bt(&self, writer: impl Write) -> Result<(), Error> {
        let clamps = Clamps::default();
        let tree = self.clone().map_log_odds(|l| clamps.maximum_likelihood(l)).pruned();
        let mut out = BufWriter::new(writer);
        write_header(&mut out, Encoding::Bt, &tree)?;
        for word in words(&tree) {
            out.write_all(&word.to_le_bytes())?;
        }
        Ok(out.flush()?)
    }
}

/// The log-odds of free and of occupied leaves: OctoMap's default clamping values.
struct Clamps {
    free: f32,
    occupied: f32,
}

impl Default for Clamps {
    fn default() -> Self {
        let SensorModel { clamp_min, clamp_max, .. } = SensorModel::default();
        Self {
            free: LogOdds::from_probability(clamp_min).0,
            occupied: LogOdds::from_probability(clamp_max).0,
        }
    }
}

impl Clamps {
    fn maximum_likelihood(&self, log_odds: f32) -> f32 {
        if log_odds >= 0.0 { self.occupied } else { self.free }
    }
}

pub(super) fn read_nodes(nodes: &mut NodeReader<impl Read>) -> Result<(), Error> {
    read_inner(nodes, 0, &Clamps::default()).map(|_| ())
}

/// Reads an inner node at `depth` and all below it; returns its log-odds.
fn read_inner(nodes: &mut NodeReader<impl Read>, depth: u8, clamps: &Clamps) -> Result<f32, Error> {
    let mut bytes = [0; 2];
    nodes.fill(&mut bytes)?;
    let word = u16::from_le_bytes(bytes);
    if word == 0 && depth > 0 {
        return Err(
            nodes.error(format!("an inner node at depth {depth} has no children, expected at least one"))
        );
    }
    // Only the root keeps this value: OctoMap never takes it from its children.
    let start = if depth == 0 { clamps.occupied } else { f32::MIN };
    let idx = nodes.push(Node::leaf(start))?;
    for octant in 0..8 {
        let log_odds = match word >> (2 * octant) & 3 {
            UNKNOWN => continue,
            FREE => read_leaf(nodes, clamps.free)?,
            OCCUPIED => read_leaf(nodes, clamps.occupied)?,
            _ if depth + 1 == DEPTH => {
                return Err(
                    nodes.error(format!("a node at depth {DEPTH} has children, expected none below a voxel"))
                );
            }
            _ => read_inner(nodes, depth + 1, clamps)?,
        };
        nodes.tree().add_child(idx, octant);
        nodes.tree().raise(idx, log_odds);
    }
    Ok(nodes.tree().node(idx).log_odds)
}

fn read_leaf(nodes: &mut NodeReader<impl Read>, log_odds: f32) -> Result<f32, Error> {
    nodes.push(Node::leaf(log_odds))?;
    Ok(log_odds)
}

/// The words of the inner nodes in preorder. The root has one even if it is a leaf.
fn words(tree: &Octree) -> Vec<u16> {
    let mut words = Vec::new();
    // Codes of finished subtrees. Backwards, the children of a node come just before it, the first one last.
    let mut pending = Vec::new();
    for idx in (0..tree.n_nodes()).rev() {
        let node = tree.node(idx);
        let mut word = 0;
        for octant in (0..8).filter(|i| node.child_mask >> i & 1 == 1) {
            word |= pending.pop().expect("a tree holds all children") << (2 * octant);
        }
        if word != 0 || idx == 0 {
            words.push(word);
        }
        pending.push(match node.child_mask {
            0 if node.log_odds >= 0.0 => OCCUPIED,
            0 => FREE,
            _ => INNER,
        });
    }
    words.reverse();
    words
}
