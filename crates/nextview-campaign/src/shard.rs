use crate::Runs;
use nextview_scan::{Fault, ScanConfig};
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// A share of the runs of a campaign, for one of several workers: `3/64` is the third of 64.
///
/// The runs are sorted by their objects' shared data, and cut into parts of equal size. Each object is
/// prepared by one worker, except where a cut divides its runs.
///
/// ```
/// use nextview_campaign::Shard;
///
/// let shard: Shard = "3/64".parse()?;
/// assert_eq!(shard.to_string(), "3/64");
/// assert!("0/64".parse::<Shard>().is_err(), "counted from 1");
/// # Ok::<(), nextview_scan::Fault>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Counted from 1.
    number: usize,
    n_shards: usize,
}

/// Maximum number of shards of a campaign: more than any cluster has cores.
const MAX_SHARDS: usize = 1_000_000;

impl Shard {
    /// The shard of all runs.
    pub const WHOLE: Self = Self { number: 1, n_shards: 1 };

    /// Creates shard `number`, from 1, of `n_shards`.
    pub fn new(number: usize, n_shards: usize) -> Result<Self, Fault> {
        if (1..=n_shards).contains(&number) && n_shards <= MAX_SHARDS {
            return Ok(Self { number, n_shards });
        }
        let expected = "a shard number, from 1, and the number of shards, such as 3/64";
        Err(Fault::of_value("shard", format!("{number}/{n_shards}"), expected))
    }

    /// Returns its number, from 1, and the number of shards.
    pub fn parts(self) -> (usize, usize) {
        (self.number, self.n_shards)
    }

    /// The groups of runs in the shard, by their numbers; the runs of a group have a common object.
    pub(crate) fn groups(self, runs: &Runs) -> Vec<Vec<usize>> {
        let cut = |number: usize| (number as u128 * runs.len() as u128 / self.n_shards as u128) as usize;
        let share = cut(self.number - 1)..cut(self.number);
        if share.is_empty() {
            return Vec::new();
        }
        let n_of_object = runs.n_of_object();
        let objects = share.start / n_of_object..share.end.div_ceil(n_of_object);
        let of_object = |object: usize| {
            let first = object * n_of_object;
            within(grouped(runs, first..first + n_of_object), first, &share)
        };
        objects.flat_map(of_object).collect()
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.n_shards)
    }
}

impl FromStr for Shard {
    type Err = Fault;

    fn from_str(text: &str) -> Result<Self, Fault> {
        let parts =
            text.split_once('/').and_then(|(number, n)| Some((number.parse().ok()?, n.parse().ok()?)));
        match parts {
            Some((number, n_shards)) => Self::new(number, n_shards),
            None => {
                Err(Fault::of_value("shard", text, "a shard number and the number of shards, such as 3/64"))
            }
        }
    }
}

/// The runs with these numbers by their common object, in the order in which the objects first occur.
fn grouped(runs: &Runs, numbers: Range<usize>) -> Vec<Vec<usize>> {
    let mut groups: Vec<(ScanConfig, Vec<usize>)> = Vec::new();
    for (run, number) in numbers.filter_map(|number| Some((runs.get(number)?, number))) {
        let object = run.config.of_object();
        match groups.iter_mut().rev().find(|(known, _)| *known == object) {
            Some((_, group)) => group.push(number),
            None => groups.push((object, vec![number])),
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}

/// The parts of these groups, the first of which begins at this place, within a range of places.
fn within(groups: Vec<Vec<usize>>, mut place: usize, range: &Range<usize>) -> Vec<Vec<usize>> {
    let mut parts = Vec::new();
    for group in groups {
        let places = place..place + group.len();
        place = places.end;
        let part: Vec<usize> =
            group.into_iter().zip(places).filter(|(_, place)| range.contains(place)).map(|it| it.0).collect();
        if !part.is_empty() {
            parts.push(part);
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Spec;
    use std::path::Path;

    /// Three objects with separate errors for each of two seeds, so each object is prepared twice.
    fn runs() -> Runs {
        let text = "name = \"x\"\nobjects = [\"a.ply\", \"b.ply\", \"c.ply\"]\nseeds = [0, 1]\nfirst_views = 2\n\
                    [scan.noise]\nmodel = \"d435i\"\n[[variant]]\n[[variant]]\nscan.planner = \"rse\"";
        Spec::parse(text, Path::new("")).unwrap().runs().unwrap()
    }

    #[test]
    fn shards_share_all_runs_evenly_and_few_objects() {
        let runs = runs();
        assert_eq!(runs.len(), 24);
        for n_shards in [1, 2, 3, 5, 24, 40] {
            let shards = (1..=n_shards).map(|number| Shard::new(number, n_shards).unwrap().groups(&runs));
            let shards: Vec<Vec<Vec<usize>>> = shards.collect();
            let mut numbers: Vec<usize> = shards.iter().flatten().flatten().copied().collect();
            numbers.sort_unstable();
            assert!(numbers.into_iter().eq(0..24), "every run in one shard of {n_shards}");
            let sizes = shards.iter().map(|groups| groups.iter().map(Vec::len).sum::<usize>());
            assert!(sizes.clone().max().unwrap() - sizes.min().unwrap() <= 1);
            let n_looks: usize = shards.iter().map(Vec::len).sum();
            assert!(n_looks < 6 + n_shards, "{n_looks} looks at 6 objects by {n_shards}");
            let object = |number: usize| runs.get(number).unwrap().config.of_object();
            assert!(
                shards.iter().flatten().all(|group| group.iter().all(|&n| object(n) == object(group[0])))
            );
        }
    }

    #[test]
    fn a_shard_is_written_as_its_number_of_all() {
        assert_eq!("64/64".parse::<Shard>().unwrap().parts(), (64, 64));
        for text in ["", "3", "0/3", "4/3", "-1/3", "1/0", "a/b", "1/9999999"] {
            let fault = text.parse::<Shard>().unwrap_err();
            assert!(fault.message.starts_with("`shard` is ") && fault.message.contains("3/64"), "{fault}");
        }
    }
}
