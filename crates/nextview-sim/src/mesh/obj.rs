//! Wavefront OBJ: positions with colours, faces with texture coordinates, materials; everything else is
//! skipped.

use super::image::{Images, Resolve};
use super::raw::RawMesh;
use super::text::{NumberedLine, shown, statements};
use super::{Face, Material, mtl};
use crate::SimError;
use nextview::text::plain;

pub(super) fn parse(bytes: &[u8], resolve: &Resolve) -> Result<RawMesh, SimError> {
    let mut obj = Obj::default();
    for line in statements(&plain(bytes)?) {
        if line.is(b"v") {
            obj.push_vertex(&line)?;
        } else if line.is(b"f") {
            obj.push_face(&line)?;
        } else if obj.mesh.color_fault.is_none() {
            let read = match &line {
                line if line.is(b"vt") => obj.push_texture_point(line),
                line if line.is(b"mtllib") => obj.read_materials(line, resolve),
                line if line.is(b"usemtl") => obj.use_material(line),
                _ => Ok(()),
            };
            obj.mesh.colors_or_fault(read);
        }
    }
    obj.mesh.materials = obj.materials.into_iter().map(|(_, material)| material).collect();
    Ok(obj.mesh)
}

/// The part of the file read.
#[derive(Default)]
struct Obj {
    mesh: RawMesh,
    texture: Vec<[f32; 2]>,
    /// Names of the libraries that were read.
    libraries: Vec<String>,
    materials: Vec<(String, Material)>,
    images: Images,
    /// Material of the faces that follow.
    material: Option<u32>,
}

impl Obj {
    /// A position, optionally with red, green and blue, 0 to 1 (a scanners' extension).
    fn push_vertex(&mut self, line: &NumberedLine) -> Result<(), SimError> {
        if line.words().len() == 7
            && let Some(color) = self.mesh.colors_or_fault(line.unit_color(4))
        {
            self.mesh.push_colors(self.mesh.vertices.len(), [srgb_of(color)]);
        }
        self.mesh.vertices.push(line.point(1)?);
        Ok(())
    }

    fn push_face(&mut self, line: &NumberedLine) -> Result<(), SimError> {
        let words = &line.words()[1..];
        let n_vertices = self.mesh.vertices.len();
        let corners: Result<Vec<u32>, SimError> =
            words.iter().map(|word| number(line, word, 0, n_vertices, "vertex")).collect();
        let n_before = self.mesh.triangles.len();
        self.mesh.push_polygon(&corners?);
        let Some(material) = self.material.filter(|_| self.mesh.color_fault.is_none()) else { return Ok(()) };
        self.mesh.faces.resize(n_before, Face::default());
        let texture = words.iter().map(|word| self.texture_of(line, word)).collect::<Result<Vec<_>, _>>();
        let Some(texture) = self.mesh.colors_or_fault(texture) else { return Ok(()) };
        for i in 1..=self.mesh.triangles.len() - n_before {
            let texture = [texture[0], texture[i], texture[i + 1]];
            self.mesh.faces.push(Face { material: Some(material), texture });
        }
        Ok(())
    }

    /// The texture coordinates of a corner; zero if it has none and the material has no image.
    fn texture_of(&self, line: &NumberedLine, word: &[u8]) -> Result<[f32; 2], SimError> {
        let is_stated = word.split(|&byte| byte == b'/').nth(1).is_some_and(|number| !number.is_empty());
        if is_stated {
            let n = self.texture.len();
            return Ok(self.texture[number(line, word, 1, n, "texture coordinates")? as usize]);
        }
        let material = self.material.and_then(|material| self.materials.get(material as usize));
        match material {
            Some((name, Material { image: Some(_), .. })) => Err(line.error(format!(
                "the corner {:?} has no texture coordinates, expected some, such as 1/1, because material \
                 {name:?} has an image",
                shown(word)
            ))),
            _ => Ok([0.0; 2]),
        }
    }

    fn push_texture_point(&mut self, line: &NumberedLine) -> Result<(), SimError> {
        self.texture.push([line.number(1, "a texture coordinate")?, second(line)?]);
        Ok(())
    }

    /// Reads a library once, although programs write its name once per part.
    fn read_materials(&mut self, line: &NumberedLine, resolve: &Resolve) -> Result<(), SimError> {
        let name = line.rest().replace('\\', "/");
        if self.libraries.contains(&name) {
            return Ok(());
        }
        let read = resolve(&name)
            .and_then(|bytes| mtl::parse(&bytes, resolve, &mut self.images, &mut self.materials));
        read.map_err(|error| line.error(format!("{name:?}: {error}")))?;
        self.libraries.push(name);
        Ok(())
    }

    /// Sets the material; ignored without any library.
    fn use_material(&mut self, line: &NumberedLine) -> Result<(), SimError> {
        let name = line.rest();
        let found = self.materials.iter().position(|(other, _)| *other == name);
        if found.is_none() && !self.materials.is_empty() {
            let known: Vec<&str> = self.materials.iter().take(9).map(|(name, _)| name.as_str()).collect();
            return Err(
                line.error(format!("{name:?} is not a material of the libraries, which have {known:?}"))
            );
        }
        self.material = found.map(|index| index as u32);
        Ok(())
    }
}

/// The second texture coordinate; 0 if the line omits it, as for an image of one row.
fn second(line: &NumberedLine) -> Result<f32, SimError> {
    if line.words().len() < 3 { Ok(0.0) } else { line.number(2, "a texture coordinate") }
}

/// Part `part` of a corner such as `7`, `7/2`, `7/2/3` or `-1`, counted from 0. Numbers count from 1, or
/// backwards from the last one before the face.
fn number(
    line: &NumberedLine,
    word: &[u8],
    part: usize,
    n_defined: usize,
    what: &str,
) -> Result<u32, SimError> {
    let number = word.split(|&byte| byte == b'/').nth(part).unwrap_or_default();
    let stated: i64 = str::from_utf8(number)
        .ok()
        .and_then(|text| text.parse().ok())
        .ok_or_else(|| line.error(format!("{:?} is not a {what} number", shown(word))))?;
    let index = if stated > 0 { stated - 1 } else { (n_defined as i64).saturating_add(stated) };
    if stated == 0 || index < 0 || index >= n_defined as i64 {
        let plural = if what == "vertex" { "vertices" } else { what };
        let problem =
            format!("refers to {what} {stated}, but {n_defined} {plural} are defined before this face");
        return Err(line.error(problem));
    }
    u32::try_from(index).map_err(|_| line.error(format!("{what} number {stated} is too large")))
}

fn srgb_of(shares: [f32; 3]) -> [u8; 3] {
    shares.map(|share| (255.0 * share).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::image::png_bytes;
    use glam::DVec3;

    #[test]
    fn colours_materials_and_textures_are_read() {
        let file = |name: &str| match name {
            "a b.mtl" => Ok(b"newmtl red\nKd 1 0 0\nnewmtl map\nmap_Kd m.png".to_vec()),
            "m.png" => Ok(png_bytes(2, 1, png::ColorType::Rgb, &[0, 255, 0, 0, 0, 255])),
            _ => Err(SimError::NotAFile),
        };
        let text = "v 0 0 0 0 0 1\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0.25 0.5\nvt 0.75\nf 1 2 3\nmtllib a b.mtl\n\
            usemtl red\nf 1 2 3 4\nusemtl map\nf 1/1 2/-1 3/1 4/1\n";
        let (mesh, ..) = parse(text.as_bytes(), &file).unwrap().check(9).unwrap();
        let color =
            |i, corner: usize| mesh.color(i, std::array::from_fn(|k| f64::from(k == corner))).unwrap();
        assert_eq!([color(0, 0), color(0, 1)], [[0, 0, 255], [255; 3]], "no material");
        assert_eq!([color(1, 0), color(1, 1), color(2, 2)], [[0, 0, 0], [255, 0, 0], [255, 0, 0]]);
        assert_eq!([color(3, 1), color(4, 1), color(4, 2)], [[0, 0, 255], [0, 255, 0], [0, 255, 0]]);

        let again = parse(format!("{text}mtllib a b.mtl\nf 1/1 2/1 3/1").as_bytes(), &file).unwrap();
        assert!(again.color_fault.is_none() && again.materials.len() == 2);

        let error = |line: &str| {
            let raw = parse(format!("{text}{line}\nf 1 2 3\n").as_bytes(), &file).unwrap();
            assert_eq!(raw.triangles.len(), if line.starts_with('f') { 7 } else { 6 });
            let (mesh, _, fault) = raw.check(9).unwrap();
            assert_eq!(mesh.appearance(), None);
            fault.unwrap().to_string()
        };
        assert!(error("f 1 2 3").contains("line 13: the corner \"1\" has no texture coordinates"));
        assert!(error("vt x").contains("line 13: \"x\" is not a texture coordinate"));
        assert!(error("f 1/3 2/1 3/1").contains("refers to texture coordinates 3, but 2"));
        assert!(
            error("usemtl blue").contains("\"blue\" is not a material of the libraries, which have [\"red\"")
        );
        assert!(error("mtllib c.mtl").starts_with("line 13: \"c.mtl\": is not a regular file"));
        assert!(error("v 1 2 3 4 5 6").contains("a colour is 4, expected 0 to 1"));
    }

    #[test]
    fn reads_every_form_of_a_face() {
        let text = b"# cube side\nusemtl x\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 1 1 0 # corner\r\nv 0 1 0\n\
            vt 0 0\ng side\nf 1 2 3 4\nf 1/1 2/1 3/1\nf -4//1 -3//1 -1//1\nf 1 2\n";
        let mesh = parse(text, &|_| Err(SimError::NotAFile)).unwrap();
        assert_eq!(mesh.vertices[2], DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 1, 3]]);
        assert_eq!(mesh.n_too_small, 1);
    }

    #[test]
    fn a_backslash_continues_a_statement() {
        let text = b"v 0 0 0\nv 1 \\\n 0 0\nv 1 1 0 # a comment does not go on \\\nv 0 1 0\nf 1 2\\\r\n \\\n3\nf 2 3 4\\";
        let mesh = parse(text, &|_| Err(SimError::NotAFile)).unwrap();
        assert_eq!(mesh.vertices.len(), 4);
        assert_eq!(mesh.triangles, [[0, 1, 2], [1, 2, 3]]);
    }

    #[test]
    fn says_where_it_is_broken() {
        let error =
            |text: &str| parse(text.as_bytes(), &|_| Err(SimError::NotAFile)).unwrap_err().to_string();
        assert_eq!(error("v 0 0\n"), "line 1: has 3 words, expected a coordinate as word 4");
        assert_eq!(error("\nv 0 zero 0\n"), "line 2: \"zero\" is not a coordinate");
        assert_eq!(error("v 0 0 0\nf a 1 1"), "line 2: \"a\" is not a vertex number");
        for bad in ["0", "2", "-2", "9223372036854775807", "-9223372036854775808"] {
            assert!(error(&format!("v 0 0 0\nf 1 1 {bad}")).contains(bad));
        }
    }
}
