//! The page of the reproduction beside the reports that it is about.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::collections::BTreeMap;

const PAGE: &str = include_str!("../../../docs/reproduction.md");
const TABLE_1: &str = include_str!("../../../docs/reproduction/paper-1.md");

const MAP_RULE: &str = include_str!("../../../docs/reproduction/map-rule.md");

const STANFORD: [&str; 6] = ["armadillo", "bunny", "dragon", "happy_buddha", "lucy", "xyzrgb_dragon"];

/// The cells of a table: the head, then the rows.
fn table<'a>(text: &'a str, head: &str) -> Vec<Vec<&'a str>> {
    let start = text.find(head).unwrap_or_else(|| panic!("there is no table {head}"));
    let lines = text[start..].lines().take_while(|line| line.starts_with('|'));
    let cells = lines.map(|line| line.trim_matches('|').split('|').map(str::trim).collect::<Vec<_>>());
    cells.filter(|cells| !cells[0].starts_with("---")).collect()
}

fn data_set(object: &str) -> &'static str {
    match object {
        _ if object.starts_with("lm_") => "LINEMOD",
        _ if object.starts_with("tless_") => "T-LESS",
        _ if object.starts_with("ycb_") => "YCB",
        _ if STANFORD.contains(&object) => "Stanford",
        _ => "others",
    }
}

/// Final coverage of one variant less that of another in a report, points, by data set.
fn differences(report: &str, variant: &str, other: &str) -> BTreeMap<&'static str, Vec<f64>> {
    let (_, report) = report.split_once("## Voxel coverage by object").unwrap();
    let rows = table(report, "| object |");
    let column = |name: &str| rows[0].iter().position(|cell| *cell == name).unwrap();
    let (variant, other) = (column(variant), column(other));
    let mut by_set = BTreeMap::<_, Vec<f64>>::new();
    for row in rows[1..].iter().filter(|row| !row[0].starts_with("**")) {
        let object = row[0].split(" (").next().unwrap().replace('\\', "");
        let percent = |column: usize| row[column].parse::<f64>().unwrap();
        by_set.entry(data_set(&object)).or_default().push(percent(variant) - percent(other));
    }
    let of = |sets: &[&str]| -> Vec<f64> {
        sets.iter().filter_map(|set| by_set.get(set)).flatten().copied().collect()
    };
    let (paper, all) =
        (of(&["Stanford", "LINEMOD"]), of(&["LINEMOD", "Stanford", "T-LESS", "YCB", "others"]));
    by_set.extend([("both: the paper's data sets", paper), ("all", all)]);
    by_set
}

#[test]
fn differences_by_data_set_are_those_of_the_report() {
    let differences = differences(TABLE_1, "max-flow", "random");
    let rows = table(PAGE, "| max-flow less random views, table I |");
    assert_eq!(rows.len() - 1, differences.len());
    for row in &rows[1..] {
        let values = &differences[row[0].trim_matches('*')];
        let n = |is: fn(&f64) -> bool| values.iter().filter(|value| is(value)).count();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let said: f64 = row[2].split(' ').next().unwrap().parse().unwrap();
        assert_eq!(row[1], values.len().to_string(), "{row:?}");
        assert!((said - mean).abs() <= 0.05 + 1e-9, "{row:?}: {mean}");
        assert_eq!(row[3], format!("{} / {}", n(|d| *d > 1e-9), n(|d| *d < -1e-9)), "{row:?}");
    }
}

/// Of every map rule and of every fading of rays, beside random views in maps of the same rule.
#[test]
fn differences_by_map_rule_are_those_of_the_report() {
    let rows = table(PAGE, "| | hits only | carved |");
    assert_eq!(rows.len(), 5);
    for row in &rows[1..] {
        let (set, rays) = row[0].split_once(", ").unwrap();
        let set = if set.starts_with("Stanford") { "both: the paper's data sets" } else { set };
        for (map, cell) in rows[0][1..].iter().zip(&row[1..]) {
            let differences = differences(MAP_RULE, &format!("{map}, {rays}"), &format!("random, {map}"));
            let mean = differences[set].iter().sum::<f64>() / differences[set].len() as f64;
            let said: f64 = cell.trim_matches('*').split(' ').next().unwrap().parse().unwrap();
            assert!((said - mean).abs() <= 0.06, "{row:?}: {mean}");
        }
    }
}

/// Every planner in the paper's protocol with exact truth.
#[test]
fn table_1_with_exact_truth_is_that_of_its_report() {
    let report = include_str!("../../../docs/reproduction/short-paper-1.md");
    let reached = table(report, "| variant | objects | voxel coverage, % |");
    let has = table(report, "| variant | precision of the map, % |");
    let said = table(PAGE, "| | coverage before, % | coverage, % | skill |");
    assert_eq!((said.len(), reached.len()), (28, 28));
    let mean = |cell: &str| cell.split(' ').next().unwrap().to_owned();
    for ((said, reached), has) in said[1..].iter().zip(&reached[1..]).zip(&has[1..]) {
        assert_eq!((said[0], said[0]), (reached[0], has[0]));
        let skill = format!("{}, median {})", said[3].trim_end_matches(')'), said[4]);
        assert_eq!(skill, reached[4], "{}", said[0]);
        let means = [reached[2], reached[3], has[3], has[5], has[7]].map(mean);
        assert_eq!([said[2], said[5], said[6], said[7], said[8]], means, "{}", said[0]);
    }
}

const PROTOCOLS: &str = include_str!("../../../docs/protocols.md");
const PB_NBV: &str = include_str!("../../../docs/reproduction/pb-nbv.md");

/// By planner, the mean with its interval in this space.
fn pb_nbv(space: &str) -> BTreeMap<&'static str, &'static str> {
    let (_, report) = PB_NBV.split_once(&format!("\n## {space}\n")).unwrap();
    table(report, "| planner |")[1..].iter().map(|row| (row[0], row[1])).collect()
}

/// All planners under the protocol of PB-NBV, and beside what that publishes.
#[test]
fn the_protocol_of_pb_nbv_is_that_of_its_report() {
    let spaces = ["whole", "hemisphere", "half"].map(pb_nbv);
    let all = table(PROTOCOLS, "| | all around | upper hemisphere | half |");
    assert_eq!(all.len(), 27);
    for row in &all[1..] {
        assert_eq!(row[1..], spaces.each_ref().map(|space| space[row[0]]), "{}", row[0]);
    }
    for row in &table(PROTOCOLS, "| % of the surface after ten views |")[1..] {
        let space = all[0][1..].iter().position(|space| row[3].starts_with(space));
        let name = if row[0].starts_with("max-flow") { row[0].to_owned() } else { row[0].to_lowercase() };
        assert_eq!(row[2], space.map_or("-", |space| spaces[space][&*name]), "{row:?}");
    }
}

/// The objects that no planner was developed with, under the protocol of PB-NBV.
#[test]
fn the_means_over_test_objects_are_those_of_the_report() {
    const OBJECTS: [&str; 5] =
        ["lm_obj_000001_ape", "lm_obj_000012_holepuncher", "bunny", "dragon", "xyzrgb_dragon"];
    let said = table(PROTOCOLS, "| mean over five test objects, % |");
    for (column, space) in ["whole", "hemisphere", "half"].into_iter().enumerate() {
        let (_, report) = PB_NBV.split_once(&format!("\n## {space}\n")).unwrap();
        let by_object = table(report, "| object |");
        for row in &said[1..] {
            let planner = by_object[0].iter().position(|name| *name == row[0]).unwrap();
            let shares = by_object.iter().filter(|cells| OBJECTS.contains(&cells[0]));
            let mean = shares.map(|cells| cells[planner].parse::<f64>().unwrap()).sum::<f64>() / 5.0;
            // The report's entries are rounded, too.
            let said: f64 = row[column + 1].parse().unwrap();
            assert!((said - mean).abs() < 0.1 + 1e-9, "{}, {space}: {said}, {mean}", row[0]);
        }
    }
}

/// All planners under the protocol of ObjView-Bench.
#[test]
fn the_protocol_of_objview_is_that_of_its_report() {
    let report = include_str!("../../../docs/reproduction/objview.md");
    let report = table(report, "| planner |");
    let first = |cell: &'static str| cell.split(' ').next().unwrap();
    let measured = report[1..].iter().map(|row| {
        let share = |column: usize| format!("{} ({})", first(row[column]), first(row[column + 1]));
        (row[0], [share(1), share(3), share(5), row[11].to_owned()])
    });
    let measured: BTreeMap<_, _> = measured.collect();
    let said = table(PROTOCOLS, "| | NSC@.02 after 5 moves, % |");
    assert_eq!((said.len(), measured.len()), (27, 26));
    for row in &said[1..] {
        assert_eq!(row[1..], measured[row[0]], "{}", row[0]);
    }
}
