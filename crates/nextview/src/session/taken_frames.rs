use crate::geometry::Pose;
use crate::registration::Registration;
use crate::sensor::Frame;

/// A frame that registration set aside: it could not be aligned, so that it is in neither map nor model.
#[derive(Clone, Debug)]
pub struct SetAside {
    /// Number of the frame among all observed ones, from 0.
    pub number: usize,
    /// The frame in the given pose.
    pub frame: Frame,
    /// The last attempt to align it.
    pub registration: Registration,
}

/// All frames observed so far.
#[derive(Clone, Debug, Default)]
pub(super) struct TakenFrames {
    /// Those in the map, in the order in which they came there.
    pub mapped: Vec<Frame>,
    /// The number of each of them among all observed ones.
    pub numbers: Vec<usize>,
    /// The others, oldest first.
    pub set_aside: Vec<SetAside>,
    /// Where the frames were taken, by number: as mapped or, of those set aside, as given.
    pub places: Vec<Pose>,
}

impl TakenFrames {
    /// Puts a frame into the map.
    pub fn map(&mut self, number: usize, frame: Frame) {
        self.places[number] = frame.world_from_camera();
        self.mapped.push(frame);
        self.numbers.push(number);
    }

    /// Forgets a frame, the last one, and all that it changed; `set_aside` are those before it.
    pub fn forget(&mut self, n_mapped: usize, set_aside: Vec<SetAside>) {
        self.mapped.truncate(n_mapped);
        self.numbers.truncate(n_mapped);
        self.places.pop();
        for waiting in &set_aside {
            self.places[waiting.number] = waiting.frame.world_from_camera();
        }
        self.set_aside = set_aside;
    }
}
