use super::look_at;
use crate::{Error, geometry::Pose, text};
use glam::{DQuat, DVec3};
use std::io::{Read, Write};

const POSITION: [&str; 3] = ["x_m", "y_m", "z_m"];
const QUATERNION: [&str; 4] = ["qx", "qy", "qz", "qw"];

/// Bytes in a line: less than this.
const MAX_LINE: usize = 1 << 16;

/// Maximum file size, bytes: half a million poses.
const MAX_BYTES: u64 = 1 << 26;

/// The columns of the numbers in a row.
struct ViewColumns {
    position: [usize; 3],
    quaternion: Option<[usize; 4]>,
}

pub(super) fn read(reader: impl Read, target: DVec3) -> Result<Vec<Pose>, Error> {
    let mut columns = None;
    let mut poses = Vec::new();
    let mut bytes = Vec::new();
    reader.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_BYTES {
        let problem = format!("the file goes on, expected at most {MAX_BYTES} bytes");
        return Err(Error::Format { place: format!("byte {MAX_BYTES}"), problem });
    }
    for (i, row) in text::utf8(bytes)?.lines().enumerate() {
        let problem = |problem: String| Error::Format { place: format!("line {}", i + 1), problem };
        if row.len() >= MAX_LINE {
            return Err(problem(format!("{MAX_LINE} bytes or more, expected the numbers of a pose")));
        }
        let row = row.trim();
        if row.is_empty() || row.starts_with('#') {
            continue;
        }
        let fields: Vec<&str> = row.split(',').map(str::trim).collect();
        if columns.is_none() {
            let is_header =
                fields.iter().any(|f| f.starts_with(char::is_alphabetic) && f.parse::<f64>().is_err());
            columns = Some(
                if is_header { ViewColumns::named(&fields) } else { ViewColumns::counted(&fields) }
                    .map_err(problem)?,
            );
            if is_header {
                continue;
            }
        }
        if let Some(columns) = &columns {
            poses.push(columns.pose(&fields, target).map_err(problem)?);
        }
    }
    Ok(poses)
}

pub(super) fn write(mut writer: impl Write, poses: &[Pose]) -> Result<(), Error> {
    writeln!(writer, "{},{}", POSITION.join(","), QUATERNION.join(","))?;
    for pose in poses {
        let (t, q) = (pose.translation(), pose.rotation());
        writeln!(writer, "{},{},{},{},{},{},{}", t.x, t.y, t.z, q.x, q.y, q.z, q.w)?;
    }
    Ok(())
}

impl ViewColumns {
    fn named(header: &[&str]) -> Result<Self, String> {
        let find = |name: &&str| {
            let found = header.iter().position(|h| h.eq_ignore_ascii_case(name));
            found.ok_or_else(|| {
                format!("the header has no column {name}; expected x_m,y_m,z_m or x_m,y_m,z_m,qx,qy,qz,qw")
            })
        };
        let [x, y, z] = POSITION.each_ref().map(find);
        let quaternion = if header.iter().any(|h| QUATERNION.iter().any(|name| h.eq_ignore_ascii_case(name)))
        {
            let [qx, qy, qz, qw] = QUATERNION.each_ref().map(find);
            Some([qx?, qy?, qz?, qw?])
        } else {
            None
        };
        Ok(Self { position: [x?, y?, z?], quaternion })
    }

    fn counted(row: &[&str]) -> Result<Self, String> {
        match row.len() {
            3 => Ok(Self { position: [0, 1, 2], quaternion: None }),
            7 => Ok(Self { position: [0, 1, 2], quaternion: Some([3, 4, 5, 6]) }),
            n => Err(format!(
                "{n} columns without a header; expected 3 (position) or 7 (position, quaternion)"
            )),
        }
    }

    /// Fails on a row that is too short, and names the missing numbers.
    fn check(&self, n_fields: usize) -> Result<(), String> {
        let quaternion = self.quaternion.into_iter().flatten().zip(QUATERNION);
        let columns = || self.position.into_iter().zip(POSITION).chain(quaternion.clone());
        let n_needed = columns().map(|(column, _)| column + 1).max().unwrap_or(0);
        let missing: Vec<&str> =
            columns().filter(|(column, _)| *column >= n_fields).map(|(_, name)| name).collect();
        match missing.as_slice() {
            [] => Ok(()),
            [one] => Err(format!("{n_fields} columns, expected at least {n_needed}: {one} is missing")),
            several => {
                let several = several.join(", ");
                Err(format!("{n_fields} columns, expected at least {n_needed}: {several} are missing"))
            }
        }
    }

    fn pose(&self, fields: &[&str], target: DVec3) -> Result<Pose, String> {
        self.check(fields.len())?;
        let number = |column: usize| {
            let text = fields[column];
            let value: f64 =
                text.parse().map_err(|_| format!("column {}: '{text}' is not a number", column + 1))?;
            value
                .is_finite()
                .then_some(value)
                .ok_or_else(|| format!("column {}: {text} is not finite", column + 1))
        };
        let [x, y, z] = self.position;
        let position = DVec3::new(number(x)?, number(y)?, number(z)?);
        match self.quaternion {
            None => look_at(position, target).map_err(|e| e.to_string()),
            Some([x, y, z, w]) => {
                let rotation = DQuat::from_xyzw(number(x)?, number(y)?, number(z)?, number(w)?);
                Pose::new(rotation, position).map_err(|e| e.to_string())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::view::{ViewSpace, generate};
    use glam::DVec3;
    use proptest::prelude::*;

    fn read(text: &str) -> Result<ViewSpace, String> {
        ViewSpace::read_csv(text.as_bytes(), DVec3::ZERO).map_err(|e| e.to_string())
    }

    #[test]
    fn what_is_written_is_read_back_to_rounding_of_the_quaternion() {
        let views = generate::shell(DVec3::ZERO, 0.1, 50, 1).unwrap();
        let mut text = Vec::new();
        views.write_csv(&mut text).unwrap();
        let back = ViewSpace::read_csv(text.as_slice(), DVec3::ZERO).unwrap();
        for (a, b) in views.poses().iter().zip(back.poses()) {
            assert_eq!(a.translation(), b.translation());
            assert!(a.rotation().dot(b.rotation()) > 1.0 - 1e-15);
        }
    }

    #[test]
    fn takes_positions_headers_comments_and_other_columns() {
        let views = read("# mine\nname,z_m,y_m,x_m\n\na, 3, 2, 1\n").unwrap();
        assert_eq!(views.pose(0).translation(), DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(read("1,2,3\n4,5,6\n").unwrap().len(), 2);
        // As spreadsheets write it.
        assert_eq!(read("\u{feff}x_m,y_m,z_m\r\n1,2,3\r\n").unwrap().len(), 1);
        assert_eq!(read("1,2,3,0,0,0,1\n").unwrap().pose(0).rotation().w, 1.0);
    }

    #[test]
    fn errors_name_the_line_and_the_remedy() {
        let long = format!("1,2,3\n1,2,3{}\n", " ".repeat(70_000));
        for (text, expected) in [
            ("1,2,3\n1,x,3\n", "line 2: column 2: 'x' is not a number"),
            ("1,2,3\n1,2\n", "line 2: 2 columns, expected at least 3: z_m is missing"),
            ("1,2,3,0,0,0,1\n1,2,3,0,0\n", "line 2: 5 columns, expected at least 7: qz, qw are missing"),
            ("1,2,3\n1,nan,3\n", "line 2: column 2: nan is not finite"),
            ("1,2\n", "line 1: 2 columns without a header"),
            ("x_m,y_m\n", "line 1: the header has no column z_m"),
            ("1,2,3,0,0,0,2\n", "line 1: length of the quaternion is 2"),
            (long.as_str(), "line 2: 65536 bytes or more"),
            ("", "at least one view candidate"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(expected), "{text:?} gave {error:?}, expected {expected:?}");
        }
    }

    proptest! {
        #[test]
        fn never_panics(bytes in prop::collection::vec(any::<u8>(), 0..200), text in "[0-9,.\\-e\nqxyz_mw#]{0,80}") {
            let _ = ViewSpace::read_csv(bytes.as_slice(), DVec3::ZERO);
            let _ = read(&text);
        }
    }
}
