use super::tangent_plane::TangentPlanes;
use crate::Error;
use crate::geometry::Aabb;
use crate::sensor::{ColorImage, Frame};
use glam::DVec3;

/// A surface point with its normal and colour, if known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudPoint {
    /// Metres.
    pub position: DVec3,
    /// Of unit length, towards the side from which the surface was seen.
    pub normal: Option<DVec3>,
    /// Red, green and blue, 0 to 255.
    pub color: Option<[u8; 3]>,
    /// Expected error along the normal, standard deviation in metres.
    pub error: Option<f32>,
}

impl From<DVec3> for CloudPoint {
    /// Returns a point with only a position.
    fn from(position: DVec3) -> Self {
        Self { position, normal: None, color: None, error: None }
    }
}

/// Returns the measured points of a frame inside the box (finite, world coordinates), row by row: those of
/// [`Frame::points_in`], with normals, and with colours if there is a colour image.
///
/// The normal is from the plane through the pixel and its neighbours, using on each axis the one whose depth
/// differs less. Pixels without measured neighbours have none, nor do pixels whose surface is seen at less
/// than 12 degrees: the depth error would dominate the normal. Fails if the colour image has another size.
///
/// The points are computed lazily: those of a large image would take twice the memory of everything else.
///
/// ```
/// use glam::{DVec2, DVec3};
/// use nextview::geometry::{Aabb, Pose};
/// use nextview::surface::frame_points;
/// use nextview::sensor::{ColorImage, DepthImage, Frame, Intrinsics};
///
/// // A red wall at 0.5 m, seen from the front.
/// let camera = Intrinsics::pinhole(64, 48, DVec2::splat(60.0), DVec2::new(31.5, 23.5)).unwrap();
/// let image = DepthImage::from_metres(64, 48, vec![0.5; 64 * 48]).unwrap();
/// let frame = Frame::new(image, camera, Pose::IDENTITY, 1.0).unwrap();
/// let color = ColorImage::new(64, 48, vec![[255, 0, 0]; 64 * 48]).unwrap();
///
/// let points = frame_points(&frame, Some(color), Aabb::cube(DVec3::ZERO, 1.0)).unwrap();
/// let points: Vec<_> = points.collect();
/// assert_eq!(points.len(), 64 * 48);
/// assert!(points.iter().all(|point| point.normal.unwrap().distance(-DVec3::Z) < 1e-6));
/// assert!(points.iter().all(|point| point.color == Some([255, 0, 0])));
/// ```
pub fn frame_points(
    frame: &Frame,
    color: Option<ColorImage>,
    bounds: Aabb,
) -> Result<impl Iterator<Item = CloudPoint>, Error> {
    color.as_ref().map_or(Ok(()), |color| color.check_fits(frame.image()))?;
    let (width, planes) = (frame.image().width(), TangentPlanes::new(frame));
    let rotation = frame.world_from_camera().rotation_matrix();
    let rows = 0..frame.image().height();
    let pixels = rows.flat_map(move |v| frame.row_pixels_in(v, bounds).map(move |(u, point)| (u, v, point)));
    let point = move |(u, v, position)| CloudPoint {
        position,
        normal: planes.at((v * width + u) as usize).map(|plane| rotation * plane.normal.as_dvec3()),
        color: color.as_ref().map(|color| color.get(u, v)),
        error: None,
    };
    Ok(pixels.map(point))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::synthetic::ball;
    use crate::view::look_at;

    use glam::DVec2;

    #[test]
    fn normals_of_a_ball_are_radial_and_face_the_camera() {
        let camera_position = DVec3::new(0.3, -0.2, 0.3);
        let frame = ball(look_at(camera_position, DVec3::ZERO).unwrap(), 0.1);
        let bounds = Aabb::cube(DVec3::ZERO, 0.2);
        let points: Vec<CloudPoint> = frame_points(&frame, None, bounds).unwrap().collect();
        let positions: Vec<DVec3> = points.iter().map(|point| point.position).collect();
        assert_eq!(positions, frame.points_in(bounds).collect::<Vec<_>>());
        let with_normal: Vec<(DVec3, DVec3)> =
            points.iter().filter_map(|point| Some((point.position, point.normal?))).collect();
        assert!(with_normal.len() as f64 > 0.9 * points.len() as f64 && points.len() > 2000);
        for (position, normal) in with_normal {
            assert!((normal.length() - 1.0).abs() < 1e-6 && normal.dot(camera_position - position) > 0.0);
            // A pixel is up to 2.2 mm wide, five times that along the flattest surface: 7 degrees of the ball
            // to one side.
            assert!(normal.dot(position.normalize()) > 0.99, "{position} {normal}");
        }
    }

    #[test]
    fn colours_are_those_of_the_pixels() {
        let frame = ball(look_at(DVec3::Z * 0.4, DVec3::ZERO).unwrap(), 0.1);
        let pixels = (0..160 * 120).map(|i| [(i % 160) as u8, (i / 160) as u8, 7]).collect();
        let color = ColorImage::new(160, 120, pixels).unwrap();
        for point in frame_points(&frame, Some(color), Aabb::cube(DVec3::ZERO, 0.2)).unwrap() {
            let in_camera = frame.world_from_camera().inverse().transform_point(point.position);
            let shown = frame.intrinsics().project(in_camera).unwrap();
            let [u, v, blue] = point.color.unwrap();
            assert!(shown.distance(DVec2::new(u as f64, v as f64)) < 1e-3 && blue == 7, "{shown}");
        }
        let small = ColorImage::new(80, 60, vec![[0; 3]; 80 * 60]).unwrap();
        let refused = frame_points(&frame, Some(small), Aabb::cube(DVec3::ZERO, 0.2)).err().unwrap();
        assert_eq!(
            refused.to_string(),
            "colour image is 80 x 60 pixels, expected the size of the depth image"
        );
    }
}
