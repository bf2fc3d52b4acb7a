//! The 14 views of NBV-Net: its classes.

use glam::DVec3;

/// Number of views.
pub const N_VIEWS: usize = 14;

/// Direction of view `k` from the centre of the box: point `k` of a spiral of 20 on the unit sphere,
///
/// ```text
/// z = 1 - (2 k + 1) / 20    azimuth = -(k + 1/2) pi (3 - sqrt 5)
/// ```
///
/// of which NBV-Net uses the upper 14, down to 21 degrees below the horizon. On a sphere of radius 0.4 these
/// are the points published with the authors' code, to the six digits stated there (z is 0.38, 0.34, ...,
/// -0.14), and in the same order: the authors' weights refer to the same views. Written out, because sine and
/// cosine differ between machines.
pub const DIRECTIONS: [DVec3; N_VIEWS] = [
    DVec3::new(0.113_151_523_161_122, -0.291_027_031_057_801, 0.95),
    DVec3::new(-0.472_409_665_397_330, 0.233_086_052_862_849, 0.85),
    DVec3::new(0.635_075_956_669_918, 0.184_874_360_742_068, 0.75),
    DVec3::new(-0.394_541_628_493_135, -0.649_489_725_389_082, 0.65),
    DVec3::new(-0.162_433_024_034_340, 0.819_216_401_632_108, 0.55),
    DVec3::new(0.719_784_301_681_687, -0.528_592_999_435_867, 0.45),
    DVec3::new(-0.931_271_440_386_401, -0.101_160_784_499_913, 0.35),
    DVec3::new(0.639_148_350_664_165, 0.727_316_565_082_412, 0.25),
    DVec3::new(0.020_429_539_983_580, -0.988_474_903_017_805, 0.15),
    DVec3::new(-0.689_718_795_116_708, 0.722_348_934_838_805, 0.05),
    DVec3::new(0.996_516_868_698_500, -0.066_739_271_792_069, -0.05),
    DVec3::new(-0.772_024_299_629_985, -0.617_639_442_377_858, -0.15),
    DVec3::new(0.148_913_601_423_951, 0.956_726_052_384_354, -0.25),
    DVec3::new(0.519_004_528_094_695, -0.779_829_660_770_352, -0.35),
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn directions_are_those_of_the_formula() {
        for (k, direction) in DIRECTIONS.into_iter().enumerate() {
            let z = 1.0 - (2 * k + 1) as f64 / 20.0;
            let (sin, cos) = (-(k as f64 + 0.5) * PI * (3.0 - 5.0_f64.sqrt())).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            assert!(
                direction.distance(DVec3::new(radius * cos, radius * sin, z)) < 1e-14,
                "{k}: {direction}"
            );
            assert!((direction.length() - 1.0).abs() < 1e-14);
        }
        assert!(
            (DIRECTIONS[0] * 0.4).abs_diff_eq(DVec3::new(0.045261, -0.116411, 0.38), 1e-6),
            "as published"
        );
        assert!((DIRECTIONS[13] * 0.4).abs_diff_eq(DVec3::new(0.207602, -0.311932, -0.14), 1e-6));
    }
}
