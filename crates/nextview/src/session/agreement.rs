use crate::geometry::Aabb;
use crate::registration::{KnownSurface, Registration, RegistrationConfig, Verdict};
use crate::sensor::Frame;
use crate::{Cancel, Cancelled};

/// Number of frames after which they are compared, once.
const N_COMPARED: usize = 4;

/// Two frames or more must say so.
const LEAST_FRAMES: usize = 2;

/// Surfaces that are aligned are at least so many times nearer to each other than in the given poses.
const TIMES_NEARER: f64 = 3.0;

/// Errors of the given poses below this share of a cell do not matter.
const LEAST_ERROR: f64 = 0.1;

/// Of a frame, at least this share lies on the surface of those before it once it is aligned.
const LEAST_OVERLAP: f64 = 0.3;

/// How far the same surface is apart, metres, in a frame that was [compared](KnownSurface::compare) with
/// those before it, points pooled in cells of this edge, metres; `None` unless the given poses are wrong.
///
/// What an alignment leaves of the distances is the noise of the sensor and the coarseness of the points.
/// Poses are wrong if they add more to the squared distances than that. With right poses, an alignment
/// removes 1 to 5 %.
pub(super) fn distance_if_wrong(found: &Registration, spacing: f64) -> Option<f64> {
    let removed_sq = found.residual_before.powi(2) - found.residual_after.powi(2);
    let is_wrong = found.verdict != Verdict::NoBetter
        && found.overlap >= LEAST_OVERLAP
        && removed_sq > found.residual_after.powi(2)
        && removed_sq > (LEAST_ERROR * spacing).powi(2);
    is_wrong.then_some(found.residual_before)
}

/// How far the same surface is apart in the first frames, oldest first, root mean square along its normal,
/// metres: the median over those that an alignment to the frames before them brings together. None unless the
/// frames are as many as are compared, and two are farther apart than half a voxel (of this edge, metres).
pub(super) fn apart(
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
        let found = known.compare(frame, bounds, cancel)?;
        if is_apart(&found, voxel_size) {
            distances.push(found.residual_before);
        }
        known.add(frame, &frame.world_from_camera(), bounds, cancel)?;
    }
    distances.sort_by(f64::total_cmp);
    Ok((distances.len() >= LEAST_FRAMES).then(|| distances[distances.len() / 2]))
}

fn is_apart(found: &Registration, voxel_size: f64) -> bool {
    // One face of a box lies well on the next, but then the rest stands where cameras looked through.
    found.verdict != Verdict::NoBetter
        && found.overlap >= LEAST_OVERLAP
        && found.residual_before > 0.5 * voxel_size
        && found.residual_before > TIMES_NEARER * found.residual_after
}
