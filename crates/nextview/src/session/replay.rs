use super::Session;
use crate::Cancelled;
use crate::map::Snapshot;

impl Session {
    /// Returns the known state of the box, in the finest voxels, after each of [`frames`](Self::frames) in
    /// its final pose, as if box, table and the placement [before](Self::earlier_frames) had been known from
    /// the first one on. Empty before an object is found.
    pub fn replay(&self) -> impl Iterator<Item = Result<Snapshot, Cancelled>> {
        let mut map = self.scene.map.without_frames();
        let mut earlier = self.earlier_frames().iter();
        self.frames().iter().filter_map(move |frame| {
            let mut new = earlier.by_ref().chain([frame]);
            let written = new.try_for_each(|frame| map.integrate(frame, &self.cancel).map(|_| ()));
            written.and_then(|()| map.finest_snapshot(&self.cancel)).transpose()
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::geometry::Aabb;
    use crate::map::Occupancy;
    use crate::planner::RandomViews;
    use crate::sensor::{DepthImage, Frame, Intrinsics};
    use crate::session::{Decision, Session, SessionConfig};
    use crate::view::generate::fibonacci_sphere;
    use glam::{DVec2, DVec3};

    #[test]
    fn a_replay_ends_with_what_is_known() {
        let camera = Intrinsics::pinhole(40, 30, DVec2::splat(40.0), DVec2::new(19.5, 14.5)).unwrap();
        let config = SessionConfig::new(0.01, Aabb::cube(DVec3::ZERO, 0.1));
        let views = fibonacci_sphere(DVec3::ZERO, 0.4, 20).unwrap();
        let mut session = Session::new(config, camera, views, Box::new(RandomViews { seed: 1 })).unwrap();
        assert_eq!(session.replay().count(), 0);
        let mut known = Vec::new();
        for _ in 0..4 {
            let Decision::Move(view) = session.decide().unwrap() else { panic!("the scan is not over") };
            let image = DepthImage::from_metres(40, 30, vec![0.35; 1200]).unwrap();
            session.observe(&Frame::new(image, camera, view.world_from_camera, 1.0).unwrap()).unwrap();
            known.push(session.snapshot().unwrap());
        }
        let replayed: Vec<_> = session.replay().map(Result::unwrap).collect();
        assert_eq!(replayed.len(), 4);
        for (replayed, known) in replayed.iter().zip(&known) {
            assert_eq!(replayed.block(), known.block());
            assert_eq!(replayed.probability(), known.probability());
        }
        assert!(replayed[0].count(Occupancy::Unknown) > replayed[3].count(Occupancy::Unknown));
    }
}
