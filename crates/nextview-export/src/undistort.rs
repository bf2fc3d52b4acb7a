use glam::DVec2;
use nextview::sensor::{ColorImage, Depth, DepthImage, Distortion, Frame, Intrinsics};
use nextview_scan::Fault;

/// The same optics without distortion.
pub(crate) fn ideal(intrinsics: &Intrinsics) -> Result<Intrinsics, Fault> {
    Ok(intrinsics.with_distortion(Distortion::None)?)
}

/// The image of a camera without distortion: few tools support all lens models. Depths are those of the
/// nearest pixels, since blends would lie between surfaces; colours are blended from four pixels.
pub(crate) fn undistorted(
    frame: Frame,
    color: Option<ColorImage>,
) -> Result<(Frame, Option<ColorImage>), Fault> {
    let lens = *frame.intrinsics();
    if lens.distortion() == Distortion::None {
        return Ok((frame, color));
    }
    let ideal = ideal(&lens)?;
    let (width, height) = (lens.width(), lens.height());
    let places: Vec<Option<DVec2>> = (0..height)
        .flat_map(|v| (0..width).map(move |u| DVec2::new(f64::from(u), f64::from(v))))
        .map(|pixel| lens.project(ideal.deproject(pixel)?.extend(1.0)).filter(|place| lens.contains(*place)))
        .collect();
    let depth =
        places.iter().map(|place| place.map_or(Depth::Missing, |p| nearest(frame.image(), p)).metres());
    let image = DepthImage::from_metres(width, height, depth.collect())?;
    let color = color.map(|color| {
        let pixels = places.iter().map(|place| place.map_or([0; 3], |place| blended(&color, place)));
        ColorImage::new(width, height, pixels.collect())
    });
    let (pose, range) = (frame.world_from_camera(), frame.range());
    Ok((Frame::new(image, ideal, pose, range)?, color.transpose()?))
}

fn nearest(image: &DepthImage, place: DVec2) -> Depth {
    let clamp = |x: f64, n: u32| (x.round().max(0.0) as u32).min(n - 1);
    image.get(clamp(place.x, image.width()), clamp(place.y, image.height()))
}

fn blended(image: &ColorImage, place: DVec2) -> [u8; 3] {
    let last = DVec2::new(f64::from(image.width() - 1), f64::from(image.height() - 1));
    let place = place.clamp(DVec2::ZERO, last);
    let low = place.floor();
    let high = (low + 1.0).min(last);
    let t = place - low;
    let at = |x: f64, y: f64| image.get(x as u32, y as u32).map(f64::from);
    let corners = [at(low.x, low.y), at(high.x, low.y), at(low.x, high.y), at(high.x, high.y)];
    let weights = [(1.0 - t.x) * (1.0 - t.y), t.x * (1.0 - t.y), (1.0 - t.x) * t.y, t.x * t.y];
    std::array::from_fn(|i| corners.iter().zip(weights).map(|(c, w)| c[i] * w).sum::<f64>().round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::geometry::Pose;

    #[test]
    fn a_straight_edge_becomes_straight() {
        let distortion = Distortion::BrownConrady([0.2, 0.1, 0.001, -0.002, 0.0]);
        let ideal = Intrinsics::pinhole(80, 60, DVec2::splat(70.0), DVec2::new(39.5, 29.5)).unwrap();
        let lens = ideal.with_distortion(distortion).unwrap();
        // A wall whose depth and colour change along x, seen through the lens.
        let wall = |pixel: DVec2, camera: &Intrinsics| {
            let ray = camera.deproject(pixel).unwrap();
            1.0 / (1.0 + 0.5 * ray.x)
        };
        let pixels = || (0..60).flat_map(|v| (0..80).map(move |u| DVec2::new(f64::from(u), f64::from(v))));
        let depth: Vec<f32> = pixels().map(|pixel| wall(pixel, &lens) as f32).collect();
        let shade = |depth: f64| (100.0 * depth) as u8;
        let color = pixels().map(|pixel| [shade(wall(pixel, &lens)), 7, 9]).collect();
        let color = ColorImage::new(80, 60, color).unwrap();
        let image = DepthImage::from_metres(80, 60, depth).unwrap();
        let frame = Frame::new(image, lens, Pose::IDENTITY, 5.0).unwrap();

        let (straight, color) = undistorted(frame, Some(color)).unwrap();
        assert_eq!(straight.intrinsics(), &ideal);
        let mut n_compared = 0;
        for pixel in pixels() {
            let (u, v) = (pixel.x as u32, pixel.y as u32);
            let Depth::Surface(depth) = straight.image().get(u, v) else { continue };
            let expected = wall(pixel, &ideal);
            // Half a pixel times the slope.
            assert!((f64::from(depth) - expected).abs() < 0.01, "{pixel}: {depth} {expected}");
            let shown = color.as_ref().unwrap().get(u, v);
            assert!(shown[0].abs_diff(shade(expected)) <= 2 && shown[1..] == [7, 9], "{pixel}");
            n_compared += 1;
        }
        assert!(n_compared > 4000, "{n_compared}");
    }
}
