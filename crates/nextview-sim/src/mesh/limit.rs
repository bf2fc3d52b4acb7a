use crate::SimError;

/// Maximum file size, bytes.
pub(super) const MAX_BYTES: u64 = 1 << 32;

/// Memory that a scan takes per vertex and per triangle, bytes, rounded up from scans of up to 2.9 million
/// triangles: the mesh in the file's unit and in metres, before the camera, and as the reference surface for
/// models; and its colours, which are stored once.
const PER_VERTEX: u64 = 83;
const PER_TRIANGLE: u64 = 182;

/// Memory that any mesh may take, bytes, even with a smaller file.
const FREE: u64 = 100_000_000;

/// Fails if a mesh takes more than 20 times the memory of its file and 100 MB. A few bytes of a file may
/// stand for any number of triangles if parts are repeated, and for one triangle each in polygons.
pub(super) fn check(n_vertices: usize, n_triangles: usize, n_bytes: u64) -> Result<(), SimError> {
    let [n_vertices, n_triangles] = [n_vertices, n_triangles].map(|n| n as u64);
    let of_triangles = PER_TRIANGLE.saturating_mul(n_triangles);
    let needed = PER_VERTEX.saturating_mul(n_vertices).saturating_add(of_triangles);
    let limit = FREE.saturating_add(n_bytes.saturating_mul(20));
    if needed <= limit {
        return Ok(());
    }
    let [needed_mb, limit_mb] = [needed, limit].map(|bytes| bytes.div_ceil(1_000_000));
    let problem = format!(
        "{n_vertices} vertices and {n_triangles} triangles in {n_bytes} bytes take {needed_mb} MB, more than \
         the limit of {limit_mb} MB, which is 100 MB and 20 times the file; repeated parts count each time, \
         so the same mesh without repetition, or a coarser one, may fit"
    );
    Err(SimError::format("mesh", problem))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_grows_with_the_file() {
        check(250_000, 350_000, 0).unwrap();
        check(1_000_000, 2_000_000, 25_000_000).unwrap();
        let error = check(33_000_000, 66_000_000, 1_200_000).unwrap_err().to_string();
        assert!(error.contains("66000000 triangles in 1200000 bytes take 14751 MB"), "{error}");
        assert!(error.contains("limit of 124 MB"), "{error}");
    }
}
