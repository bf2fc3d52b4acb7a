//! Material libraries of Wavefront OBJ: `Kd` and `map_Kd`; everything else is skipped.

use super::Material;
use super::image::{Images, Resolve};
use super::srgb;
use super::text::{NumberedLine, statements};
use crate::SimError;
use nextview::text::plain;

/// Appends the materials of a library with their names.
pub(super) fn parse(
    bytes: &[u8],
    resolve: &Resolve,
    images: &mut Images,
    materials: &mut Vec<(String, Material)>,
) -> Result<(), SimError> {
    let n_before = materials.len();
    for line in statements(&plain(bytes)?) {
        if line.is(b"newmtl") {
            materials.push((line.rest(), Material { reflectance: [1.0; 3], image: None }));
            continue;
        }
        let is_reflectance = line.is(b"Kd");
        if !is_reflectance && !line.is(b"map_Kd") {
            continue;
        }
        let material = materials[n_before..].last_mut();
        let (_, material) = material.ok_or_else(|| line.error("comes before any newmtl line"))?;
        match is_reflectance {
            true => material.reflectance = reflectance(&line)?,
            false => material.image = Some(image(&line, resolve, images)?),
        }
    }
    Ok(())
}

/// The numbers of `Kd` are display values, like an image's.
fn reflectance(line: &NumberedLine) -> Result<[f32; 3], SimError> {
    Ok(line.unit_color(1)?.map(srgb::to_light_of))
}

fn image(
    line: &NumberedLine,
    resolve: &Resolve,
    images: &mut Images,
) -> Result<nextview::sensor::ColorImage, SimError> {
    let name = line.rest().replace('\\', "/");
    if name.starts_with('-') || name.is_empty() {
        return Err(line.error(format!("{name:?} is an option or empty, expected only the name of an image")));
    }
    images.get(&name, || resolve(&name)).map_err(|error| line.error(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::super::image::png_bytes;
    use super::*;

    fn read(text: &str) -> Result<Vec<(String, Material)>, SimError> {
        let file = |name: &str| match name {
            "maps/my image.png" => Ok(png_bytes(1, 1, png::ColorType::Rgb, &[1, 2, 3])),
            _ => Err(SimError::NotAFile),
        };
        let mut materials = Vec::new();
        parse(text.as_bytes(), &file, &mut Images::default(), &mut materials)?;
        Ok(materials)
    }

    #[test]
    fn reads_colours_and_images() {
        let materials =
            read("# m\nnewmtl a b\nNs 3\nKd 1 0.5 0\nnewmtl c\nmap_Kd maps\\my image.png\n").unwrap();
        let [(first, red), (second, image)] = &materials[..] else { panic!() };
        assert_eq!((first.as_str(), second.as_str()), ("a b", "c"));
        assert_eq!(srgb::to_color(red.reflectance), [255, 128, 0]);
        assert_eq!(image.image.as_ref().unwrap().get(0, 0), [1, 2, 3]);
    }

    #[test]
    fn says_where_it_is_broken() {
        let error = |text: &str| read(text).unwrap_err().to_string();
        assert_eq!(error("Kd 1 1 1"), "line 1: comes before any newmtl line");
        assert_eq!(error("newmtl a\nKd 1 2 1"), "line 2: a colour is 2, expected 0 to 1");
        assert!(error("newmtl a\nKd 1 1").contains("line 2: has 3 words"));
        assert!(
            error("newmtl a\nmap_Kd x.png").starts_with("line 2: texture \"x.png\": is not a regular file")
        );
        assert!(error("newmtl a\nmap_Kd -s 1 1 1 x.png").contains("expected only the name of an image"));
        assert!(error("newmtl a\nmap_Kd").contains("expected only the name"));
    }
}
