//! The tables of the coverage and cost of every variant, and of the differences between variants.

use super::document::{Block, Cell, Column, Row, Section, Table};
use nextview_campaign::statistics::measure::{
    ACCURACY, AREA_OVER_TIME, AREA_OVER_VIEWS, CHAMFER, COMPLETENESS, COVERAGE_BEYOND_RANDOM, F_SCORE_1MM,
    F_SCORE_2MM, F_SCORE_5MM, MAP_IOU, MAP_PRECISION, MAP_RECALL, MEMORY, PATH, PLAN_TIME,
    REACHABLE_COVERAGE, SKILL, SURFACE_2MM, SURFACE_5MM, VOXEL_COVERAGE,
};
use nextview_campaign::statistics::{
    Interval, Measure, MeasuredRun, Study, StudyVariant, differences, mean, percentile,
};
use nextview_scan::PlannerName;

/// The shares of the reachable object voxels whose views are counted.
const LEVELS: [f64; 3] = [0.9, 0.95, 0.99];

/// Differences of less than this share are a draw: a twentieth of the last digit shown.
const DRAW: f64 = 5e-5;

/// The section.
pub(crate) fn section(study: &Study<'_>) -> Section {
    let method = "Every number is first averaged over the runs of one object (seeds, first views), then \
                  over objects. Ranges are 95 % intervals by a bootstrap over objects with 10 000 resamples \
                  and a fixed seed; with fewer than about ten objects they are too narrow. Differences are \
                  paired by object.";
    let mut blocks = vec![reached(study)];
    blocks.extend(has(study));
    blocks.extend([views(study), costs(study), against(study)]);
    let mut texts = vec![method];
    if study.variants.iter().any(|variant| variant.n_objects() != study.variants[0].n_objects()) {
        texts.push(
            "The variants do not have the same objects, since runs failed or are still to come: \
             only the paired differences compare like with like.",
        );
    }
    let texts = texts.into_iter().map(|text| Block::Text(text.to_owned()));
    Section {
        title: "Summary".to_owned(),
        blocks: texts.chain(blocks.into_iter().map(Block::Table)).collect(),
    }
}

/// The mean with its interval; a dash where there are no values.
fn with_interval(values: &[f64], measure: &Measure) -> Cell {
    let Some(mean) = mean(values) else { return "–".into() };
    let note = Interval::of_mean(values)
        .map(|interval| format!("{} to {}", measure.show(interval.low), measure.show(interval.high)));
    Cell::with_note(measure.show(mean), note.unwrap_or_default())
}

fn table(
    study: &Study<'_>,
    caption: &str,
    head: &[&str],
    cells: impl Fn(&StudyVariant<'_>) -> Vec<Cell>,
) -> Table {
    let row = |variant: &StudyVariant<'_>| {
        Row::new(std::iter::once(variant.name.into()).chain(cells(variant)).collect())
    };
    Table {
        caption: caption.to_owned(),
        head: std::iter::once(Column::text("variant"))
            .chain(head.iter().map(|&name| Column::number(name)))
            .collect(),
        rows: study.variants.iter().map(row).collect(),
    }
}

fn reached(study: &Study<'_>) -> Table {
    let mut measures = vec![VOXEL_COVERAGE, REACHABLE_COVERAGE, SKILL, SURFACE_2MM, SURFACE_5MM];
    // Scans whose clouds hold nothing of the object have none.
    if study.variants.iter().any(|variant| variant.mean(&ACCURACY).is_some()) {
        measures.extend([ACCURACY, COMPLETENESS]);
    }
    let mut head = vec!["objects"];
    head.extend(measures.iter().map(|measure| measure.name));
    head.push("lowest skill");
    table(study, "What was reached with the last view", &head, |variant| {
        let mut cells = vec![variant.n_objects().to_string().into()];
        cells.extend(measures.iter().map(|measure| with_interval(&variant.values(measure), measure)));
        cells.push(lowest_skill(study, variant));
        cells
    })
}

/// What map and model have; without the measures that no run has, and none without any.
fn has(study: &Study<'_>) -> Option<Table> {
    let mut measures =
        vec![MAP_PRECISION, MAP_RECALL, MAP_IOU, F_SCORE_1MM, F_SCORE_2MM, F_SCORE_5MM, CHAMFER];
    measures.extend([AREA_OVER_VIEWS, AREA_OVER_TIME]);
    measures.retain(|measure| study.variants.iter().any(|variant| variant.mean(measure).is_some()));
    let head: Vec<&str> = measures.iter().map(|measure| measure.name).collect();
    let caption = "What the map and the cloud have in the end, and how early (docs/measures.md)";
    (!measures.is_empty()).then(|| {
        table(study, caption, &head, |variant| {
            measures.iter().map(|measure| with_interval(&variant.values(measure), measure)).collect()
        })
    })
}

/// The lowest skill, and its object.
fn lowest_skill(study: &Study<'_>, variant: &StudyVariant<'_>) -> Cell {
    let skills = variant.by_object(&SKILL).into_iter().zip(&study.objects);
    let skills = skills.filter_map(|(skill, object)| Some((skill?, object.name)));
    let lowest = skills.min_by(|a, b| a.0.total_cmp(&b.0));
    lowest.map_or("–".into(), |(skill, object)| Cell::with_note(SKILL.show(skill), object))
}

fn views(study: &Study<'_>) -> Table {
    let head = LEVELS.map(|level| format!("{} %", (100.0 * level).round()));
    let caption = "Views until this share of the reachable object voxels was seen; a run that did not get \
                   there counts as one view more than it could take, and the mean is marked ≥";
    let head = head.each_ref().map(String::as_str);
    table(study, caption, &head, |variant| LEVELS.map(|level| views_to(variant, level)).to_vec())
}

fn views_to(variant: &StudyVariant<'_>, level: f64) -> Cell {
    let known = variant.runs.iter().filter(|runs| runs.iter().any(|run| run.views_to(level).is_some()));
    let known: Vec<_> = known.collect();
    let of_object = |runs: &Vec<MeasuredRun<'_>>| {
        mean(&runs.iter().filter_map(|run| run.views_to(level)).collect::<Vec<_>>())
    };
    let views: Vec<f64> = known.iter().filter_map(|runs| of_object(runs)).collect();
    let Some(mean) = mean(&views) else { return "–".into() };
    let n_reaching = known.iter().filter(|runs| runs.iter().all(|run| run.reaches(level))).count();
    let bound = if n_reaching < views.len() { "≥ " } else { "" };
    Cell::with_note(format!("{bound}{mean:.1}"), format!("{n_reaching} of {} objects", views.len()))
}

fn costs(study: &Study<'_>) -> Table {
    let head = [PATH.name, "planning time per view, median, ms", "95th percentile, ms", MEMORY.name];
    table(study, "What it cost", &head, |variant| {
        let times: Vec<f64> = variant.measured().flat_map(|run| run.plan_times()).collect();
        let time = |share| percentile(&times, share).map_or("–".into(), |t| PLAN_TIME.show(t).into());
        let (path, memory) = (variant.values(&PATH), variant.values(&MEMORY));
        vec![with_interval(&path, &PATH), time(0.5), time(0.95), with_interval(&memory, &MEMORY)]
    })
}

/// The coverage of each variant beyond random views, beyond a variant of random views, and beyond its best
/// rival.
fn against(study: &Study<'_>) -> Table {
    let random = study.variants.iter().find(|variant| variant.planner == PlannerName::Random);
    let mut head = vec!["reachable coverage beyond random views, points", "objects better / worse / equal"];
    if random.is_some() {
        head.extend(["voxel coverage beyond the random variant, points", "objects better / worse / equal"]);
    }
    head.extend(["voxel coverage beyond the best other, points", "objects better / worse / equal"]);
    let caption = "Paired differences in final coverage; the best other leaves out the clairvoyant planner";
    table(study, caption, &head, |variant| {
        let mut cells = paired(&variant.values(&COVERAGE_BEYOND_RANDOM), "").to_vec();
        let coverage = |variant: &StudyVariant<'_>| variant.by_object(&VOXEL_COVERAGE);
        let beyond = |other: Option<&StudyVariant<'_>>, name: &str| match other {
            Some(other) => paired(&differences(&coverage(variant), &coverage(other)), name),
            None => [Cell::from("–"), "–".into()],
        };
        if random.is_some() {
            cells.extend(beyond(random.filter(|random| random.name != variant.name), ""));
        }
        let other = best_other(study, variant);
        cells.extend(beyond(other, other.map_or("", |other| other.name)));
        cells
    })
}

/// The variant of largest mean coverage, apart from this one and the clairvoyant.
fn best_other<'s, 'a>(study: &'s Study<'a>, variant: &StudyVariant<'_>) -> Option<&'s StudyVariant<'a>> {
    let rival = |other: &&StudyVariant<'_>| {
        other.name != variant.name && other.planner != PlannerName::Clairvoyant && other.n_objects() > 0
    };
    study.variants.iter().find(rival)
}

/// The mean difference with its interval, and on how many objects it is better, worse and equal.
fn paired(differences: &[f64], other: &str) -> [Cell; 2] {
    let Some(mean) = mean(differences) else { return ["–".into(), "–".into()] };
    let show = |value| VOXEL_COVERAGE.show_difference(value);
    let interval = Interval::of_mean(differences).map(|i| format!("{} to {}", show(i.low), show(i.high)));
    let name = if other.is_empty() { String::new() } else { format!("against {other}") };
    let note = [interval.unwrap_or_default(), name].into_iter().filter(|part| !part.is_empty());
    let count = |f: fn(f64) -> bool| differences.iter().filter(|&&d| f(d)).count();
    let (better, worse) = (count(|d| d > DRAW), count(|d| d < -DRAW));
    let equal = differences.len() - better - worse;
    [
        Cell::with_note(show(mean), note.collect::<Vec<_>>().join(", ")),
        format!("{better} / {worse} / {equal}").into(),
    ]
}
