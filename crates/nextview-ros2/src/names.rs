//! Names of topics and services, as ROS 2 expands and remaps them.

/// The node's own name, and what other names are to be instead.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names {
    /// Without slashes.
    pub node: String,
    /// Begins with a slash, and ends with none unless it is one.
    pub namespace: String,
    /// From name to name, as they were given.
    pub remaps: Vec<(String, String)>,
}

impl Default for Names {
    fn default() -> Self {
        Self { node: "nextview".to_owned(), namespace: "/".to_owned(), remaps: Vec::new() }
    }
}

impl Names {
    /// The name, with its namespace, of a topic or service that the node knows as this: the first remap that
    /// fits decides.
    pub fn resolve(&self, name: &str) -> String {
        let full = self.expand(name);
        let remap = self.remaps.iter().find(|(from, _)| self.expand(from) == full);
        remap.map_or(full, |(_, to)| self.expand(to))
    }

    /// The node's name with its namespace.
    pub fn full(&self) -> String {
        self.expand(&self.node)
    }

    /// `~/x` is below the node, `x` in its namespace, and `/x` what it is.
    fn expand(&self, name: &str) -> String {
        let namespace = self.namespace.trim_end_matches('/');
        match name.strip_prefix("~/") {
            Some(rest) => format!("{namespace}/{}/{rest}", self.node),
            None if name.starts_with('/') => name.to_owned(),
            None => format!("{namespace}/{name}"),
        }
    }
}

/// Whether this may be the name of a topic: parts of letters, digits and `_`, none beginning with a digit.
pub fn is_name(name: &str) -> bool {
    let plain = name.strip_prefix("~/").or_else(|| name.strip_prefix('/')).unwrap_or(name);
    plain.split('/').all(is_part)
}

/// Whether this may be a part of a name between slashes.
pub fn is_part(part: &str) -> bool {
    let is_letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
    part.chars().all(is_letter) && part.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_expanded_and_remapped() {
        let remap = |from: &str, to: &str| (from.to_owned(), to.to_owned());
        let mut names = Names { namespace: "/cell".to_owned(), ..Names::default() };
        assert_eq!(names.full(), "/cell/nextview");
        assert_eq!(names.resolve("~/next_view"), "/cell/nextview/next_view");
        assert_eq!(
            (names.resolve("depth/image"), names.resolve("/tf")),
            ("/cell/depth/image".into(), "/tf".into())
        );
        names.remaps = vec![
            remap("depth/image", "/camera/depth/image_rect_raw"),
            remap("/cell/depth/image", "/never"),
            remap("~/next_view", "goal"),
            remap("/tf", "tf"),
        ];
        let resolved = ["depth/image", "~/next_view", "/tf", "x"].map(|name| names.resolve(name));
        assert_eq!(resolved, ["/camera/depth/image_rect_raw", "/cell/goal", "/cell/tf", "/cell/x"]);
        assert_eq!(Names::default().resolve("a"), "/a");
    }

    #[test]
    fn names_are_of_letters_digits_and_underscores() {
        assert!(["a", "/a/b_1", "~/x", "_a"].into_iter().all(is_name));
        assert!(!["", "/", "a//b", "1a", "a-b", "a/", "~x"].into_iter().any(is_name));
    }
}
