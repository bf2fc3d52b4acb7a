use crate::header::{Encoding, MapHeader};
use crate::node_reader::NodeReader;
use crate::source::TrackedFile;
use crate::tree::Octree;
use crate::{bt, ot};
use nextview::Error;
use std::io::Read;

impl Octree {
    /// Reads an `.ot` or a `.bt` file; the first line gives the format. The nodes must fill the rest of the
    /// file.
    ///
    /// A `.bt` file stores only free and occupied: leaves get OctoMap's default clamping values (log-odds
    /// -2.00 and 3.51), inner nodes the highest of their children, and the root always 3.51, as in OctoMap.
    /// Memory grows with the data read, not with the header's claims.
    pub fn read(reader: impl Read) -> Result<Self, Error> {
        let mut source = TrackedFile::new(reader);
        let header = MapHeader::read(&mut source)?;
        let mut nodes = NodeReader::new(source, &header);
        match header.encoding {
            _ if header.n_nodes == 0 => {}
            Encoding::Ot => ot::read_nodes(&mut nodes)?,
            Encoding::Bt => bt::read_nodes(&mut nodes)?,
        }
        nodes.finish()
    }
}
