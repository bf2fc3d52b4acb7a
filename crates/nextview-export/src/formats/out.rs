/// A file of an export: its name, relative to the folder with `/`, and its content.
pub type NamedFile = (String, Vec<u8>);

/// Collects the files of an export.
#[derive(Default)]
pub(super) struct Out {
    pub files: Vec<NamedFile>,
}

impl Out {
    /// Adds a file.
    pub fn add(&mut self, name: impl Into<String>, bytes: impl Into<Vec<u8>>) {
        self.files.push((name.into(), bytes.into()));
    }

    /// Adds a JSON file.
    pub fn add_json(&mut self, name: &str, value: &serde_json::Value) {
        self.add(name, format!("{value:#}\n"));
    }
}
