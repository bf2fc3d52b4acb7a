//! The colours of vertices that no photo sees.

use nextview::surface::CloudPoint;
use nextview::{Cancel, Cancelled};

/// Colour of vertices without any colour nearby.
const NONE: [f32; 3] = [128.0; 3];

/// Returns the colour of every vertex: that in the photos, or else its own, or else the mean of its
/// neighbours, which spreads in rounds.
pub(super) fn vertex_colors(
    vertices: &[CloudPoint],
    triangles: &[[u32; 3]],
    in_photos: &[Option<[f32; 3]>],
    cancel: &Cancel,
) -> Result<Vec<[f32; 3]>, Cancelled> {
    let known = |(i, vertex): (usize, &CloudPoint)| {
        let own = vertex.color.map(|color| color.map(f32::from));
        in_photos.get(i).copied().flatten().or(own)
    };
    let mut colors: Vec<Option<[f32; 3]>> = vertices.iter().enumerate().map(known).collect();
    loop {
        cancel.check()?;
        let mut sums = vec![([0.0_f32; 3], 0_u32); colors.len()];
        for triangle in triangles {
            let [a, b, c] = triangle.map(|i| i as usize);
            for (to, from) in [(a, b), (a, c), (b, a), (b, c), (c, a), (c, b)] {
                if let (None, Some(color)) = (colors[to], colors[from]) {
                    let (sum, n) = &mut sums[to];
                    (*sum, *n) = ([0, 1, 2].map(|channel| sum[channel] + color[channel]), *n + 1);
                }
            }
        }
        if sums.iter().all(|(_, n)| *n == 0) {
            return Ok(colors.into_iter().map(|color| color.unwrap_or(NONE)).collect());
        }
        for (color, (sum, n)) in colors.iter_mut().zip(sums).filter(|(_, (_, n))| *n > 0) {
            *color = Some(sum.map(|value| value / n as f32));
        }
    }
}
