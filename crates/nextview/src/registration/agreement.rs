use super::fitting::PoseComparison;
use super::known_surface::KnownSurface;
use super::{Registration, RegistrationConfig, Verdict};
use crate::geometry::Aabb;
use crate::sensor::Frame;
use crate::{Cancel, Cancelled};

/// Number of frames after which all are compared, once.
const N_COMPARED: usize = 4;

/// Minimum number of frames that must show a wrong pose.
const LEAST_FRAMES: usize = 2;

/// Minimum factor by which alignment must bring surfaces closer than in the given poses.
const TIMES_NEARER: f64 = 3.0;

/// Errors of the given poses below this share of a cell do not matter.
const LEAST_ERROR: f64 = 0.1;

/// Maximum ratio of the camera's motion to the distance between the surfaces. An alignment that moves the
/// camera farther slides along the surface.
///
/// Simulated parts with poses off by 1.5 and 5 mm have ratios of 1.1 to 3.3; recordings of a flat box and of
/// mugs on a table, with right poses, 8 and more.
const MOST_TIMES_FARTHER: f64 = 6.0;

/// Minimum share of a frame's points that lie on the surface of earlier frames after the alignment.
const LEAST_OVERLAP: f64 = 0.3;

/// Counts how many given poses proved wrong, each frame compared with those before it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Agreement {
    /// Number of frames that overlap with those before them.
    n_compared: usize,
    /// Number of frames whose pose is wrong.
    n_wrong: usize,
}

impl Agreement {
    /// Counts a frame [compared](KnownSurface::compare) with points pooled in cells of this edge, metres.
    /// Returns the distance between its surface and that of the others, metres, if the given poses are wrong:
    /// if this frame shows it clearly, or if at least two frames and more than half of them do. A single
    /// frame may have slid.
    pub fn add(&mut self, compared: &PoseComparison, spacing: f64) -> Option<f64> {
        self.n_compared += (compared.found.overlap >= LEAST_OVERLAP) as usize;
        let is_wrong = is_wrong(compared, spacing);
        self.n_wrong += is_wrong as usize;
        let is_clear = compared.apart > TIMES_NEARER * compared.found.residual_after;
        let are_more = self.n_wrong >= LEAST_FRAMES && 2 * self.n_wrong > self.n_compared;
        (is_wrong && (is_clear || are_more)).then_some(compared.apart)
    }
}

/// Whether a compared frame shows that its pose is wrong.
///
/// The distance that remains after the alignment is sensor noise and the coarseness of the points. A wrong
/// pose adds more than that to the squared distances, and the camera need not move much farther than the
/// surfaces are apart. With right poses, an alignment removes 1 to 5 %.
fn is_wrong(&PoseComparison { found, apart }: &PoseComparison, spacing: f64) -> bool {
    let removed_sq = apart.powi(2) - found.residual_after.powi(2);
    found.verdict != Verdict::NoBetter
        && found.overlap >= LEAST_OVERLAP
        && removed_sq > found.residual_after.powi(2)
        && found.moved <= MOST_TIMES_FARTHER * apart
        && removed_sq > (LEAST_ERROR * spacing).powi(2)
}

/// Returns how far apart the first frames, oldest first, show the same surface: root mean square along its
/// normal, metres; the median over those frames that alignment brings closer to the earlier ones. `None`
/// unless the number of frames is the one to compare, and two are more than half a voxel (of this edge,
/// metres) apart.
pub(crate) fn apart(
    frames: &[Frame],
    bounds: Aabb,
    voxel_size: f64,
    cancel: &Cancel,
) -> Result<Option<f64>, Cancelled> {
    if frames.len() != N_COMPARED {
        return Ok(None);
    }
    let spacing = voxel_size.min(RegistrationConfig::DEFAULT_SPACING);
    let config = RegistrationConfig { spacing: Some(spacing), ..RegistrationConfig::default() };
    let Ok(mut known) = KnownSurface::new(config) else { return Ok(None) };
    let mut distances = Vec::new();
    for frame in frames {
        let found = known.compare(frame, bounds, cancel)?.found;
        if is_apart(&found, voxel_size) {
            distances.push(found.residual_before);
        }
        known.add(frame, &frame.world_from_camera(), bounds, cancel)?;
    }
    distances.sort_by(f64::total_cmp);
    Ok((distances.len() >= LEAST_FRAMES).then(|| distances[distances.len() / 2]))
}

fn is_apart(found: &Registration, voxel_size: f64) -> bool {
    // One face of a box fits well on the next, but then the rest lies in space that cameras saw as free.
    found.verdict != Verdict::NoBetter
        && found.overlap >= LEAST_OVERLAP
        && found.residual_before > 0.5 * voxel_size
        && found.residual_before > TIMES_NEARER * found.residual_after
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    /// A frame with these distances to the others before and after an alignment, and the camera's motion,
    /// all in millimetres.
    fn compared(apart: f64, after: f64, moved: f64) -> PoseComparison {
        let found = Registration {
            world_from_camera: Pose::IDENTITY,
            verdict: Verdict::Aligned,
            residual_before: 1e-3 * apart,
            residual_after: 1e-3 * after,
            overlap: 0.5,
            misfit: 0.0,
            moved: 1e-3 * moved,
            turned: 0.0,
            stiffness: 0.1,
            n_iterations: 5,
        };
        PoseComparison { found, apart: 1e-3 * apart }
    }

    /// For each frame, whether it shows that the poses are wrong.
    fn shown(frames: &[PoseComparison]) -> Vec<bool> {
        let mut agreement = Agreement::default();
        frames.iter().map(|compared| agreement.add(compared, 0.005).is_some()).collect()
    }

    #[test]
    fn poses_are_wrong_if_one_frame_shows_it_clearly_or_most_frames_do() {
        let (right, wrong, clear) =
            (compared(1.05, 1.0, 1.0), compared(2.0, 1.0, 3.0), compared(4.0, 1.0, 6.0));
        assert_eq!(shown(&[right, clear]), [false, true]);
        assert_eq!(shown(&[right, wrong, wrong]), [false, false, true]);
        assert_eq!(shown(&[right, right, right, wrong, wrong]), [false; 5]);
    }

    #[test]
    fn a_frame_that_slides_or_hardly_overlaps_shows_nothing() {
        let slid = compared(4.0, 1.0, 30.0);
        let clear = compared(4.0, 1.0, 6.0);
        let beside = PoseComparison { found: Registration { overlap: 0.2, ..clear.found }, ..clear };
        let worse =
            PoseComparison { found: Registration { verdict: Verdict::NoBetter, ..clear.found }, ..clear };
        let slight = compared(0.4, 0.1, 0.4);
        assert_eq!(shown(&[slid, slid, beside, beside, worse, worse, slight, slight]), [false; 8]);
    }
}
