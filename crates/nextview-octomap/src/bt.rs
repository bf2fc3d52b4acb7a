use crate::header::{Encoding, write_header};
use crate::node_reader::NodeReader;
use crate::preorder::DEPTH;
use crate::tree::{Octree, StoredNode};
use nextview::Error;
use nextview::map::{LogOdds, SensorModel};
use std::io::{BufWriter, Read, Write};

/// The meaning of the two bits of a child, child 0 in the lowest bits of an inner node's little-endian word.
/// OctoMap's comments print the bits in the order of their weight, 10 for free.
const UNKNOWN: u16 = 0;
const FREE: u16 = 1;
const OCCUPIED: u16 = 2;
const INNER: u16 = 3;

/// Times the two bits of a child, this is the word of a node with eight such children.
const EIGHT: u16 = 0x5555;

impl Octree {
    /// Writes a `.bt` file, the maximum likelihood map: leaves with P >= 0.5 become occupied, the rest free,
    /// then equal ones are merged as by [`pruned`](Self::pruned). Probabilities and colours are lost; a tree
    /// of a single leaf also loses its occupancy.
    pub fn write_bt(&self, writer: impl Write) -> Result<(), Error> {
        let Words { words, n_nodes } = words(self);
        let mut out = BufWriter::new(writer);
        write_header(&mut out, Encoding::Bt, self, n_nodes)?;
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        out.write_all(&bytes)?;
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

pub(crate) fn read_nodes(nodes: &mut NodeReader<impl Read>) -> Result<(), Error> {
    read_inner(nodes, 0, &Clamps::default()).map(|_| ())
}

/// Reads an inner node at `depth` and all nodes below it. Returns its log-odds.
fn read_inner(nodes: &mut NodeReader<impl Read>, depth: u8, clamps: &Clamps) -> Result<f32, Error> {
    let mut bytes = [0; 2];
    nodes.fill(&mut bytes)?;
    let word = u16::from_le_bytes(bytes);
    if word == 0 && depth > 0 {
        return Err(
            nodes.error(format!("an inner node at depth {depth} has no children, expected at least one"))
        );
    }
    // Only the root keeps this value: OctoMap never updates it from its children.
    let start = if depth == 0 { clamps.occupied } else { f32::MIN };
    let idx = nodes.push(StoredNode::leaf(start))?;
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
    nodes.push(StoredNode::leaf(log_odds))?;
    Ok(log_odds)
}

/// The content of a file, and the number of nodes that it encodes.
struct Words {
    words: Vec<u16>,
    n_nodes: usize,
}

/// The words of the inner nodes in preorder. The root has one even if it is a leaf.
///
/// Pruning proceeds from depth to depth, up to the first at which nothing merges. Leaves are therefore first
/// merged at every depth, and if that was too much, again only at those below the first without a merge.
fn words(tree: &Octree) -> Words {
    let mut all = WordTree::of(tree, 1);
    if let Some(first_without) = (1..DEPTH).rev().find(|&depth| all.n_merged[usize::from(depth)] == 0)
        && all.n_merged[..usize::from(first_without)].iter().any(|&n| n > 0)
    {
        all = WordTree::of(tree, first_without + 1);
    }
    Words { n_nodes: tree.n_nodes() - 8 * all.n_merged.iter().sum::<usize>(), words: all.words }
}

/// Words being built while the nodes of a tree are visited in preorder.
struct WordTree<'a> {
    tree: &'a Octree,
    next: usize,
    /// The least depth of a node whose leaves are merged.
    least_depth: u8,
    words: Vec<u16>,
    /// By depth, the number of nodes whose leaves were merged.
    n_merged: [usize; DEPTH as usize],
}

impl<'a> WordTree<'a> {
    fn of(tree: &'a Octree, least_depth: u8) -> Self {
        let mut merging =
            Self { tree, next: 0, least_depth, words: Vec::new(), n_merged: Default::default() };
        if tree.n_nodes() > 0 {
            merging.visit(0);
            if merging.words.is_empty() {
                merging.words.push(0);
            }
        }
        merging
    }

    /// Visits the next node, which is at `depth`, and all nodes below it. Returns its code.
    fn visit(&mut self, depth: u8) -> u16 {
        let node = self.tree.node(self.next);
        self.next += 1;
        if node.child_mask == 0 {
            return if node.log_odds >= 0.0 { OCCUPIED } else { FREE };
        }
        let place = self.words.len();
        self.words.push(0);
        let (mut word, mut octants) = (0, node.child_mask);
        while octants != 0 {
            word |= self.visit(depth + 1) << (2 * octants.trailing_zeros());
            octants &= octants - 1;
        }
        let first = word & 3;
        if depth >= self.least_depth && first != INNER && word == first * EIGHT {
            self.words.truncate(place);
            self.n_merged[usize::from(depth)] += 1;
            return first;
        }
        self.words[place] = word;
        INNER
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Octree {
        /// The slow twin: the words of the pruned tree of most likely occupancies, backwards.
        pub(crate) fn write_bt_slowly(&self) -> Vec<u8> {
            let clamps = Clamps::default();
            let likely = |l: f32| if l >= 0.0 { clamps.occupied } else { clamps.free };
            let tree = self.clone().map_log_odds(likely).pruned();
            let mut file = Vec::new();
            write_header(&mut file, Encoding::Bt, &tree, tree.n_nodes()).unwrap();
            words_backwards(&tree).iter().rev().for_each(|word| file.extend(word.to_le_bytes()));
            file
        }
    }

    fn words_backwards(tree: &Octree) -> Vec<u16> {
        let mut words = Vec::new();
        // Codes of finished subtrees. Backwards, the children of a node come just before it, the first one
        // last.
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
        words
    }
}
