use super::Session;
use crate::map::Snapshot;
use crate::Cancelled;

impl Session {
    /// The known state of the box, in the finest voxels, after each of [`frames`](Self::frames): in their
    /// final poses, and as if box and table had been known from the first one on. Empty before an object was
    /// found.
    pub fn replay(&self) -> impl Iterator<Item = Result<Snapshot, Cancelled>> {
        let mut map = self.scene.map.without_frames();
        self.frames().iter().filter_map(move |frame| {
            let written = map.integrate(frame, &self.cancel);
            written.and_then(|_| map.finest_snapshot(&self.cancel)).transpose()
        })
    }
}
