//! Current problems: printed once to stderr, and listed in the status while they last.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Problems by subject.
#[derive(Default)]
pub struct Notes(BTreeMap<&'static str, Note>);

struct Note {
    problem: Option<String>,
    said: Instant,
}

/// Minimum interval between reports of problems with the same subject: images arrive 30 times a second.
const SILENCE: Duration = Duration::from_secs(10);

impl Notes {
    /// Reports a problem with this subject.
    pub fn add(&mut self, about: &'static str, problem: String) {
        let now = Instant::now();
        match self.0.get_mut(about) {
            Some(note) => {
                let is_old = note.problem.is_some() || now.duration_since(note.said) < SILENCE;
                if !is_old
                    || (note.problem.as_ref() != Some(&problem) && now.duration_since(note.said) >= SILENCE)
                {
                    say(about, &problem);
                    note.said = now;
                }
                note.problem = Some(problem);
            }
            None => {
                say(about, &problem);
                self.0.insert(about, Note { problem: Some(problem), said: now });
            }
        }
    }

    /// Clears the problem with this subject, if any.
    pub fn clear(&mut self, about: &str) {
        if let Some(note) = self.0.get_mut(about) {
            note.problem = None;
        }
    }

    /// The problems, by subject.
    pub fn problems(&self) -> BTreeMap<&'static str, &str> {
        self.0.iter().filter_map(|(about, note)| Some((*about, note.problem.as_deref()?))).collect()
    }
}

/// Prints a line to stderr.
pub fn say(about: &str, text: &str) {
    eprintln!("{about}: {text}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_lasts_until_it_is_cleared() {
        let mut notes = Notes::default();
        for i in 0..100 {
            notes.add("depth/image", format!("problem {i}"));
        }
        notes.add("pose", "none".to_owned());
        let problems = notes.problems();
        assert_eq!((problems.len(), problems["depth/image"]), (2, "problem 99"));
        notes.clear("depth/image");
        notes.clear("never");
        assert_eq!(notes.problems().into_keys().collect::<Vec<_>>(), ["pose"]);
    }
}
