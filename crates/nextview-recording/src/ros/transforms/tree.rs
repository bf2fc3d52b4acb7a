use super::error::TransformError;
use super::motion::{Missing, TimedPoses};
use nextview::geometry::Pose;
use std::collections::BTreeMap;

/// Transforms between frames over time, from `/tf` and `/tf_static`: each frame has one parent.
///
/// Transforms may arrive in any order. A moving frame is interpolated between its neighbours in time, and
/// never extrapolated; a static one is valid at any time.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use nextview::geometry::Pose;
/// use nextview_recording::ros::{TransformError, TransformTree};
///
/// let at = |x: f64| Pose::new(DQuat::IDENTITY, DVec3::X * x).unwrap();
/// let mut tree = TransformTree::new(10.0);
/// tree.insert_static("flange", "camera", at(0.1))?;
/// tree.insert("base", "flange", 5.0, at(1.0))?;
/// tree.insert("base", "flange", 5.1, at(2.0))?;
/// let base_from_camera = tree.lookup("base", "camera", 5.05)?;
/// assert!((base_from_camera.translation().x - 1.6).abs() < 1e-9);
/// assert!(matches!(tree.lookup("base", "camera", 5.2), Err(TransformError::After { .. })));
/// # Ok::<(), TransformError>(())
/// ```
#[derive(Clone, Debug)]
pub struct TransformTree {
    /// Edges by child.
    edges: BTreeMap<String, TransformEdge>,
    history_s: f64,
}

#[derive(Clone, Debug)]
struct TransformEdge {
    parent: String,
    kind: EdgeKind,
}

#[derive(Clone, Debug)]
enum EdgeKind {
    Static(Pose),
    Moving(TimedPoses),
}

/// A transform that is this much older than another one of its frame, in seconds, belongs to another run of
/// the clock.
const BACKWARDS: f64 = 10.0;

/// Maximum number of frames: a robot has some hundreds.
const MAX_FRAMES: usize = 10_000;

impl TransformTree {
    /// Creates an empty tree, which forgets transforms older than the newest one of the same frame by this
    /// many seconds, at least 0; infinity keeps all.
    pub fn new(history_s: f64) -> Self {
        Self { edges: BTreeMap::new(), history_s: history_s.max(0.0) }
    }

    /// Adds the pose of a moving frame, the child, in its parent at a time in seconds. A leading slash in
    /// names is ignored.
    ///
    /// # Errors
    /// If the frame has another parent, is static, closes a cycle, has no name, or exceeds 10 000 frames, or
    /// if its time is not finite or runs backwards by more than 10 s. The tree is then unchanged.
    pub fn insert(
        &mut self,
        parent: &str,
        child: &str,
        time_s: f64,
        parent_from_child: Pose,
    ) -> Result<(), TransformError> {
        let (parent, child) = (plain(parent), plain(child));
        if !time_s.is_finite() {
            let problem = format!("the time is {time_s}, expected a number of seconds");
            return Err(invalid(parent, child, problem));
        }
        self.check(parent, child)?;
        let new =
            || TransformEdge { parent: parent.to_owned(), kind: EdgeKind::Moving(TimedPoses::default()) };
        let edge = self.edges.entry(child.to_owned()).or_insert_with(new);
        let EdgeKind::Moving(motion) = &mut edge.kind else {
            return Err(TransformError::BothKinds { frame: child.to_owned() });
        };
        let newest_s = motion.newest().unwrap_or(time_s);
        if time_s < newest_s - BACKWARDS {
            return Err(TransformError::ClockBackwards { frame: child.to_owned(), time_s, newest_s });
        }
        motion.insert(time_s, parent_from_child);
        motion.forget_before(newest_s.max(time_s) - self.history_s);
        Ok(())
    }

    /// Adds the constant pose of a frame in its parent; a later one replaces it.
    ///
    /// # Errors
    /// As [`insert`](Self::insert), or if the frame moves.
    pub fn insert_static(
        &mut self,
        parent: &str,
        child: &str,
        parent_from_child: Pose,
    ) -> Result<(), TransformError> {
        let (parent, child) = (plain(parent), plain(child));
        self.check(parent, child)?;
        if let Some(TransformEdge { kind: EdgeKind::Moving(_), .. }) = self.edges.get(child) {
            return Err(TransformError::BothKinds { frame: child.to_owned() });
        }
        let edge = TransformEdge { parent: parent.to_owned(), kind: EdgeKind::Static(parent_from_child) };
        self.edges.insert(child.to_owned(), edge);
        Ok(())
    }

    /// Forgets all poses of moving frames, as when the clock restarts; static ones are kept.
    pub fn forget_motion(&mut self) {
        self.edges.retain(|_, edge| matches!(edge.kind, EdgeKind::Static(_)));
    }

    /// Returns the transform that takes points from source to destination at a time in seconds.
    ///
    /// # Errors
    /// If a frame is unknown, the frames are not connected, or a frame between them is unknown at that time.
    pub fn lookup(&self, destination: &str, source: &str, time_s: f64) -> Result<Pose, TransformError> {
        let (up, down) = self.chains(destination, source)?;
        let common_from_source = self.climb(&up, time_s)?;
        let common_from_destination = self.climb(&down, time_s)?;
        Ok(common_from_destination.inverse() * common_from_source)
    }

    /// Fails if a frame is unknown, or the frames are not connected.
    ///
    /// # Errors
    /// As [`lookup`](Self::lookup), but for any time.
    pub fn check_connected(&self, destination: &str, source: &str) -> Result<(), TransformError> {
        self.chains(destination, source).map(drop)
    }

    /// Returns the root of the tree of a frame.
    ///
    /// # Errors
    /// If the frame is unknown.
    pub fn root_of(&self, frame: &str) -> Result<&str, TransformError> {
        let frame = self.known(frame)?;
        Ok(self.ancestors(frame).last().copied().unwrap_or(frame))
    }

    /// The names of all frames, sorted.
    pub fn frames(&self) -> Vec<&str> {
        let parents = self.edges.values().map(|edge| edge.parent.as_str());
        let mut frames: Vec<&str> = self.edges.keys().map(String::as_str).chain(parents).collect();
        frames.sort_unstable();
        frames.dedup();
        frames
    }

    /// Fails unless the child may have this parent.
    fn check(&self, parent: &str, child: &str) -> Result<(), TransformError> {
        if parent.is_empty() || child.is_empty() {
            return Err(invalid(parent, child, "a frame has no name, expected two names".to_owned()));
        }
        match self.edges.get(child) {
            Some(edge) if edge.parent == parent => Ok(()),
            Some(edge) => Err(TransformError::OtherParent {
                frame: child.to_owned(),
                parent: parent.to_owned(),
                before: edge.parent.clone(),
            }),
            None if self.ancestors(parent).contains(&child) => {
                Err(TransformError::Circle { frame: child.to_owned(), parent: parent.to_owned() })
            }
            None if self.edges.len() >= MAX_FRAMES => {
                let problem = format!("there are already {} frames, which is the maximum", self.edges.len());
                Err(invalid(parent, child, problem))
            }
            None => Ok(()),
        }
    }

    /// The frame of this name.
    fn known<'a>(&'a self, frame: &str) -> Result<&'a str, TransformError> {
        let frame = plain(frame);
        let frames = self.frames();
        frames.binary_search(&frame).map(|at| frames[at]).map_err(|_| TransformError::UnknownFrame {
            frame: frame.to_owned(),
            known: if frames.is_empty() {
                "at least one, but there are none".to_owned()
            } else {
                frames.join(", ")
            },
        })
    }

    /// A frame and its ancestors, up to the root.
    fn ancestors<'a>(&'a self, frame: &'a str) -> Vec<&'a str> {
        let parent = |child: &&'a str| self.edges.get(*child).map(|edge| edge.parent.as_str());
        std::iter::successors(Some(frame), parent).collect()
    }

    /// The frames from the source and from the destination up to their common ancestor, excluding it.
    fn chains<'a>(
        &'a self,
        destination: &str,
        source: &str,
    ) -> Result<(Vec<&'a str>, Vec<&'a str>), TransformError> {
        let (destination, source) = (self.known(destination)?, self.known(source)?);
        let (mut up, mut down) = (self.ancestors(source), self.ancestors(destination));
        if up.last() != down.last() {
            let root = |chain: &[&str]| chain.last().copied().unwrap_or_default().to_owned();
            return Err(TransformError::NoPath {
                destination: destination.to_owned(),
                destination_root: root(&down),
                source_frame: source.to_owned(),
                source_root: root(&up),
            });
        }
        while up.last().is_some() && up.last() == down.last() {
            up.pop();
            down.pop();
        }
        Ok((up, down))
    }

    /// The transform from the first of these frames, each the parent of the one before, to the parent of the
    /// last.
    fn climb(&self, chain: &[&str], time_s: f64) -> Result<Pose, TransformError> {
        let mut to_from_first = Pose::IDENTITY;
        for child in chain {
            let TransformEdge { parent, kind } = &self.edges[*child];
            let parent_from_child = match kind {
                EdgeKind::Static(pose) => *pose,
                EdgeKind::Moving(motion) => {
                    motion.at(time_s).map_err(|missing| error(missing, child, parent, time_s))?
                }
            };
            to_from_first = parent_from_child * to_from_first;
        }
        Ok(to_from_first)
    }
}

/// The ROS 2 form of a name: in ROS 1, it may begin with a slash.
fn plain(frame: &str) -> &str {
    frame.strip_prefix('/').unwrap_or(frame)
}

fn invalid(parent: &str, frame: &str, problem: String) -> TransformError {
    TransformError::Invalid { frame: frame.to_owned(), parent: parent.to_owned(), problem }
}

fn error(missing: Missing, frame: &str, parent: &str, time_s: f64) -> TransformError {
    let (frame, parent) = (frame.to_owned(), parent.to_owned());
    match missing {
        Missing::Before { first } => TransformError::Before { frame, parent, time_s, first_s: first },
        Missing::After { last } => TransformError::After { frame, parent, time_s, last_s: last },
        Missing::Gap { from, to } => TransformError::Gap { frame, parent, from_s: from, to_s: to },
    }
}
