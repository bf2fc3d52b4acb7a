//! Names of topics and services, expanded and remapped as in ROS 2.

/// The node's own name, and the remaps of other names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names {
    /// Without slashes.
    pub node: String,
    /// Begins with a slash, and does not end with one unless it is `/`.
    pub namespace: String,
    /// Pairs of a name and its replacement, as given.
    pub remaps: Vec<(String, String)>,
}

impl Default for Names {
    fn default() -> Self {
        Self { node: "nextview".to_owned(), namespace: "/".to_owned(), remaps: Vec::new() }
    }
}

impl Names {
    /// Returns the full name of a topic or service that the node knows by this name: the first matching remap
    /// applies.
    pub fn resolve(&self, name: &str) -> String {
        let full = self.expand(name);
        let remap = self.remaps.iter().find(|(from, _)| self.expand(from) == full);
        remap.map_or(full, |(_, to)| self.expand(to))
    }

    /// The node's name with its namespace.
    pub fn full(&self) -> String {
        self.expand(&self.node)
    }

    /// `~/x` is relative to the node, `x` to its namespace, and `/x` is absolute.
    fn expand(&self, name: &str) -> String {
        let namespace = self.namespace.trim_end_matches('/');
        match name.strip_prefix("~/") {
            Some(rest) => format!("{namespace}/{}/{rest}", self.node),
            None if name.starts_with('/') => name.to_owned(),
            None => format!("{namespace}/{name}"),
        }
    }
}

/// Whether this is a valid topic name: parts of letters, digits and `_`, none beginning with a digit.
pub fn is_name(name: &str) -> bool {
    let plain = name.strip_prefix("~/").or_else(|| name.strip_prefix('/')).unwrap_or(name);
    plain.split('/').all(is_part)
}

/// Whether this is a valid part of a name between slashes.
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
