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

/// The frames before another one came.
pub(super) struct State {
    poses: Vec<Pose>,
    set_aside: Vec<SetAside>,
    places: Vec<Pose>,
}

impl TakenFrames {
    /// Puts a frame into the map.
    pub fn map(&mut self, number: usize, frame: Frame) {
        self.places[number] = frame.world_from_camera();
        self.mapped.push(frame);
        self.numbers.push(number);
    }

    /// Moves the last frames in the map to these poses.
    pub fn move_to(&mut self, poses: &[Pose]) {
        let first = self.mapped.len() - poses.len();
        let moved = self.mapped[first..].iter_mut().zip(&self.numbers[first..]).zip(poses);
        for ((frame, number), pose) in moved {
            frame.move_to(*pose);
            self.places[*number] = *pose;
        }
    }

    /// What [`forget`](Self::forget) needs to undo what the next frame changes.
    pub fn state(&self) -> State {
        let poses = self.mapped.iter().map(Frame::world_from_camera).collect();
        State { poses, set_aside: self.set_aside.clone(), places: self.places.clone() }
    }

    /// Forgets a frame, the last one, and all that it changed.
    pub fn forget(&mut self, before: State) {
        self.mapped.truncate(before.poses.len());
        self.numbers.truncate(before.poses.len());
        self.mapped.iter_mut().zip(before.poses).for_each(|(frame, pose)| frame.move_to(pose));
        (self.places, self.set_aside) = (before.places, before.set_aside);
    }
}
