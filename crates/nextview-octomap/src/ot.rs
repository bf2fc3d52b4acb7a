use crate::header::{Encoding, write_header};
use crate::node_reader::NodeReader;
use crate::preorder::{DEPTH, Preorder};
use crate::tree::{Octree, StoredNode, TreeKind};
use nextview::Error;
use std::io::{BufWriter, Read, Write};

impl Octree {
    /// Writes an `.ot` file, with every node unchanged.
    pub fn write_ot(&self, writer: impl Write) -> Result<(), Error> {
        let mut out = BufWriter::new(writer);
        write_header(&mut out, Encoding::Ot, self, self.n_nodes())?;
        for node in (0..self.n_nodes()).map(|idx| self.node(idx)) {
            out.write_all(&node.log_odds.to_le_bytes())?;
            if self.kind() == TreeKind::ColorOcTree {
                out.write_all(&node.color)?;
            }
            out.write_all(&[node.child_mask])?;
        }
        Ok(out.flush()?)
    }
}

pub(crate) fn read_nodes(nodes: &mut NodeReader<impl Read>) -> Result<(), Error> {
    let mut preorder = Preorder::new();
    while let Some(place) = preorder.next_place() {
        let node = read_node(nodes)?;
        if place.depth == DEPTH && node.child_mask != 0 {
            return Err(
                nodes.error(format!("a node at depth {DEPTH} has children, expected none below a voxel"))
            );
        }
        preorder.descend(place, node.child_mask);
        nodes.push(node)?;
    }
    Ok(())
}

fn read_node(nodes: &mut NodeReader<impl Read>) -> Result<StoredNode, Error> {
    let mut log_odds = [0; 4];
    nodes.fill(&mut log_odds)?;
    let log_odds = f32::from_le_bytes(log_odds);
    if !log_odds.is_finite() {
        return Err(nodes.error(format!("the log-odds are {log_odds}, expected a finite number")));
    }
    let mut color = StoredNode::WHITE;
    if nodes.tree().kind() == TreeKind::ColorOcTree {
        nodes.fill(&mut color)?;
    }
    let mut child_mask = [0];
    nodes.fill(&mut child_mask)?;
    Ok(StoredNode { log_odds, color, child_mask: child_mask[0] })
}
