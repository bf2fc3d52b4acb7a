//! The tables of the pages are those of the files in `docs/data`. `benchmarks/sample.py` checks that today's
//! program finds what the files hold.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

const PAGE: &str = include_str!("../../../docs/reproduction.md");
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

/// A row of a file, by the names of its columns.
type Row = BTreeMap<String, String>;

/// The rows of a file of `docs/data`.
fn data(file: &str) -> Vec<Row> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/data").join(file);
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines().map(fields);
    let head = lines.next().unwrap();
    lines.map(|line| head.iter().cloned().zip(line).collect()).collect()
}

/// The fields of a line of CSV.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut is_quoted = false;
    for c in line.chars() {
        match c {
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => fields.push(String::new()),
            c => fields.last_mut().unwrap().push(c),
        }
    }
    fields
}

/// A measure of a campaign's variant.
fn statistic<'r>(rows: &'r [Row], variant: &str, measure: &str) -> &'r Row {
    let is_it = |row: &&Row| row["variant"] == variant && row["measure"] == measure;
    rows.iter().find(is_it).unwrap_or_else(|| panic!("there is no {measure} of {variant}"))
}

/// The mean as the pages print it.
fn mean(row: &Row) -> String {
    unsigned(&row["value"])
}

/// Zero without a sign.
fn unsigned(number: &str) -> String {
    if number == "-0.00" { "0.00".to_owned() } else { number.to_owned() }
}

/// The mean of views, marked where it is a lower bound.
fn views(row: &Row) -> String {
    let is_bound = row["n_reaching"] != row["n_objects"];
    format!("{}{}", if is_bound { "≥ " } else { "" }, mean(row))
}

/// The mean and its interval.
fn mean_and_interval(row: &Row) -> String {
    format!("{} ({} to {})", mean(row), row["low"], row["high"])
}

/// The worst object.
fn worst(row: &Row) -> String {
    format!("{} ({})", row["worst"], row["worst_object"])
}

/// Final coverage of one variant less that of another in a campaign, points, by data set.
fn differences(campaign: &str, variant: &str, other: &str) -> BTreeMap<&'static str, Vec<f64>> {
    let rows = data(&format!("{campaign}/objects.csv"));
    let mut by_object = BTreeMap::<&str, [Option<f64>; 2]>::new();
    for row in rows.iter().filter(|row| !row["object"].is_empty()) {
        let percent = row["voxel_coverage_percent"].parse().unwrap();
        for (i, name) in [variant, other].into_iter().enumerate().filter(|(_, name)| row["variant"] == *name)
        {
            assert!(by_object.entry(&row["object"]).or_default()[i].replace(percent).is_none(), "{name}");
        }
    }
    let mut by_set = BTreeMap::<_, Vec<f64>>::new();
    for (object, [variant, other]) in by_object {
        by_set.entry(data_set(object)).or_default().push(variant.unwrap() - other.unwrap());
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
fn the_advantage_over_random_views_is_that_of_the_data() {
    let differences = differences("map-rule", "hits only, rays fade", "random, hits only");
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
fn differences_by_map_rule_are_those_of_the_data() {
    let rows = table(PAGE, "| | hits only | carved |");
    assert_eq!(rows.len(), 5);
    for row in &rows[1..] {
        let (set, rays) = row[0].split_once(", ").unwrap();
        let set = if set.starts_with("Stanford") { "both: the paper's data sets" } else { set };
        for (map, cell) in rows[0][1..].iter().zip(&row[1..]) {
            let differences = differences("map-rule", &format!("{map}, {rays}"), &format!("random, {map}"));
            let mean = differences[set].iter().sum::<f64>() / differences[set].len() as f64;
            let said: f64 = cell.trim_matches('*').split(' ').next().unwrap().parse().unwrap();
            assert!((said - mean).abs() <= 0.06, "{row:?}: {mean}");
        }
    }
}

/// Every planner in the paper's protocol, on the page of the reproduction and in docs/results.md.
#[test]
fn table_1_is_that_of_the_data() {
    let measured = data("short-paper-1/statistics.csv");
    let said = rows(PAGE, "| | coverage, % | skill | median |");
    let variants: BTreeSet<&String> = measured.iter().map(|row| &row["variant"]).collect();
    assert_eq!((said.len(), variants.len()), (27, 27));
    for (name, said) in &said {
        let of = |measure| statistic(&measured, name, measure);
        let skill = of("skill");
        assert_eq!([said[1], said[2]], [mean_and_interval(skill), skill["median"].clone()], "{name}");
        let means = ["voxel coverage, %", "reachable coverage, %", "IoU of the map, %"]
            .map(|measure| mean(of(measure)));
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
const REACHES: [&str; 3] = ["whole", "hemisphere", "half"];

/// All planners under the protocol of PB-NBV, and beside what that publishes.
#[test]
fn the_protocol_of_pb_nbv_is_that_of_the_data() {
    let rows = data("pb-nbv.csv");
    let measured = |reach: &str, variant: &str| {
        let row = rows.iter().find(|row| row["reach"] == reach && row["variant"] == variant).unwrap();
        let [mean, low, high] = ["", "_low", "_high"].map(|part| &row[&format!("surface_5mm{part}_percent")]);
        format!("{mean} ({low} to {high})")
    };
    let all = table(PROTOCOLS, "| | all around | upper hemisphere | half |");
    assert_eq!((all.len(), rows.len()), (27, 78));
    for row in &all[1..] {
        assert_eq!(row[1..], REACHES.map(|reach| measured(reach, row[0])), "{}", row[0]);
    }
    for row in &table(PROTOCOLS, "| % of the surface after ten views |")[1..] {
        let reach = all[0][1..].iter().position(|reach| row[3].starts_with(reach));
        let name = if row[0].starts_with("max-flow") { row[0].to_owned() } else { row[0].to_lowercase() };
        let here = reach.map_or("-".to_owned(), |reach| measured(REACHES[reach], &name));
        assert_eq!(row[2], here, "{row:?}");
    }
}

/// The objects that no planner was developed with, under the protocol of PB-NBV.
#[test]
fn the_means_over_test_objects_are_those_of_the_data() {
    const OBJECTS: [&str; 5] =
        ["lm_obj_000001_ape", "lm_obj_000012_holepuncher", "bunny", "dragon", "xyzrgb_dragon"];
    let rows = data("pb-nbv-objects.csv");
    let said = table(PROTOCOLS, "| mean over five test objects, % |");
    for (column, reach) in REACHES.into_iter().enumerate() {
        for said in &said[1..] {
            let of_planner = rows.iter().filter(|row| row["reach"] == reach && row["variant"] == said[0]);
            let of_objects = of_planner.filter(|row| OBJECTS.contains(&&*row["object"]));
            let shares: Vec<f64> =
                of_objects.map(|row| row["surface_5mm_percent"].parse().unwrap()).collect();
            assert_eq!(shares.len(), 5);
            let mean = shares.iter().sum::<f64>() / 5.0;
            // The entries of the data are rounded, too.
            let share: f64 = said[column + 1].parse().unwrap();
            assert!((share - mean).abs() < 0.1 + 1e-9, "{}, {reach}: {share}, {mean}", said[0]);
        }
    }
}

/// All planners under the protocol of ObjView-Bench.
#[test]
fn the_protocol_of_objview_is_that_of_the_data() {
    let measured = data("objview.csv");
    let said = table(PROTOCOLS, "| | NSC@.02 after 5 moves, % |");
    assert_eq!((said.len(), measured.len()), (27, 26));
    for said in &said[1..] {
        let row = measured.iter().find(|row| row["variant"] == said[0]).unwrap();
        let share = |n_moves: usize| {
            let [mean, lowest] =
                ["", "_lowest"].map(|part| &row[&format!("nsc_02_after_{n_moves}{part}_percent")]);
            format!("{mean} ({lowest})")
        };
        assert_eq!(
            said[1..],
            [share(5), share(10), share(30), row["path_after_10_radii"].clone()],
            "{}",
            said[0]
        );
    }
}

/// The rows of a file by setting and variant.
fn by_setting(file: &str) -> BTreeMap<(String, String), Row> {
    data(file).into_iter().map(|row| ((row["setting"].clone(), row["variant"].clone()), row)).collect()
}

/// A setting as the data name it.
fn setting(said: &str) -> String {
    said.replace(" mm", "mm").replace(" cm", "cm").replace(", ", "-")
}

/// All planners in eight settings.
#[test]
fn the_planners_are_said_to_be_what_was_measured() {
    let (_, page) = PLANNER.split_once("## All planners").unwrap();
    let all = table(page, "| | 5 mm | 1 cm |");
    let measured = by_setting("settings.csv");
    assert_eq!((all.len(), all[0].len(), measured.len()), (27, 9, 26 * 8));
    for (column, heading) in all[0].iter().enumerate().skip(1) {
        for row in &all[1..] {
            let of = &measured[&(setting(heading), row[0].to_owned())];
            let said = format!("{} ({})", unsigned(&of["skill"]), of["lowest_skill"]);
            assert_eq!(row[column], said, "{}, {heading}", row[0]);
        }
    }
}

/// The default planner with five first views in six settings.
#[test]
fn the_default_planner_is_said_to_be_what_was_measured() {
    let said = rows(PLANNER, "| most-surface | skill | lowest | views to 95 % |");
    let measured = by_setting("default.csv");
    assert_eq!((said.len(), measured.len()), (6, 6));
    for (heading, said) in said {
        let of = &measured[&(setting(heading), "most-surface".to_owned())];
        let skill = format!("{} ({} to {})", of["skill"], of["skill_low"], of["skill_high"]);
        let lowest = format!("{} ({})", of["lowest_skill"], of["lowest_object"]);
        let others = [&of["views_to_95"], &of["reachable_coverage_percent"]];
        assert_eq!(said[..2], [skill, lowest], "{heading}");
        assert_eq!(said[2..4], others, "{heading}");
    }
}

/// The campaigns at the beginning of README.md and docs/results.md.
fn headline() -> [Vec<Row>; 2] {
    ["headline-5mm", "headline-5mm-table-noise"].map(|name| data(&format!("{name}/statistics.csv")))
}

#[test]
fn the_readme_says_what_was_measured() {
    let readme = rows(README, "| planner | views to 95 %, all around |");
    assert!(["random", "even-views"].iter().all(|name| readme.contains_key(name)));
    let measured = headline();
    let reality = rows(include_str!("../../../docs/reality.md"), "| | skill, mean | lowest |");
    for (name, said) in readme {
        let said: Vec<_> = said.iter().map(|cell| cell.trim_matches('*')).collect();
        let name = name.split([':', ',']).next().unwrap();
        let until = views(statistic(&measured[0], name, "views to 95 %"));
        let [around, noisy] = measured.each_ref().map(|rows| mean(statistic(rows, name, "skill")));
        let share = reality.get(name).map(|row| 100.0 * row[2].parse::<f64>().unwrap());
        let share = share.map(|share| format!("{share:.1}")).unwrap_or_default();
        assert_eq!(said[..4], [until, around, noisy, share], "{name}");
    }
}

/// docs/results.md and docs/planner.md begin with what these campaigns measured, the lowest objects included.
#[test]
fn the_first_tables_are_those_of_the_campaigns() {
    let results = rows(RESULTS, "| planner | 5 mm, all around | lowest |");
    let (_, mut page) = PLANNER.split_once("## Beside other planners").unwrap();
    for (setting, measured) in headline().iter().enumerate() {
        let said = rows(page, "| | skill | median | lowest |");
        page = page.split_once("| | skill | median | lowest |").unwrap().1;
        assert!(said.len() >= 7 && said.len() == results.len());
        for (name, said) in said {
            let of = |measure: &str| statistic(measured, name, measure);
            let skill = of("skill");
            let [mean_skill, lowest] = [mean_and_interval(skill), worst(skill)];
            assert_eq!(said[..3], [&*mean_skill, &*skill["median"], &*lowest], "{name}, {setting}");
            assert_eq!(results[name][2 * setting..][..2], [mean_skill, lowest], "{name}, {setting}");
            let until = ["90", "95", "99"].map(|share| views(of(&format!("views to {share} %"))));
            let others = ["reachable coverage, %", "IoU of the map, %"].map(|measure| mean(of(measure)));
            assert_eq!(said[3..8], [&until[..], &others[..]].concat(), "{name}, {setting}");
        }
    }
}
