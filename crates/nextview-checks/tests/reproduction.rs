//! The tables of the pages are those of the reports. `benchmarks/sample.py` checks that the reports are what
//! today's program finds.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::collections::BTreeMap;

const PAGE: &str = include_str!("../../../docs/reproduction.md");
const TABLE_1: &str = include_str!("../../../docs/reproduction/short-paper-1.md");
const MAP_RULE: &str = include_str!("../../../docs/reproduction/map-rule.md");
const README: &str = include_str!("../../../README.md");
const RESULTS: &str = include_str!("../../../docs/results.md");
const PLANNER: &str = include_str!("../../../docs/planner.md");

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

/// The rows of a table by their first cells, without their marks.
fn rows<'a>(text: &'a str, head: &str) -> BTreeMap<&'a str, Vec<&'a str>> {
    let rows = table(text, head).into_iter().skip(1);
    rows.map(|row| (row[0].trim_matches('*'), row[1..].to_vec())).collect()
}

/// The mean in a report's cell.
fn mean(cell: &str) -> &str {
    match cell.trim_start_matches("≥ ").split(' ').next().unwrap() {
        "-0.00" => "0.00",
        mean => mean,
    }
}

/// The mean of views in a report's cell, still marked where it is a lower bound.
fn views(cell: &str) -> String {
    format!("{}{}", if cell.starts_with('≥') { "≥ " } else { "" }, mean(cell))
}

/// The mean in a report's cell and its interval.
fn mean_and_interval(cell: &str) -> String {
    let (_, interval) = cell.split_once(' ').unwrap();
    format!("{} {})", mean(cell), interval.split(", median").next().unwrap())
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
fn the_advantage_over_random_views_is_that_of_the_report() {
    let differences = differences(MAP_RULE, "hits only, rays fade", "random, hits only");
    let said = table(PAGE, "| max-flow less random views, after ten views |");
    assert_eq!(said.len(), 3);
    for row in &said[1..] {
        let set = if row[0].starts_with("Stanford") { "both: the paper's data sets" } else { row[0] };
        let values = &differences[set];
        let n = |is: fn(&f64) -> bool| values.iter().filter(|value| is(value)).count();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let said: f64 = row[2].split(' ').next().unwrap().parse().unwrap();
        assert_eq!(row[1], values.len().to_string(), "{row:?}");
        assert!((said - mean).abs() <= 0.06, "{row:?}: {mean}");
        assert_eq!(row[3], format!("{} / {}", n(|d| *d > 1e-9), n(|d| *d < -1e-9)), "{row:?}");
    }
}

/// Of every map rule and of every fading of rays, against random views in maps of the same rule.
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

/// Every planner in the paper's protocol, on the page of the reproduction and in docs/results.md.
#[test]
fn table_1_is_that_of_its_report() {
    let reached = rows(TABLE_1, "| variant | objects | voxel coverage, % |");
    let has = rows(TABLE_1, "| variant | precision of the map, % |");
    let said = rows(PAGE, "| | coverage, % | skill | median |");
    assert_eq!((said.len(), reached.len()), (27, 27));
    for (name, said) in &said {
        let (reached, has) = (&reached[name], &has[name]);
        let skill = format!("{}, median {})", said[1].trim_end_matches(')'), said[2]);
        assert_eq!(skill, reached[3], "{name}");
        let means = [reached[1], reached[2], has[2]].map(mean);
        assert_eq!([said[0], said[3], said[4]], means, "{name}");
    }
    let results = rows(RESULTS, "| planner | voxel coverage, % | skill |");
    assert!(results.contains_key("random") && results.contains_key("even-views"));
    for (name, cells) in results {
        assert_eq!(cells, said[name][..2], "{name}");
    }
    let methods = ["apora", "rse", "nbv-net", "max-flow", "random", "even-views", "clairvoyant"];
    let here = &rows(PAGE, "| coverage, % | APORA | RSE | NBV-Net |")["here, 12 objects"];
    assert_eq!(*here, methods.map(|name| said[name][0]));
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

/// All planners in eight settings.
const SETTINGS: &str = include_str!("../../../docs/planner/settings.md");

/// A setting of the campaign of all planners.
fn of_setting(heading: &str) -> BTreeMap<&'static str, Vec<&'static str>> {
    let (_, report) = SETTINGS.split_once(&format!("\n## {heading}\n")).unwrap();
    rows(report, "|  | skill | lowest |")
}

#[test]
fn the_planners_are_said_to_be_what_was_measured() {
    let (_, page) = PLANNER.split_once("## All planners").unwrap();
    let all = table(page, "| | 5 mm | 1 cm |");
    assert_eq!((all.len(), all[0].len()), (27, 9));
    for (column, setting) in all[0].iter().enumerate().skip(1) {
        let heading = setting.replace(" mm", "mm").replace(" cm", "cm").replace(", ", "-");
        let measured = of_setting(&heading);
        assert_eq!(measured.len() + 1, all.len());
        for row in &all[1..] {
            let of = &measured[row[0]];
            let said = format!("{} ({})", mean(of[0]), of[1].split(' ').next().unwrap());
            assert_eq!(row[column], said, "{}, {setting}", row[0]);
        }
    }
}

/// The default planner with five first views in six settings.
#[test]
fn the_default_planner_is_said_to_be_what_was_measured() {
    const DEFAULT: &str = include_str!("../../../docs/planner/default.md");
    let said = rows(PLANNER, "| most-surface | skill | lowest | views to 95 % |");
    assert_eq!(said.len(), 6);
    for (setting, said) in said {
        let heading = setting.replace(" mm", "mm").replace(" cm", "cm").replace(", ", "-");
        let (_, report) = DEFAULT.split_once(&format!("\n## {heading}\n")).unwrap();
        let measured = rows(report, "|  | skill | lowest |").remove("most-surface").unwrap();
        let measured: Vec<String> = measured.iter().map(|cell| cell.replace('\\', "")).collect();
        assert_eq!(said[..4], measured[..4], "{setting}");
    }
}

/// The reports of the campaigns at the beginning of README.md and docs/results.md.
const HEADLINE: [&str; 2] = [
    include_str!("../../../docs/planner/headline-5mm.md"),
    include_str!("../../../docs/planner/headline-5mm-table-noise.md"),
];

#[test]
fn the_readme_says_what_was_measured() {
    let readme = rows(README, "| planner | views to 95 %, all around |");
    assert!(["random", "even-views"].iter().all(|name| readme.contains_key(name)));
    let until = rows(HEADLINE[0], "| variant | 90 % | 95 % | 99 % |");
    let reached = HEADLINE.map(|report| rows(report, "| variant | objects | voxel coverage, % |"));
    let reality = rows(include_str!("../../../docs/reality.md"), "| | skill, mean | lowest |");
    for (name, said) in readme {
        let said: Vec<_> = said.iter().map(|cell| cell.trim_matches('*')).collect();
        let name = name.split([':', ',']).next().unwrap();
        let [around, noisy] = [0, 1].map(|setting: usize| mean(reached[setting][name][3]));
        let share = reality.get(name).map(|row| 100.0 * row[2].parse::<f64>().unwrap());
        let share = share.map(|share| format!("{share:.1}")).unwrap_or_default();
        assert_eq!(said[..4], [&*views(until[name][1]), around, noisy, &share], "{name}");
    }
}

/// docs/results.md and docs/planner.md begin with what these campaigns measured, the lowest objects included.
#[test]
fn the_first_tables_are_those_of_the_campaigns() {
    let results = rows(RESULTS, "| planner | 5 mm, all around | lowest |");
    let (_, mut page) = PLANNER.split_once("## Beside other planners").unwrap();
    for (setting, report) in HEADLINE.into_iter().enumerate() {
        let reached = rows(report, "| variant | objects | voxel coverage, % |");
        let (_, worst) = report.split_once("The worst object").unwrap();
        let worst = rows(worst, "| variant | voxel coverage, % |");
        let until = rows(report, "| variant | 90 % | 95 % | 99 % |");
        let has = rows(report, "| variant | precision of the map, % |");
        let said = rows(page, "| | skill | median | lowest |");
        page = page.split_once("| | skill | median | lowest |").unwrap().1;
        assert!(said.len() >= 7 && said.len() == results.len());
        for (name, said) in said {
            let skill = [mean_and_interval(reached[name][3]), worst[name][2].replace('\\', "")];
            assert_eq!([said[0], said[2]], skill, "{name}, {setting}");
            assert_eq!(results[name][2 * setting..][..2], skill, "{name}, {setting}");
            let others = until[name].iter().map(|cell| views(cell));
            let others = others.chain([reached[name][2], has[name][2]].map(|cell| mean(cell).to_owned()));
            assert_eq!(said[3..8], others.collect::<Vec<_>>(), "{name}, {setting}");
        }
    }
}
