//! Odd values from the bytes that the fuzzer makes up.

use glam::{DQuat, DVec2, DVec3};
use nextview::geometry::Pose;
use nextview::sensor::{Distortion, Intrinsics};

/// Values from front to back; zeros once the bytes are used up.
pub struct Source<'a>(pub &'a [u8]);

/// Numbers at which arithmetic breaks.
const ODD: [f64; 12] =
    [0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, 1e-9, 1e9, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX];

impl<'a> Source<'a> {
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first
    }

    /// One of these.
    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.byte() as usize % from.len()]
    }

    /// A number: mostly from -1.27 to 1.28, now and then an odd one.
    pub fn number(&mut self) -> f64 {
        match self.byte() {
            odd @ 0..12 => ODD[odd as usize],
            plain => (plain as f64 - 127.0) * 0.01,
        }
    }

    pub fn vector(&mut self) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number())
    }

    /// A pose, if these numbers are one.
    pub fn pose(&mut self) -> Option<Pose> {
        let rotation = DQuat::from_xyzw(self.number(), self.number(), self.number(), self.number());
        let rotation = if self.byte() % 4 > 0 { rotation.normalize() } else { rotation };
        Pose::new(rotation, self.vector()).ok()
    }

    /// The bytes up to a length that two bytes state, or all.
    pub fn part(&mut self) -> &'a [u8] {
        let length = usize::from(self.byte()) + 256 * usize::from(self.byte());
        let (part, rest) = self.0.split_at(length.min(self.0.len()));
        self.0 = rest;
        part
    }
}

/// A camera of 8 x 6 pixels.
pub fn camera() -> Intrinsics {
    Intrinsics::pinhole(8, 6, DVec2::splat(7.0), DVec2::new(3.5, 2.5)).expect("a camera")
}

/// The same behind a lens, if it can be one.
pub fn lens(source: &mut Source<'_>) -> Option<Intrinsics> {
    let kind = source.byte() % 4;
    let mut k = || [0; 5].map(|_| source.number());
    let distortion = match kind {
        0 => Distortion::BrownConrady(k()),
        1 => Distortion::InverseBrownConrady(k()),
        _ => return Some(camera()),
    };
    camera().with_distortion(distortion).ok()
}
