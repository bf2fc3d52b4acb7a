//! A small writer of JPEG: blocks of 8 x 8 pixels of one colour each, and no compression to speak of.

/// An image whose sides are multiples of 8, from the colour of each block by its column and row.
pub fn jpeg(width: u16, height: u16, color: impl Fn(u16, u16) -> [u8; 3]) -> Vec<u8> {
    let mut file = vec![0xff, 0xd8];
    segment(&mut file, 0xdb, &[&[0][..], &[1; 64]].concat()); // quantisation by 1
    let [[h1, h0], [w1, w0]] = [height.to_be_bytes(), width.to_be_bytes()];
    let components = [1, 0x11, 0, 2, 0x11, 0, 3, 0x11, 0]; // all of full resolution
    segment(&mut file, 0xc0, &[&[8, h1, h0, w1, w0, 3][..], &components].concat());
    // Twelve sizes of 4 bits each for the mean of a block; for all else a single bit, which says that there
    // is nothing else.
    let sizes: Vec<u8> = (0..12).collect();
    segment(&mut file, 0xc4, &[&[0x00, 0, 0, 0, 12][..], &[0; 12], &sizes].concat());
    segment(&mut file, 0xc4, &[&[0x10, 1][..], &[0; 15], &[0x00]].concat());
    segment(&mut file, 0xda, &[3, 1, 0, 2, 0, 3, 0, 0, 63, 0]);
    let mut bits = Vec::new();
    let mut before = [0; 3];
    for (y, x) in (0..height / 8).flat_map(|y| (0..width / 8).map(move |x| (y, x))) {
        let means = luma_and_chroma(color(x, y));
        for (mean, before) in means.iter().zip(&mut before) {
            write_difference(&mut bits, mean - std::mem::replace(before, *mean));
            bits.push(false);
        }
    }
    bits.resize(bits.len().next_multiple_of(8), true);
    for byte in bits.chunks(8).map(|bits| bits.iter().fold(0, |byte, bit| byte << 1 | u8::from(*bit))) {
        file.push(byte);
        file.extend((byte == 0xff).then_some(0));
    }
    file.extend([0xff, 0xd9]);
    file
}

fn segment(file: &mut Vec<u8>, marker: u8, content: &[u8]) {
    file.extend([0xff, marker]);
    file.extend((content.len() as u16 + 2).to_be_bytes());
    file.extend(content);
}

/// Eight times luma, less the middle, and the two chromas.
fn luma_and_chroma(rgb: [u8; 3]) -> [i32; 3] {
    let [r, g, b] = rgb.map(f64::from);
    let y = 0.299 * r + 0.587 * g + 0.114 * b;
    [y - 128.0, 0.564 * (b - y), 0.713 * (r - y)].map(|value| (8.0 * value).round() as i32)
}

/// The number of bits of a difference, then the bits; of a negative one, those of the next lower number.
fn write_difference(bits: &mut Vec<bool>, difference: i32) {
    let size = 32 - difference.unsigned_abs().leading_zeros();
    let value = if difference < 0 { difference - 1 } else { difference };
    bits.extend((0..4).rev().map(|i| size >> i & 1 == 1));
    bits.extend((0..size).rev().map(|i| value >> i & 1 == 1));
}
