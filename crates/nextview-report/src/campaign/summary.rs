//! The tables of the coverage and cost of every variant, and of the differences between variants.

use super::data_file::DataFile;
use super::document::{Block, Cell, Column, Row, Section, Table};
use super::statistic::{NOT_MEASURED, dash, with_median, with_test};
use nextview_campaign::statistics::measure::{
    ACCURACY, AREA_OVER_TIME, AREA_OVER_VIEWS, CHAMFER, COMPLETENESS, COVERAGE_BEYOND_RANDOM, F_SCORE_1MM,
    F_SCORE_2MM, F_SCORE_5MM, MAP_IOU, MAP_PRECISION, MAP_RECALL, MEMORY, PATH, PLAN_TIME,
    REACHABLE_COVERAGE, SKILL, SURFACE_2MM, SURFACE_5MM, VIEWS_TO_95, VOXEL_COVERAGE,
};
use nextview_campaign::statistics::{Interval, Measure, SignedRank, Study, StudyVariant, mean, percentile};
use rayon::prelude::*;

/// Shares of the reachable object voxels for which views are counted.
const LEVELS: [f64; 3] = [0.9, 0.95, 0.99];

/// The measures after the last view; measures that no run has are left out.
const REACHED: [Measure; 7] =
    [VOXEL_COVERAGE, REACHABLE_COVERAGE, SKILL, SURFACE_2MM, SURFACE_5MM, ACCURACY, COMPLETENESS];

/// The measures of map and model, and of early coverage.
const HAS: [Measure; 9] = [
    MAP_PRECISION,
    MAP_RECALL,
    MAP_IOU,
    F_SCORE_1MM,
    F_SCORE_2MM,
    F_SCORE_5MM,
    CHAMFER,
    AREA_OVER_VIEWS,
    AREA_OVER_TIME,
];

/// The section.
pub(crate) fn section(study: &Study) -> Section {
    let method = "Every number is first averaged over the runs of one object (seeds, candidates, first views), \
                  then over objects. Ranges are 95 % intervals of the mean from a bootstrap on two levels, \
                  objects and the runs of each, with 10 000 resamples and a fixed seed; with fewer than \
                  about ten objects they are too narrow. Differences are paired by object; p is from \
                  Wilcoxon's signed-rank test over objects, two-sided, not corrected for the number of \
                  comparisons.";
    let mut blocks = vec![reached(study)];
    blocks.extend(has(study));
    blocks.extend([worst(study), views(study), costs(study), against(study)]);
    let mut texts = vec![method];
    if study.variants.iter().any(|variant| variant.n_objects() != study.variants[0].n_objects()) {
        texts.push(
            "The variants do not have the same objects, because runs failed or are not yet done: only the \
             paired differences compare like with like.",
        );
    }
    let texts = texts.into_iter().map(|text| Block::Text(text.to_owned()));
    Section {
        title: "Summary".to_owned(),
        blocks: texts.chain(blocks.into_iter().map(Block::Table)).collect(),
    }
}

/// A row per variant, computed by all threads: intervals of many runs take seconds.
fn table(
    study: &Study,
    caption: &str,
    head: &[&str],
    cells: impl Fn(&StudyVariant) -> Vec<Cell> + Sync,
) -> Table {
    let row = |variant: &StudyVariant| {
        Row::new(std::iter::once(variant.name.as_str().into()).chain(cells(variant)).collect())
    };
    Table {
        caption: caption.to_owned(),
        head: std::iter::once(Column::text("variant"))
            .chain(head.iter().map(|&name| Column::number(name)))
            .collect(),
        rows: study.variants.par_iter().map(row).collect(),
    }
}

fn reached(study: &Study) -> Table {
    let measures: Vec<Measure> = measured(study, &REACHED);
    let head: Vec<&str> =
        std::iter::once("objects").chain(measures.iter().map(|measure| measure.name)).collect();
    table(study, "Results after the last view: mean, its interval, median", &head, |variant| {
        let n_objects = Cell::from(variant.n_objects().to_string());
        let measures = measures.iter().map(|measure| of_measure(variant, measure));
        std::iter::once(n_objects).chain(measures).collect()
    })
}

/// The measure of a variant, also for the file of statistics.
fn of_measure(variant: &StudyVariant, measure: &Measure) -> Cell {
    let cell = with_median(&variant.sample(measure), measure);
    cell.in_row(DataFile::Statistics, [&variant.name, measure.name])
}

/// The measures of map and model; `None` if no run has any of them.
fn has(study: &Study) -> Option<Table> {
    let measures = measured(study, &HAS);
    let head: Vec<&str> = measures.iter().map(|measure| measure.name).collect();
    let caption = "Final map and cloud, and how early coverage was reached (docs/measures.md)";
    (!measures.is_empty()).then(|| {
        table(study, caption, &head, |variant| {
            measures.iter().map(|measure| of_measure(variant, measure)).collect()
        })
    })
}

/// The worst object of every variant for every measure.
fn worst(study: &Study) -> Table {
    let measures = measured(study, &[&REACHED[..], &[VIEWS_TO_95, PATH]].concat());
    let head: Vec<&str> = measures.iter().map(|measure| measure.name).collect();
    table(study, "The worst object", &head, |variant| {
        let cell = |measure: &Measure| match variant.worst(measure) {
            Some((object, value)) => {
                let (value, object) = (measure.show(value), study.objects[object].name.as_str());
                let values = [("worst", value.clone()), ("worst_object", object.to_owned())];
                let cell = Cell::with_note(value, object).with_values(values);
                cell.in_row(DataFile::Statistics, [&variant.name, measure.name])
            }
            None => dash(NOT_MEASURED),
        };
        measures.iter().map(cell).collect()
    })
}

/// The measures that any variant has.
fn measured(study: &Study, measures: &[Measure]) -> Vec<Measure> {
    let is_measured =
        |measure: &&Measure| study.variants.iter().any(|variant| variant.mean(measure).is_some());
    measures.iter().filter(is_measured).copied().collect()
}

fn views(study: &Study) -> Table {
    let head = LEVELS.map(|level| format!("{} %", (100.0 * level).round()));
    let caption = "Views until this share of the reachable object voxels was seen; a run that did not reach \
                   it counts as one view more than its maximum, and the mean is marked ≥";
    let head = head.each_ref().map(String::as_str);
    table(study, caption, &head, |variant| LEVELS.map(|level| views_to(variant, level)).to_vec())
}

fn views_to(variant: &StudyVariant, level: f64) -> Cell {
    let sample = variant.sample_by(|run| run.views_to(level));
    if sample.n_objects() == 0 {
        return dash("no baselines");
    }
    let known = variant.runs.iter().filter(|runs| runs.iter().any(|run| run.views_to(level).is_some()));
    let n_reaching = known.filter(|runs| runs.iter().all(|run| run.reaches(level))).count();
    let bound = if n_reaching < sample.n_objects() { "≥ " } else { "" };
    let cell = with_median(&sample, &VIEWS_TO_95);
    let note = [cell.note, format!("{n_reaching} of {} objects", sample.n_objects())];
    let note: Vec<String> = note.into_iter().filter(|part| !part.is_empty()).collect();
    let name = format!("views to {} %", (100.0 * level).round());
    Cell::with_note(format!("{bound}{}", cell.text), note.join(", "))
        .with_values(cell.values)
        .with_values([("n_reaching", n_reaching.to_string())])
        .in_row(DataFile::Statistics, [&variant.name, &name])
}

fn costs(study: &Study) -> Table {
    let head = [PATH.name, "planning time per view, median, ms", "95th percentile, ms", MEMORY.name];
    table(study, "Costs", &head, |variant| {
        let times: Vec<f64> = variant.measured().flat_map(|run| run.plan_times()).collect();
        let time = |share, name: &str| match percentile(&times, share) {
            Some(time) => {
                let (time, name) = (PLAN_TIME.show(time), format!("planning time per view, {name}, ms"));
                let cell = Cell::from(time.clone()).with_values([("value", time)]);
                cell.in_row(DataFile::Statistics, [&variant.name, &name])
            }
            None => dash("no view was planned"),
        };
        let times = [time(0.5, "median"), time(0.95, "95th percentile")];
        let [path, memory] = [PATH, MEMORY].map(|measure| of_measure(variant, &measure));
        std::iter::once(path).chain(times).chain([memory]).collect()
    })
}

/// Differences of each variant from random views, from a variant of random views, and from its best rivals.
fn against(study: &Study) -> Table {
    let random = study.variants.iter().find(|variant| variant.planner.properties().is_random);
    let mut head = vec!["reachable coverage beyond random views, points"];
    if random.is_some() {
        head.push("voxel coverage beyond the random variant, points");
    }
    head.extend(["voxel coverage beyond the best other, points", "skill beyond the best other"]);
    let head: Vec<&str> = head.into_iter().flat_map(|name| [name, "objects better / worse / tied"]).collect();
    let caption = "Paired differences: mean, its interval, median, p and number of objects; the best other \
                   excludes the clairvoyant planner";
    table(study, caption, &head, |variant| {
        let own = variant.sample(&COVERAGE_BEYOND_RANDOM);
        let (interval, test) = (own.interval(), own.signed_rank());
        let [own, counts] = differences(&VOXEL_COVERAGE, &own.object_means(), interval, test, "");
        let key = [variant.name.as_str(), &in_points(&REACHABLE_COVERAGE), "random views"];
        let mut cells = vec![own.in_row(DataFile::Differences, key), counts];
        if random.is_some() {
            let random = random.filter(|random| random.name != variant.name);
            cells.extend(beyond(variant, random, &VOXEL_COVERAGE, ""));
        }
        for measure in [VOXEL_COVERAGE, SKILL] {
            let other = best_other(study, variant, &measure);
            cells.extend(beyond(variant, other, &measure, other.map_or("", |other| &other.name)));
        }
        cells
    })
}

/// The variant with the largest mean, except this one and the clairvoyant.
fn best_other<'s>(study: &'s Study, variant: &StudyVariant, measure: &Measure) -> Option<&'s StudyVariant> {
    let rivals = study
        .variants
        .iter()
        .filter(|other| other.name != variant.name && !other.planner.properties().needs_truth);
    let with_mean = rivals.filter_map(|other| Some((other, other.mean(measure)?)));
    // The first if several are equal.
    Some(with_mean.rev().max_by(|a, b| a.1.total_cmp(&b.1))?.0)
}

/// The differences between a variant and another one, if there is one; a non-empty name appears in the note.
fn beyond(variant: &StudyVariant, other: Option<&StudyVariant>, measure: &Measure, name: &str) -> [Cell; 2] {
    let Some(other) = other else { return [dash("nothing to compare with"), Cell::default()] };
    let pairs = other.beside(variant, measure);
    let (values, interval, test) = (pairs.differences(), pairs.interval(), pairs.signed_rank());
    let [cell, counts] = differences(measure, &values, interval, test, name);
    let key = [variant.name.as_str(), &in_points(measure), &other.name];
    [cell.in_row(DataFile::Differences, key), counts]
}

/// The name of a measure with the unit of its differences.
fn in_points(measure: &Measure) -> String {
    let points = measure.difference_unit().map(|unit| format!(", {unit}"));
    format!("{}{}", measure.name.trim_end_matches(", %"), points.unwrap_or_default())
}

/// The mean difference with its statistics, and the numbers of objects on which it is better, worse and tied.
fn differences(
    measure: &Measure,
    differences: &[f64],
    interval: Option<Interval>,
    test: Option<SignedRank>,
    other: &str,
) -> [Cell; 2] {
    let (Some(mean), Some(test)) = (mean(differences), test) else {
        return [dash(NOT_MEASURED), Cell::default()];
    };
    let median = percentile(differences, 0.5).unwrap_or_default();
    let mut cell = with_test(measure, mean, median, interval, test);
    if !other.is_empty() {
        cell.note += &format!(", against {other}");
    }
    // A twentieth of the last digit of a value.
    let tie = 0.05 * 0.1_f64.powi(measure.decimals as i32) / measure.factor;
    let count = |f: &dyn Fn(f64) -> bool| differences.iter().filter(|&&d| f(d)).count();
    let (better, worse) = (count(&|d| d > tie), count(&|d| d < -tie));
    let tied = differences.len() - better - worse;
    let counts =
        [("better", better), ("worse", worse), ("tied", tied)].map(|(name, n)| (name, n.to_string()));
    [cell.with_values(counts), format!("{better} / {worse} / {tied}").into()]
}
