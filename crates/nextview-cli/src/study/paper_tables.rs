//! Tables II to VII in the paper's shape, where the campaign varies what they vary.
//!
//! A table is two axes and a few measures. Variants belong in one table if their configurations are equal but for the
//! parameters of its axes.

use super::document::{Block, Cell, Column, Row, Section, Table};
use super::measure::{COMPUTING_TIME, MEMORY, Measure, PATH, VOXEL_COVERAGE};
use super::study::{Study, Variant};
use super::{paper, running_time};
use crate::scan::PlannerName;
use serde_json::Value;

/// The section; none if the campaign has nothing for any of the tables.
pub(crate) fn section(study: &Study<'_>) -> Option<Section> {
    let mut blocks = vec![by_method(study, "II", "Computational efficiency", &[MEMORY_II, TIME])];
    blocks.extend(PARAMETER_TABLES.map(|definition| definition.fill(study)));
    let running_time = running_time::table(study);
    let running_time_note = running_time.as_ref().map(|_| running_time::NOTE).unwrap_or_default();
    blocks.insert(4, running_time);
    let mut blocks: Vec<Block> = blocks.into_iter().flatten().map(Block::Table).collect();
    if blocks.is_empty() {
        return None;
    }
    let note = "In brackets or below a value: what the paper published. Its times are of its own computer (Intel Xeon E5-2640).";
    blocks.insert(0, Block::Text(format!("{note} {running_time_note}").trim_end().to_owned()));
    Some(Section { title: "The paper's tables".to_owned(), blocks })
}

/// A measure and its name in `paper_numbers.csv`.
type Published = (Measure, &'static str);

const COVERAGE: Published = (VOXEL_COVERAGE, "coverage");
const TIME: Published = (COMPUTING_TIME, "time");
const MEMORY_II: Published = (MEMORY, "memory");
const MOVEMENT: Published = (PATH, "movement");

/// The measures over an axis, a row for each measure and each value of the other axis.
struct Definition {
    number: &'static str,
    title: &'static str,
    rows: Axis,
    columns: Axis,
    measures: &'static [Published],
}

/// Something that variants differ in.
#[derive(Clone, Copy)]
struct Axis {
    name: &'static str,
    /// The parameters it stands for, with dots.
    keys: &'static [&'static str],
    /// The value of a variant; none if the variant has no place in the table.
    label: fn(PlannerName, &Value) -> Option<String>,
}

const METHOD: Axis = Axis { name: "method", keys: &["planner"], label: |planner, _| Some(method(planner)) };

const MULTI: Axis = Axis {
    name: "multi-resolution",
    keys: &["multi_resolution"],
    label: |_, config| {
        let is_on = find(config, "multi_resolution.enabled") == Some(&Value::Bool(true));
        let coarsest = find(config, "multi_resolution.coarsest_voxel_size_m").and_then(number);
        Some(match (is_on, coarsest) {
            (false, _) => "single".to_owned(),
            (true, None) => "multi".to_owned(),
            (true, Some(coarsest)) => format!("multi from {coarsest} m"),
        })
    },
};

const HISTORY: Axis = Axis {
    name: "history",
    keys: &["max_flow.uses_history"],
    label: |_, config| {
        let is_off = find(config, "max_flow.uses_history") == Some(&Value::Bool(false));
        Some(if is_off { "without history" } else { "with history" }.to_owned())
    },
};

const GAMMA: Axis = Axis {
    name: "γ",
    keys: &["max_flow.gamma"],
    label: |planner, config| {
        find(config, "max_flow.gamma").filter(|_| planner == PlannerName::MaxFlow).and_then(number)
    },
};

const Q_THRESH: Axis = Axis {
    name: "q_thresh",
    keys: &["multi_resolution.q_thresh"],
    label: |_, config| find(config, "multi_resolution.q_thresh").and_then(number),
};

const THETA: Axis = Axis {
    name: "θ",
    keys: &["most_surface.theta", "max_flow.theta", "greedy.theta", "batch.theta"],
    label: |planner, config| find(config, &format!("{}.theta", planner_key(planner))).and_then(number),
};

const PARAMETER_TABLES: [Definition; 4] = [
    Definition {
        number: "III",
        title: "Multi-resolution ablation",
        rows: METHOD,
        columns: MULTI,
        measures: &[COVERAGE, TIME],
    },
    Definition {
        number: "IV",
        title: "Weight of the flow and history",
        rows: HISTORY,
        columns: GAMMA,
        measures: &[COVERAGE],
    },
    Definition {
        number: "V",
        title: "Threshold of multi-resolution",
        rows: METHOD,
        columns: Q_THRESH,
        measures: &[COVERAGE],
    },
    Definition {
        number: "VII",
        title: "Weight of the robot's movement",
        rows: METHOD,
        columns: THETA,
        measures: &[COVERAGE, MOVEMENT],
    },
];

/// A variant's place in a table.
struct Place<'s, 'a> {
    variant: &'s Variant<'a>,
    /// The configuration without the axes' parameters.
    rest: Value,
    row: String,
    column: String,
}

impl Definition {
    /// The table; none if no row would have two columns.
    fn fill(&self, study: &Study<'_>) -> Option<Table> {
        let places: Vec<Place<'_, '_>> = study.variants.iter().filter_map(|v| self.place(v)).collect();
        let lines = lines(&places);
        let mut columns: Vec<&str> = lines.iter().flatten().map(|place| place.column.as_str()).collect();
        columns.sort_by(|a, b| by_value(a, b));
        columns.dedup();
        let mut head = [self.rows.name, "measure"].map(Column::text).to_vec();
        head.extend(columns.iter().map(|column| Column::number(format!("{} = {column}", self.columns.name))));
        let mut rows = Vec::new();
        for line in &lines {
            let is_alone = lines.iter().filter(|other| other[0].row == line[0].row).count() == 1;
            for published in self.measures {
                let mut cells = vec![line_name(line, is_alone).into(), published.0.name.into()];
                cells.extend(columns.iter().map(|column| self.cell(line, column, published)));
                rows.push(Row::new(cells));
            }
        }
        let caption = format!("Table {}. {}", self.number, self.title);
        (!rows.is_empty()).then_some(Table { caption, head, rows })
    }

    fn place<'s, 'a>(&self, variant: &'s Variant<'a>) -> Option<Place<'s, 'a>> {
        let mut rest = configuration(variant);
        let row = (self.rows.label)(variant.planner, &rest)?;
        let column = (self.columns.label)(variant.planner, &rest)?;
        self.rows.keys.iter().chain(self.columns.keys).for_each(|key| remove(&mut rest, key));
        Some(Place { variant, rest, row, column })
    }

    fn cell(&self, row: &[&Place<'_, '_>], column: &str, (measure, name): &Published) -> Cell {
        let here = row.iter().filter(|place| place.column == column);
        let values = here.filter_map(|place| Some(measure.show(place.variant.mean(measure)?)));
        let text = values.collect::<Vec<_>>().join(" / ");
        cell(text, paper::number(self.number, &row[0].row, column, name))
    }
}

/// Places that differ in nothing but the column, row by row; only those with several columns.
fn lines<'p, 's, 'a>(places: &'p [Place<'s, 'a>]) -> Vec<Vec<&'p Place<'s, 'a>>> {
    let mut rows: Vec<Vec<&Place<'_, '_>>> = Vec::new();
    for place in places {
        let same = |row: &&mut Vec<&Place<'_, '_>>| row[0].row == place.row && row[0].rest == place.rest;
        match rows.iter_mut().find(same) {
            Some(row) => row.push(place),
            None => rows.push(vec![place]),
        }
    }
    rows.retain(|row| row.iter().any(|place| place.column != row[0].column));
    rows.sort_by(|a, b| a[0].row.cmp(&b[0].row).then(a[0].variant.name.cmp(b[0].variant.name)));
    rows
}

/// Lines of one name differ in something that the table does not show.
fn line_name(line: &[&Place<'_, '_>], is_alone: bool) -> String {
    let Place { row, variant, .. } = line[0];
    if is_alone { row.clone() } else { format!("{row} (as {})", variant.name) }
}

/// A table with a column for each variant; none if the paper has none of the methods.
fn by_method(study: &Study<'_>, number: &str, title: &str, measures: &[Published]) -> Option<Table> {
    let methods: Vec<Option<&str>> = study.variants.iter().map(|v| paper::method(v.planner)).collect();
    methods.iter().flatten().next()?;
    let row = |(measure, name): &Published| {
        let cell = |(variant, method): (&Variant<'_>, &Option<&str>)| {
            let text = variant.mean(measure).map_or_else(String::new, |mean| measure.show(mean));
            cell(text, method.and_then(|method| paper::number(number, "", method, name)))
        };
        let cells = study.variants.iter().zip(&methods).map(cell);
        Row::new(std::iter::once(measure.name.into()).chain(cells).collect())
    };
    let names = study.variants.iter().map(|variant| Column::number(variant.name));
    let table = Table {
        caption: format!("Table {number}. {title}"),
        head: std::iter::once(Column::text("")).chain(names).collect(),
        rows: measures.iter().map(row).collect(),
    };
    // A page has room for about six variants beside each other.
    Some(if study.variants.len() > 6 { table.transposed() } else { table })
}

fn cell(text: String, published: Option<f64>) -> Cell {
    let text = if text.is_empty() { "–".to_owned() } else { text };
    Cell::with_note(text, published.map(|value| format!("paper {value}")).unwrap_or_default())
}

fn method(planner: PlannerName) -> String {
    paper::method(planner).map_or_else(|| planner.to_string(), str::to_owned)
}

/// Where the configuration has the parameters of planners.
const PLANNER_KEYS: [&str; 5] = ["most_surface", "max_flow", "greedy", "batch", "nbv_net"];

/// Where it has those of this planner, if there are any.
fn planner_key(planner: PlannerName) -> &'static str {
    match planner {
        PlannerName::MaxFlow | PlannerName::Local => "max_flow",
        PlannerName::MostSurface => "most_surface",
        PlannerName::Batch => "batch",
        PlannerName::NbvNet => "nbv_net",
        _ => "greedy",
    }
}

/// The variant's parameters, without those that tell runs apart and those that its planner does not read.
fn configuration(variant: &Variant<'_>) -> Value {
    let mut config = serde_json::to_value(&variant.example.config).unwrap_or_default();
    let unread = PLANNER_KEYS.into_iter().filter(|key| *key != planner_key(variant.planner));
    for key in ["object", "unit", "size_m", "seed", "first_view"].into_iter().chain(unread) {
        remove(&mut config, key);
    }
    config
}

fn find<'v>(config: &'v Value, key: &str) -> Option<&'v Value> {
    key.split('.').try_fold(config, |value, part| value.get(part))
}

fn remove(config: &mut Value, key: &str) {
    let Value::Object(fields) = config else { return };
    match key.split_once('.') {
        Some((first, rest)) => fields.get_mut(first).into_iter().for_each(|inner| remove(inner, rest)),
        None => drop(fields.remove(key)),
    }
}

fn number(value: &Value) -> Option<String> {
    value.as_f64().map(|number| number.to_string())
}

/// Numbers by value, words by the alphabet backwards, so that "single" precedes "multi".
fn by_value(a: &str, b: &str) -> std::cmp::Ordering {
    match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => a.total_cmp(&b),
        _ => b.cmp(a),
    }
}
