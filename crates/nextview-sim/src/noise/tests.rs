//! Compares the model with its formulas, on planes in front of the camera.

use super::*;
use glam::{DQuat, DVec2, DVec3};
use nextview::sensor::{DepthNoise, Intrinsics, Sensor};
use std::f64::consts::FRAC_PI_2;

const SIZE: u32 = 200;

fn camera() -> Intrinsics {
    Intrinsics::pinhole(SIZE, SIZE, DVec2::splat(600.0), DVec2::splat(99.5)).unwrap()
}

/// The exact image of the plane n . p = 1.
fn plane(n: DVec3) -> Vec<f32> {
    let ray = |pixel: u32| camera().deproject(DVec2::new((pixel % SIZE) as f64, (pixel / SIZE) as f64));
    (0..SIZE * SIZE).map(|pixel| (1.0 / n.dot(ray(pixel).unwrap().extend(1.0))) as f32).collect()
}

/// The plane through the point at this depth on the axis, turned about the vertical by this angle.
fn tilted(depth: f64, angle: f64) -> Vec<f32> {
    plane(DVec3::new(-angle.tan(), 0.0, 1.0) / depth)
}

fn reported(noise: SensorNoise, exact: &[f32]) -> Vec<f32> {
    let readings = Readings::new(&noise, exact, &camera(), &mut Random::new(1, 0));
    let waves = Waves::new(&noise, &camera(), &mut Random::new(1, 3));
    readings.reported(&noise, exact, waves.as_ref(), &mut Random::new(1, 1))
}

fn lost_share(image: &[f32]) -> f64 {
    image.iter().filter(|depth| depth.is_nan()).count() as f64 / image.len() as f64
}

fn mean_and_sigma(image: &[f32]) -> (f64, f64) {
    let n = image.len() as f64;
    let mean = image.iter().map(|&d| d as f64).sum::<f64>() / n;
    (mean, (image.iter().map(|&d| (d as f64 - mean).powi(2)).sum::<f64>() / n).sqrt())
}

/// 40,000 pixels: the standard error of a sigma is 0.35 % of it.
#[test]
fn axial_noise_grows_with_the_square_of_the_depth() {
    let noise = SensorNoise { depth_unit: 0.0, disparity_step: 0.0, ..SensorNoise::d435i() };
    for depth in [0.3, 0.6] {
        let image = reported(noise, &plane(DVec3::Z / depth));
        assert_eq!(lost_share(&image), 0.0);
        let (mean, sigma) = mean_and_sigma(&image);
        let expected = noise.axial_sigma(depth);
        assert!((sigma / expected - 1.0).abs() < 0.015, "sigma {sigma} at {depth} m, expected {expected}");
        assert!((mean - depth).abs() < 0.02 * expected, "mean {mean} at {depth} m");
    }
    let sigma_at_20_cm = noise.axial_sigma(0.2);
    assert!(sigma_at_20_cm < 0.0003, "Intel states less than 0.3 mm at 20 cm, this is {sigma_at_20_cm}");
}

#[test]
fn lateral_noise_is_a_depth_error_on_slopes() {
    let off =
        SensorNoise { disparity_sigma: 0.0, depth_unit: 0.0, disparity_step: 0.0, ..SensorNoise::d435i() };
    let exact = tilted(0.5, 45_f64.to_radians());
    for (sigma, expected) in [(0.0, 0.0), (0.5, 0.317_3), (1.0, 0.617_1)] {
        let image = reported(SensorNoise { lateral_sigma: sigma, ..off }, &exact);
        let moved = image.iter().zip(&exact).filter(|(told, exact)| (*told - *exact).abs() > 1e-5);
        let share = moved.count() as f64 / exact.len() as f64;
        assert!((share - expected).abs() < 0.01, "{share} at {sigma}: beyond half a pixel along the slope");
    }
}

#[test]
fn the_disparity_and_the_depth_come_in_steps() {
    let noise = SensorNoise::d435i();
    let on_grid = |value: f64, step: f64| ((value / step).round() * step - value).abs() < 1e-3 * step;
    let image = reported(SensorNoise { depth_unit: 0.0, ..noise }, &tilted(0.5, 0.5));
    assert!(image.iter().all(|&depth| on_grid(424.0 * 0.05 / depth as f64, 1.0 / 32.0)));
    let image = reported(noise, &tilted(0.5, 0.5));
    assert!(image.iter().all(|&depth| on_grid(depth as f64, 0.001)));
    assert_eq!(
        noise.reported(2000.0, 0.0).to_bits(),
        f32::NAN.to_bits(),
        "less than half a step of disparity"
    );
}

#[test]
fn near_surfaces_and_empty_pixels_are_lost() {
    let noise = SensorNoise::d435i();
    for (depth, expected) in [(0.16, 1.0), (0.18, 0.0), (f64::INFINITY, 1.0), (f64::NAN, 1.0)] {
        assert_eq!(lost_share(&reported(noise, &vec![depth as f32; 40_000])), expected, "{depth}");
    }
}

/// Seen from the left half, the tilted plane has another angle; only the middle columns have the stated one.
#[test]
fn loss_grows_with_the_angle_up_to_all() {
    let noise = SensorNoise { edge_gradient: 1e9, ..SensorNoise::d435i() };
    for degrees in [0.0_f64, 60.0, 69.0, 75.0, 80.0, 85.0] {
        let angle = degrees.to_radians();
        // The far end is to the left: the second camera, on the right, sees the plane less steeply.
        let exact = tilted(1.0, -angle);
        let loss = loss::probabilities(&noise, &exact, &camera());
        let middle: Vec<f64> = (0..200).map(|v| loss[v * 200 + 99] as f64).collect();
        let rows = middle.iter().zip(0..200).map(|(loss, v)| {
            let ray = DVec3::new(-0.5 / 600.0, (v as f64 - 99.5) / 600.0, 1.0).normalize();
            let normal = DVec3::new(angle.tan(), 0.0, 1.0).normalize();
            (loss - noise.grazing_loss(ray.dot(normal).acos())).abs()
        });
        let worst = rows.fold(0.0, f64::max);
        assert!(worst < 2e-3, "{degrees} degrees: off by {worst}");
    }
    assert_eq!(noise.grazing_loss(80_f64.to_radians()), 0.5);
    assert_eq!(noise.grazing_loss(FRAC_PI_2), 1.0);
    let half = Readings::new(&noise, &tilted(1.0, -80_f64.to_radians()), &camera(), &mut Random::new(3, 0));
    let lost = half.reported(&noise, &tilted(1.0, -80_f64.to_radians()), None, &mut Random::new(3, 1));
    let middle: Vec<f32> = (0..200).flat_map(|v| lost[v * 200 + 90..][..20].to_vec()).collect();
    assert!((lost_share(&middle) - 0.5).abs() < 0.03, "{}", lost_share(&middle));
}

/// A square plate at 0.4 m in front of a wall at 0.8 m: the second camera shifts the plate by 75 pixels to
/// the left, and the wall by 37.5.
#[test]
fn the_wall_left_of_a_plate_is_hidden_and_edges_are_thinned() {
    let noise = SensorNoise { lateral_sigma: 0.0, ..SensorNoise::d435i() };
    let loss = loss::probabilities(&noise, &plate_before_wall(), &camera());
    let at = |u: usize, v: usize| loss[v * 200 + u];
    let row: Vec<f32> = (0..200).map(|u| at(u, 100)).collect();
    let hidden: Vec<usize> = (0..200).filter(|&u| row[u] == 1.0).collect();
    assert_eq!(hidden, (43..80).collect::<Vec<_>>());
    let edges: Vec<usize> = (0..200).filter(|&u| row[u] == 0.5).collect();
    assert_eq!(edges, [80, 119, 120]);
    assert_eq!([at(100, 79), at(100, 80), at(100, 90), at(20, 20)], [0.5, 0.5, 0.0, 0.0]);
}

#[test]
fn the_truth_is_exact_where_something_was_read() {
    let exact = tilted(0.5, 1.3);
    let noise = SensorNoise::d435i();
    let readings = Readings::new(&noise, &exact, &camera(), &mut Random::new(1, 0));
    let measured = readings.truly_measured(&exact);
    let n_kept = measured.iter().zip(&exact).filter(|(m, e)| m == e).count();
    assert_eq!(n_kept, measured.iter().filter(|m| !m.is_nan()).count());
    assert!((0.3..0.999).contains(&(n_kept as f64 / 40_000.0)), "{n_kept}");
}

#[test]
fn pose_errors_have_their_sigmas_and_are_of_the_frame() {
    let pose = PoseError { translation_sigma: 0.01, rotation_sigma: 0.02 };
    let noise = Noise { seed: 5, depth: None, pose, ..Noise::default() };
    let errors: Vec<(DVec3, DVec3)> = (0..4000)
        .map(|i| {
            let at = DVec3::new(i as f64, 0.5, -1.0);
            let world_from_camera = Pose::new(DQuat::from_rotation_x(0.3), at).unwrap();
            let mut random = noise.random(&world_from_camera, Use::Pose);
            let claimed = pose.claimed(&world_from_camera, &mut random).unwrap();
            let again = pose.claimed(&world_from_camera, &mut noise.random(&world_from_camera, Use::Pose));
            assert_eq!(again.unwrap(), claimed);
            let turn = world_from_camera.rotation().conjugate() * claimed.rotation();
            (claimed.translation() - at, turn.to_scaled_axis())
        })
        .collect();
    let rms = |values: Vec<f64>| (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt();
    for axis in 0..3 {
        let shift = rms(errors.iter().map(|(shift, _)| shift[axis]).collect());
        let turn = rms(errors.iter().map(|(_, turn)| turn[axis]).collect());
        assert!((shift / 0.01 - 1.0).abs() < 0.05 && (turn / 0.02 - 1.0).abs() < 0.05, "{shift}, {turn}");
    }
}

#[test]
fn parameters_out_of_range_are_named() {
    let d435i = SensorNoise::d435i();
    for (noise, expected) in [
        (SensorNoise { baseline: -1.0, ..d435i }, "baseline_m is -1, expected 0 or a positive number of"),
        (
            SensorNoise { baseline: 0.0, ..d435i },
            "baseline_m is 0, expected a positive number of metres, or no disparity_sigma_px and",
        ),
        (SensorNoise { focal: f64::INFINITY, ..d435i }, "focal_px is inf"),
        (SensorNoise { disparity_sigma: -1.0, ..d435i }, "disparity_sigma_px is -1"),
        (SensorNoise { disparity_step: f64::NAN, ..d435i }, "disparity_step_px is NaN"),
        (SensorNoise { depth_unit: -0.1, ..d435i }, "depth_unit_m is -0.1"),
        (SensorNoise { min_depth: -0.1, ..d435i }, "min_depth_m is -0.1"),
        (SensorNoise { lateral_sigma: 5.0, ..d435i }, "lateral_sigma_px is 5, expected 0 to 4 pixels"),
        (SensorNoise { edge_gradient: 0.0, ..d435i }, "edge_gradient is 0"),
        (SensorNoise { edge_loss: 1.5, ..d435i }, "edge_loss is 1.5, expected a probability"),
        (SensorNoise { grazing_from: 1.6, ..d435i }, "grazing_from_rad is 1.6"),
        (SensorNoise { correlated_share: 1.1, ..d435i }, "correlated_share is 1.1, expected a share"),
        (SensorNoise { correlation: 0.5, ..d435i }, "correlation_px is 0.5, expected 1 to 100 pixels"),
        (SensorNoise { flying_share: -0.1, ..d435i }, "flying_share is -0.1, expected a probability"),
        (SensorNoise { flying_jump: 0.0, ..d435i }, "flying_jump is 0, expected a positive number"),
        (SensorNoise { error: DepthNoise { linear: -1.0, ..d435i.error }, ..d435i }, "linear is -1"),
    ] {
        let error = Noise { depth: Some(noise), ..Noise::default() }.check().unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    }
    let pose = PoseError { translation_sigma: -0.1, ..PoseError::default() };
    let error = Noise { pose, ..Noise::default() }.check().unwrap_err().to_string();
    assert_eq!(error, "pose error (translation) is -0.1, expected 0 to 1 m");
    assert!(d435i.check().is_ok() && Noise::default().is_none());
}

/// Any change of these bits changes published tables.
#[test]
fn the_d435i_is_pinned() {
    let bits = |hash: u64, depth: &f32| (hash ^ depth.to_bits() as u64).wrapping_mul(0x0100_0000_01B3);
    let images = [tilted(0.5, 1.3), tilted(0.3, -0.4), plate_before_wall()];
    let hashes = images.map(|image| reported(SensorNoise::d435i(), &image).iter().fold(0, bits));
    assert_eq!(hashes, [8_766_436_813_235_777_439, 16_793_859_158_636_192_776, 13_174_909_887_420_735_819]);
}

/// A square plate at 0.4 m in front of a wall at 0.8 m.
fn plate_before_wall() -> Vec<f32> {
    let is_plate = |i: u32| (80..120).contains(&(i % SIZE)) && (80..120).contains(&(i / SIZE));
    (0..SIZE * SIZE).map(|i| if is_plate(i) { 0.4 } else { 0.8 }).collect()
}

/// Apart from rounding, every sensor's error has the stated sigma; 40,000 pixels whose errors correlate over
/// some pixels count as a few hundred.
#[test]
fn every_sensor_has_the_noise_it_states() {
    for sensor in Sensor::ALL {
        let noise = SensorNoise::of(sensor);
        noise.check().unwrap();
        assert_eq!(noise.range(), sensor.depth_range(), "{sensor}");
        let exact = SensorNoise { depth_unit: 0.0, disparity_step: 0.0, correlated_share: 0.0, ..noise };
        for share in [0.1, 0.9] {
            let depth = noise.min_depth + share * (noise.max_depth.min(2.0) - noise.min_depth);
            let stated = sensor.depth_error().sigma(depth);
            assert!((noise.axial_sigma(depth) / stated - 1.0).abs() < 1e-9, "{sensor}");
            let (mean, sigma) = mean_and_sigma(&reported(exact, &plane(DVec3::Z / depth)));
            assert!((sigma / stated - 1.0).abs() < 0.015, "{sensor}: {sigma} at {depth} m, stated {stated}");
            assert!((mean - depth).abs() < 0.03 * stated, "{sensor}: {mean} at {depth} m");
        }
        let depth = noise.min_depth * 1.2;
        let waves = SensorNoise { correlated_share: noise.correlated_share, ..exact };
        let images = (0..20).map(|seed| waved(waves, depth, seed));
        let errors: Vec<f64> = images.flatten().map(|told| told - depth).collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        let stated = sensor.depth_error().sigma(depth);
        assert!((rms / stated - 1.0).abs() < 0.05, "{sensor}: {rms} with waves, stated {stated}");
    }
}

/// The image of a plane with waves of this seed.
fn waved(noise: SensorNoise, depth: f64, seed: u64) -> Vec<f64> {
    let exact = plane(DVec3::Z / depth);
    let readings = Readings::new(&noise, &exact, &camera(), &mut Random::new(seed, 0));
    let waves = Waves::new(&noise, &camera(), &mut Random::new(seed, 3));
    let told = readings.reported(&noise, &exact, waves.as_ref(), &mut Random::new(seed, 1));
    told.into_iter().map(|depth| depth as f64).collect()
}

/// The correlation of errors, over 40 images, to the right and down.
#[test]
fn errors_correlate_as_stated() {
    for (share, length) in [(0.8, 7.0), (0.5, 3.0), (1.0, 12.0)] {
        let noise = SensorNoise {
            correlated_share: share,
            correlation: length,
            depth_unit: 0.0,
            disparity_step: 0.0,
            ..SensorNoise::d435i()
        };
        let images: Vec<Vec<f64>> = (0..40)
            .map(|seed| waved(noise, 0.5, seed).iter().map(|d| (d - 0.5) / noise.axial_sigma(0.5)).collect())
            .collect();
        for distance in [0, 1, 2, 3, 5, 7, 10, 14, 20] {
            for step in [1, SIZE as usize] {
                let pairs = images.iter().flat_map(|image| {
                    (0..SIZE as usize - distance)
                        .flat_map(move |a| (0..SIZE as usize).map(move |b| (a, b)))
                        .map(move |(a, b)| {
                            let at = if step == 1 { b * SIZE as usize + a } else { a * SIZE as usize + b };
                            image[at] * image[at + distance * step]
                        })
                });
                let n = 40.0 * SIZE as f64 * (SIZE as usize - distance) as f64;
                let found = pairs.sum::<f64>() / n;
                let common = share * (-(distance as f64 / length).powi(2)).exp();
                let stated = if distance == 0 { 1.0 } else { common };
                assert!(
                    (found - stated).abs() < 0.03,
                    "{share}, {length} px: {found} at {distance}, {stated}"
                );
            }
        }
    }
}

/// Sums all bells of the grid for each value, instead of the nearest along rows and then along columns.
#[test]
fn waves_are_the_sum_of_all_bells() {
    let noise = SensorNoise { correlated_share: 1.0, correlation: 6.0, ..SensorNoise::d435i() };
    let small = Intrinsics::pinhole(30, 20, DVec2::splat(60.0), DVec2::splat(9.5)).unwrap();
    let waves = Waves::new(&noise, &small, &mut Random::new(5, 0)).unwrap();
    let mut random = Random::new(5, 0);
    let (columns, rows) = (29 / 3 + 8, 19 / 3 + 8);
    let nodes: Vec<f64> = (0..columns * rows).map(|_| normal::normal(&mut random)).collect();
    let bell = |pixel: i32, node: i32| (-0.5 * (pixel as f64 / 3.0 - (node - 3) as f64).powi(2)).exp();
    for (pixel, (u, v)) in (0..20).flat_map(|v| (0..30).map(move |u| (u, v))).enumerate() {
        let grid = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
        let bells: Vec<f64> = grid.map(|(x, y)| bell(u, x) * bell(v, y)).collect();
        let norm = bells.iter().map(|bell| bell * bell).sum::<f64>().sqrt();
        let sum = bells.iter().zip(&nodes).map(|(bell, node)| bell * node).sum::<f64>() / norm;
        assert!((waves.error(pixel, 9.0) - sum).abs() < 2e-3, "{u}, {v}: {sum}");
    }
}

/// Half of the pixels next to the plate's edge, inside and outside, fly, all of them between both depths;
/// none fly elsewhere.
#[test]
fn flying_pixels_are_between_both_surfaces() {
    let noise = SensorNoise {
        lateral_sigma: 0.0,
        error: DepthNoise::default(),
        depth_unit: 0.0,
        ..SensorNoise::of(Sensor::AzureKinect)
    };
    let noise = SensorNoise { min_depth: 0.1, ..noise };
    let exact = plate_before_wall();
    let (mut n_flying, mut sum) = (0, 0.0);
    for seed in 0..20 {
        let readings = Readings::new(&noise, &exact, &camera(), &mut Random::new(seed, 0));
        let readings = readings.with_flying(&noise, &exact, SIZE, &mut Random::new(seed, 4));
        let told = readings.reported(&noise, &exact, None, &mut Random::new(seed, 1));
        let measured = readings.truly_measured(&exact);
        let shown = readings.shown(&exact);
        for pixel in 0..told.len() {
            let (u, v) = (pixel % 200, pixel / 200);
            let ring = |low, high| (low..high).contains(&u) && (low..high).contains(&v);
            let inner = ring(80, 120) && !ring(81, 119);
            let outer =
                ring(79, 121) && !ring(80, 120) && !([79, 120].contains(&u) && [79, 120].contains(&v));
            if told[pixel] == exact[pixel] {
                assert_eq!((measured[pixel], shown[pixel]), (exact[pixel], exact[pixel]));
                continue;
            }
            assert!((inner || outer) && told[pixel] > 0.4 && told[pixel] < 0.8, "{u}, {v}: {}", told[pixel]);
            assert!(measured[pixel].is_nan() && shown[pixel] == 0.4);
            (n_flying, sum) = (n_flying + 1, sum + told[pixel] as f64);
        }
    }
    let n_at_edge = 20.0 * (4 * 39 + 4 * 40) as f64;
    assert!((n_flying as f64 / n_at_edge - 0.5).abs() < 0.02, "{n_flying} of {n_at_edge}");
    assert!((sum / n_flying as f64 - 0.6).abs() < 0.01);
}

/// A camera without a second view has no shadow, and a wall beyond its range sends no light.
#[test]
fn time_of_flight_has_no_shadow_and_sees_no_farther_than_its_range() {
    let noise = SensorNoise { lateral_sigma: 0.0, ..SensorNoise::of(Sensor::L515) };
    let exact = plate_before_wall();
    assert!(loss::probabilities(&noise, &exact, &camera()).iter().all(|loss| *loss == 0.0));
    let near = SensorNoise { max_depth: 0.5, ..noise };
    let readings = Readings::new(&near, &exact, &camera(), &mut Random::new(1, 0));
    let readings = readings.with_flying(&near, &exact, SIZE, &mut Random::new(1, 4));
    let told = readings.reported(&near, &exact, None, &mut Random::new(1, 1));
    assert_eq!(told.iter().filter(|depth| !depth.is_nan()).count(), 1600);
    assert!(told.iter().all(|depth| depth.is_nan() || (*depth - 0.4).abs() < 0.02));
}
