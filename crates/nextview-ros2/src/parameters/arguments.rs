use super::{file, value};
use crate::names::{Names, is_name, is_part};
use nextview::text;
use toml::Value;

/// The arguments after `--ros-args`: names, and parameters in the given order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RosArguments {
    pub names: Names,
    /// A name may occur several times: the last value applies.
    pub parameters: Vec<(String, Value)>,
}

const EXPECTED: &str =
    "expected --ros-args with -r FROM:=TO, -p NAME:=VALUE, --params-file FILE, or --log-level LEVEL";

impl RosArguments {
    /// Parses the arguments, and reads the files that they name.
    ///
    /// # Errors
    /// All faults, one per line.
    pub fn parse(arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut parsed = Self::default();
        let (mut faults, mut files, mut given) = (Vec::new(), Vec::new(), Vec::new());
        let mut arguments = arguments.filter(|argument| argument != "--ros-args").take_while(|a| a != "--");
        while let Some(argument) = arguments.next() {
            let (flag, value) = match argument.split_once(":=") {
                // A remap without its flag, as in ROS 1 and still in launch files.
                Some((from, _)) if !from.starts_with('-') => ("-r".to_owned(), Some(argument)),
                _ => (argument, None),
            };
            let known = ["-r", "--remap", "-p", "--param", "--params-file", "--log-level"];
            if !known.contains(&flag.as_str()) {
                faults.push(format!("'{flag}' is not an argument, {EXPECTED}"));
                continue;
            }
            let Some(value) = value.or_else(|| arguments.next()) else {
                faults.push(format!("'{flag}' has no value, {EXPECTED}"));
                continue;
            };
            match flag.as_str() {
                "-r" | "--remap" => faults.extend(parsed.remap(&value).err()),
                "-p" | "--param" => given.push(value),
                "--params-file" => files.push(value),
                // Faults are always reported; other log settings have no effect.
                _ => (),
            }
        }
        // The node's name selects its own parameters in a file.
        for path in files {
            let bytes = std::fs::read(&path).map_err(|error| format!("cannot be read: {error}"));
            let text = bytes.and_then(|bytes| text::utf8(bytes).map_err(|error| error.to_string()));
            let added = text.and_then(|text| file::add(&text, &parsed.names, &mut parsed.parameters));
            faults.extend(added.err().map(|problem| format!("{path}: {problem}")));
        }
        for text in given {
            faults.extend(parsed.set(&text).err());
        }
        if faults.is_empty() { Ok(parsed) } else { Err(faults.join("\n")) }
    }

    fn remap(&mut self, text: &str) -> Result<(), String> {
        let (from, to) = assigned(text, "FROM:=TO")?;
        // `node:from:=to` applies only to the node of that name.
        let from = match from.split_once(':') {
            Some((node, _)) if node != self.names.node => return Ok(()),
            Some((_, from)) => from,
            None => from,
        };
        match from {
            "__node" | "__name" if is_part(to) => self.names.node = to.to_owned(),
            "__ns" if to == "/" || (to.starts_with('/') && is_name(to)) => {
                self.names.namespace = to.to_owned()
            }
            _ if !from.starts_with("__") && is_name(from) && is_name(to) => {
                self.names.remaps.push((from.to_owned(), to.to_owned()))
            }
            _ => {
                return Err(format!(
                    "'{text}' is not a remapping, expected names of letters, digits, _ and /, and for __ns \
                     one that begins with /"
                ));
            }
        }
        Ok(())
    }

    fn set(&mut self, text: &str) -> Result<(), String> {
        let (name, value) = assigned(text, "NAME:=VALUE")?;
        let name = match name.split_once(':') {
            Some((node, _)) if node != self.names.node => return Ok(()),
            Some((_, name)) => name,
            None => name,
        };
        let value = value::parse(value).map_err(|problem| format!("the parameter `{name}` {problem}"))?;
        self.parameters.push((name.to_owned(), value));
        Ok(())
    }
}

fn assigned<'a>(text: &'a str, form: &str) -> Result<(&'a str, &'a str), String> {
    text.split_once(":=").ok_or_else(|| format!("'{text}' has no :=, expected {form}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<RosArguments, String> {
        RosArguments::parse(text.split_whitespace().map(str::to_owned))
    }

    #[test]
    fn names_and_parameters_are_read() {
        let arguments = parse(
            "--ros-args -r __node:=scanner -r __ns:=/cell -r depth/image:=/camera/depth -p views:=7 \
             -p other:views:=9 --param scanner:voxel_size:=0.005 -p box_m:=[0,1.5] --log-level info a:=b",
        )
        .unwrap();
        assert_eq!(arguments.names.full(), "/cell/scanner");
        assert_eq!(arguments.names.resolve("depth/image"), "/camera/depth");
        assert_eq!(arguments.names.resolve("a"), "/cell/b");
        let given: Vec<String> =
            arguments.parameters.iter().map(|(name, value)| format!("{name}={value}")).collect();
        assert_eq!(given, ["views=7", "voxel_size=0.005", "box_m=[0, 1.5]"]);
    }

    #[test]
    fn all_faults_are_told_at_once() {
        let error = parse("--ros-args --fast -r a -p b -r __ns:=cell -p --params-file").unwrap_err();
        for expected in ["'--fast' is not an argument", "'a' has no :=", "'__ns:=cell'", "expected FROM:=TO"]
        {
            assert!(error.contains(expected), "{expected}: {error}");
        }
        assert!(parse("--params-file /nowhere.yaml").unwrap_err().contains("/nowhere.yaml: cannot be read"));
    }
}
