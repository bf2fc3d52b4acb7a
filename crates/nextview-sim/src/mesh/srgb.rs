//! Conversion between image values (sRGB, IEC 61966-2-1) and linear light, which may be added and scaled.

use std::sync::LazyLock;

static LIGHT: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| to_light_of(i as f32 / 255.0)));

/// The linear light of an image colour, 0 to 1 each.
pub(crate) fn to_light(color: [u8; 3]) -> [f32; 3] {
    color.map(|value| LIGHT[value as usize])
}

/// The linear light of an image value, both 0 to 1.
pub(crate) fn to_light_of(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// The image colour of this light; values above 1 are as bright as 1.
pub(crate) fn to_color(light: [f32; 3]) -> [u8; 3] {
    light.map(|light| {
        let light = light.clamp(0.0, 1.0);
        let value = if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
        (255.0 * value).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_colour_survives_a_round_trip() {
        for value in 0..=255 {
            assert_eq!(to_color(to_light([value, 0, 255])), [value, 0, 255]);
        }
        assert_eq!(to_color([2.0, -1.0, 0.5]), [255, 0, 188]);
    }
}
