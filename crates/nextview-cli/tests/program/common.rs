//! A folder to work in, and the program in it.

pub use nextview_checks::data;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A scan that takes a second or two; a test may run another one in the folder afterwards.
pub const SMALL: [&str; 8] =
    ["scan", "builtin:mug", "--candidates", "20", "--voxel-size-m", "0.01", "--out=out", "--force"];

/// The files that a scan leaves in its folder.
pub const RESULT_FILES: [&str; 11] = [
    "cloud.ply",
    "config.toml",
    "frames/",
    "map.bt",
    "map.ot",
    "mesh.ply",
    "record.json",
    "report.html",
    "steps.jsonl",
    "views.csv",
    "waypoints.csv",
];

/// A fresh folder, removed at the end unless the test fails.
pub struct Folder(PathBuf);

/// The outcome of a run of the program.
#[derive(Debug)]
pub struct Run {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Folder {
    /// The name must differ from those of all other tests of this crate.
    pub fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(env!("CARGO_PKG_NAME")).join(name);
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).unwrap()
    }

    /// The names in a folder below this one, sorted, hidden ones too; a folder's name ends in a slash.
    pub fn names(&self, name: &str) -> Vec<String> {
        let name_of = |entry: fs::DirEntry| {
            let slash = if entry.path().is_dir() { "/" } else { "" };
            entry.file_name().into_string().unwrap() + slash
        };
        let mut names: Vec<String> =
            fs::read_dir(self.path(name)).unwrap().map(|entry| name_of(entry.unwrap())).collect();
        names.sort();
        names
    }

    /// The program with this folder as the current one.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_nextview"));
        command.args(args).current_dir(&self.0).stdin(Stdio::null());
        command.env("COLUMNS", "100").env_remove("RUST_BACKTRACE");
        command
    }

    pub fn run(&self, args: &[&str]) -> Run {
        Run::of(self.command(args))
    }

    /// Runs the program, which must succeed; returns what it printed.
    pub fn ok(&self, args: &[&str]) -> String {
        let run = self.run(args);
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{args:?}");
        run.stdout
    }

    /// Runs a command that prints JSON, and must succeed; returns the JSON.
    pub fn json(&self, args: &[&str]) -> Value {
        serde_json::from_str(&self.ok(args)).unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            let _ = fs::remove_dir_all(&self.0);
        }
    }
}

impl Run {
    pub fn of(mut command: Command) -> Self {
        let output = command.output().unwrap();
        Self {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

/// The small scan with more arguments.
pub fn small<'a>(args: &[&'a str]) -> Vec<&'a str> {
    [&SMALL, args].concat()
}

/// A record without times and memory, which differ between equal runs.
pub fn timeless(mut record: Value) -> Value {
    let entries = record.as_object_mut().unwrap();
    entries.retain(|key, _| !key.ends_with("_time_ms") && key != "peak_memory_mb");
    if let Some(steps) = entries.get_mut("steps").and_then(Value::as_array_mut) {
        steps.iter_mut().for_each(|step| *step = timeless(step.take()));
    }
    record
}

/// A quantity of a record after each view; NaN if a step has none.
pub fn curve(record: &Value, key: &str) -> Vec<f64> {
    let steps = record["steps"].as_array().unwrap();
    steps.iter().map(|step| step[key].as_f64().unwrap_or(f64::NAN)).collect()
}
