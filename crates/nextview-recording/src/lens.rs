//! The file `intrinsics.txt`: one line per value, name first.

use crate::RecordingError;
use crate::text::{self, TextLine};
use glam::DVec2;
use nextview::sensor::{Distortion, Intrinsics};
use std::path::Path;

/// The camera described by a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lens {
    pub intrinsics: Intrinsics,
    /// Metres per unit of the depth images.
    pub depth_unit: f64,
}

const EXPECTED: &str = "expected a line each for width, height, fx, fy, cx and cy, such as `fx 525.0`, and \
                        optionally depth_unit_m and distortion";

/// Reads the file. `depth_unit` is the default in metres if the file does not state it.
pub(crate) fn read(path: &Path, depth_unit: f64) -> Result<Lens, RecordingError> {
    let lens = text::read(path).map_err(|error| match error {
        RecordingError::Io(error) => RecordingError::Content(format!("cannot be read: {error}; {EXPECTED}")),
        error => error,
    });
    lens.and_then(|text| parse(&text, depth_unit)).map_err(|error| error.in_file(path))
}

/// Fails if the principal point lies outside the image.
pub(crate) fn checked(intrinsics: Intrinsics) -> Result<Intrinsics, RecordingError> {
    if intrinsics.contains(intrinsics.center()) {
        return Ok(intrinsics);
    }
    Err(RecordingError::Content(format!(
        "the principal point (cx, cy) is {}, expected a pixel of the image of {} x {}",
        intrinsics.center(),
        intrinsics.width(),
        intrinsics.height()
    )))
}

/// Parses a camera from a text.
pub(crate) fn parse(text: &str, depth_unit: f64) -> Result<Lens, RecordingError> {
    let fields = LensFields::new(text)?;
    let size = [fields.whole("width")?, fields.whole("height")?];
    let focal = DVec2::new(fields.number("fx")?, fields.number("fy")?);
    let center = DVec2::new(fields.number("cx")?, fields.number("cy")?);
    let intrinsics = Intrinsics::pinhole(size[0], size[1], focal, center)?;
    let depth_unit = fields.optional("depth_unit_m").map_or(Ok(depth_unit), |field| field.number())?;
    if !(depth_unit > 0.0 && depth_unit.is_finite()) {
        let problem =
            format!("depth_unit_m is {depth_unit}, expected a positive number of metres, 0.001 for mm");
        return Err(RecordingError::Content(problem));
    }
    if let Some(field) = fields.optional("invalid_depth")
        && field.number()? != 0.0
    {
        return Err(field.line.error("invalid_depth is not 0, the only value for a missing pixel here"));
    }
    let distortion =
        fields.optional("distortion").map_or(Ok(Distortion::None), |field| field.distortion())?;
    Ok(Lens { intrinsics: checked(intrinsics.with_distortion(distortion)?)?, depth_unit })
}

/// A line: its name and its values.
struct LensLine<'a> {
    line: TextLine<'a>,
    name: &'a str,
    values: Vec<&'a str>,
}

struct LensFields<'a>(Vec<LensLine<'a>>);

impl<'a> LensFields<'a> {
    const NAMES: [&'static str; 9] =
        ["width", "height", "fx", "fy", "cx", "cy", "depth_unit_m", "invalid_depth", "distortion"];

    fn new(text: &'a str) -> Result<Self, RecordingError> {
        let mut fields: Vec<LensLine> = Vec::new();
        for line in text::lines(text) {
            let mut values = line.words();
            let name = values.remove(0);
            if !Self::NAMES.contains(&name) {
                return Err(line.error(format!("'{name}' is not a known name; {EXPECTED}")));
            }
            if let Some(other) = fields.iter().find(|field| field.name == name) {
                return Err(line.error(format!("{name} is already in line {}", other.line.number)));
            }
            fields.push(LensLine { line, name, values });
        }
        Ok(Self(fields))
    }

    fn optional(&self, name: &str) -> Option<&LensLine<'a>> {
        self.0.iter().find(|field| field.name == name)
    }

    fn required(&self, name: &str) -> Result<&LensLine<'a>, RecordingError> {
        self.optional(name).ok_or_else(|| RecordingError::Content(format!("has no line {name}; {EXPECTED}")))
    }

    fn number(&self, name: &str) -> Result<f64, RecordingError> {
        self.required(name)?.number()
    }

    fn whole(&self, name: &str) -> Result<u32, RecordingError> {
        let field = self.required(name)?;
        field.line.value(name, field.only()?)
    }
}

impl LensLine<'_> {
    fn only(&self) -> Result<&str, RecordingError> {
        match self.values.as_slice() {
            [value] => Ok(value),
            values => Err(self.line.error(format!("{} values for {}, expected 1", values.len(), self.name))),
        }
    }

    fn number(&self) -> Result<f64, RecordingError> {
        self.line.value(self.name, self.only()?)
    }

    /// `distortion MODEL k1 k2 p1 p2 k3`, or `distortion none`.
    fn distortion(&self) -> Result<Distortion, RecordingError> {
        let form = "expected `distortion MODEL k1 k2 p1 p2 k3` with brown-conrady or inverse-brown-conrady, or \
                    `distortion none`";
        let refused = |problem: String| self.line.error(format!("{problem}, {form}"));
        let (&model, values) = self.values.split_first().ok_or_else(|| refused("no model".into()))?;
        let mut numbers: Vec<f64> = Vec::new();
        for value in values {
            numbers.push(self.line.value("a coefficient", value)?);
        }
        let five = <[f64; 5]>::try_from(numbers);
        match (model, five) {
            ("none", Err(none)) if none.is_empty() => Ok(Distortion::None),
            ("brown-conrady", Ok(k)) => Ok(Distortion::BrownConrady(k)),
            ("inverse-brown-conrady", Ok(k)) => Ok(Distortion::InverseBrownConrady(k)),
            _ => Err(refused(format!("the model '{model}' with {} coefficients", values.len()))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINES: &str = "# a camera\nwidth 640\nheight 480\nfx 525.5\nfy 525\ncx 319.5\ncy 239.5\n";

    fn with(line: &str) -> Result<Lens, String> {
        parse(&format!("{LINES}{line}\n"), 0.001).map_err(|error| error.to_string())
    }

    #[test]
    fn reads_lines_in_any_order() {
        let lens = with("").unwrap();
        assert_eq!(lens.intrinsics.focal(), DVec2::new(525.5, 525.0));
        assert_eq!((lens.depth_unit, lens.intrinsics.distortion()), (0.001, Distortion::None));
        assert_eq!(with("depth_unit_m 0.0002").unwrap().depth_unit, 0.0002);
        let distorted = with("distortion inverse-brown-conrady 0.1 -0.2 0.01 0.02 0.3").unwrap();
        let expected = Distortion::InverseBrownConrady([0.1, -0.2, 0.01, 0.02, 0.3]);
        assert_eq!(distorted.intrinsics.distortion(), expected);
        assert_eq!(with("distortion none\ninvalid_depth 0"), with(""));
    }

    #[test]
    fn faults_name_line_value_and_remedy() {
        for (line, expected) in [
            ("zoom 2", "line 8: 'zoom' is not a known name; expected a line each for width"),
            ("fx 1", "line 8: fx is already in line 4"),
            ("depth_unit_m -1", "depth_unit_m is -1, expected a positive"),
            ("depth_unit_m x", "line 8: depth_unit_m is 'x', expected a number"),
            ("depth_unit_m", "line 8: 0 values for depth_unit_m, expected 1"),
            ("invalid_depth 65535", "line 8: invalid_depth is not 0"),
            (
                "distortion fisheye 1 2 3 4",
                "line 8: the model 'fisheye' with 4 coefficients, expected `distortion",
            ),
            ("distortion brown-conrady 1 2 3 4", "with 4 coefficients"),
            ("distortion brown-conrady 1 2 3 4 nan", "finite coefficients"),
        ] {
            let error = with(line).unwrap_err();
            assert!(error.contains(expected), "{line}: {error}");
        }
        let changed = |from: &str, to: &str| parse(&LINES.replace(from, to), 0.001).unwrap_err().to_string();
        assert!(changed("cx 319.5", "cx 900").contains("the principal point (cx, cy) is [900, 239.5]"));
        assert!(changed("fx 525.5\n", "").contains("has no line fx"));
        assert!(changed("width 640", "width 640.5").contains("line 2: width is '640.5', expected a whole"));
        assert!(changed("fy 525", "fy 0").contains("fy is 0.0, expected a positive number of pixels"));
    }
}
