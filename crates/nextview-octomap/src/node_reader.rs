use crate::header::MapHeader;
use crate::source::{TrackedFile, error_at};
use crate::tree::{Octree, StoredNode};
use nextview::Error;
use std::io::Read;

/// A tree that grows while its file is read.
pub(crate) struct NodeReader<R> {
    source: TrackedFile<R>,
    tree: Octree,
    n_expected: u64,
    /// Start of the last record read.
    position: u64,
}

impl<R: Read> NodeReader<R> {
    pub fn new(source: TrackedFile<R>, header: &MapHeader) -> Self {
        let position = source.position();
        let tree = Octree::new(header.kind, header.voxel_size).with_origin(header.origin);
        Self { source, tree, n_expected: header.n_nodes, position }
    }

    pub fn tree(&mut self) -> &mut Octree {
        &mut self.tree
    }

    /// Reads a record of the node data.
    pub fn fill(&mut self, buffer: &mut [u8]) -> Result<(), Error> {
        self.position = self.source.position();
        if self.source.fill(buffer)? {
            return Ok(());
        }
        Err(self.error(format!("the data ends after {} of {} nodes", self.tree.n_nodes(), self.n_expected)))
    }

    pub fn push(&mut self, node: StoredNode) -> Result<usize, Error> {
        if self.tree.n_nodes() as u64 == self.n_expected {
            return Err(self
                .error(format!("the tree has more nodes than the size in its header, {}", self.n_expected)));
        }
        Ok(self.tree.push(node))
    }

    /// Returns an error in the last record read.
    pub fn error(&self, problem: impl ToString) -> Error {
        error_at(self.position, problem)
    }

    /// Returns the tree; fails unless it is complete and the data ends with it.
    pub fn finish(mut self) -> Result<Octree, Error> {
        let (n_nodes, n_expected) = (self.tree.n_nodes(), self.n_expected);
        if n_nodes as u64 != n_expected {
            let problem =
                format!("the tree is complete with {n_nodes} nodes, but its header says size {n_expected}");
            return Err(error_at(self.source.position(), problem));
        }
        self.source.expect_end()?;
        Ok(self.tree)
    }
}
