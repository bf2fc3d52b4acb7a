//! Reads the points of the PLY files that scans write.

/// Position, normal and colour of each vertex, as far as the file has them.
pub struct Vertices {
    pub columns: Vec<String>,
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub colors: Vec<[u8; 3]>,
}

impl Vertices {
    pub fn read(bytes: &[u8]) -> Self {
        let end = b"end_header\n";
        let start = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
        let header = std::str::from_utf8(&bytes[..start]).unwrap();
        let (vertex, _) = header.split_once("element face").unwrap_or((header, ""));
        let n: usize =
            vertex.split("element vertex ").nth(1).unwrap().lines().next().unwrap().parse().unwrap();
        let properties = || vertex.lines().filter_map(|line| line.strip_prefix("property "));
        let columns: Vec<String> = properties().map(|p| p.split(' ').nth(1).unwrap().to_owned()).collect();
        let size = |property: &str| if property.starts_with("float") { 4 } else { 1 };
        let stride: usize = properties().map(size).sum();
        let rows = bytes[start..].chunks_exact(stride).take(n);
        let has = |column: &str| columns.iter().any(|c| c == column);
        let vector = |row: &[u8], at: usize| {
            [0, 4, 8].map(|i| f32::from_le_bytes(row[at + i..at + i + 4].try_into().unwrap()))
        };
        let positions: Vec<[f32; 3]> = rows.clone().map(|row| vector(row, 0)).collect();
        assert_eq!(positions.len(), n);
        let normals = if has("nx") { rows.clone().map(|row| vector(row, 12)).collect() } else { Vec::new() };
        let color = |row: &[u8]| row[stride - 3..].try_into().unwrap();
        let colors = if has("red") { rows.map(color).collect() } else { Vec::new() };
        Self { columns, positions, normals, colors }
    }
}
