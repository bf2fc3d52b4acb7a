//! The tables in docs/reproduction are what this program finds: a few of their runs, done again.

use crate::common::{Folder, data};
use std::collections::BTreeMap;

/// Variants of table I with exact truth that are run again.
const VARIANTS: &str = "
name = 'table-1'

[scan]
profile = 'paper'
size_m = 0.2
voxel_size_m = 0.01
candidates = 1000
views = 10
baselines = false
stop.entropy_share = 0

[[variant]]
sweep.planner = ['max-flow', 'apora', 'rse']

[[variant]]
label = 'max-flow (default profile)'
scan.map.background = 'carve'
scan.max_flow = { free_space = 'clear', ray_spacing = 2 }
";

const TABLE_1: &str = include_str!("../../../../docs/reproduction/short-paper-1.md");

/// Final voxel coverage, %, as the report's table of objects has it.
fn reported(report: &str, object: &str, column: &str) -> String {
    let (_, table) = report.split_once("## Voxel coverage by object").unwrap();
    let plain = |cell: &str| cell.trim().replace('\\', "");
    let rows = table.lines().filter(|line| line.starts_with('|'));
    let mut rows = rows.map(|line| line.split('|').map(plain).collect::<Vec<_>>());
    let head = rows.next().unwrap();
    let position =
        head.iter().position(|name| name == column).unwrap_or_else(|| panic!("no {column}: {head:?}"));
    let row = rows.find(|row| row[1].split(" (").next() == Some(object)).unwrap();
    row[position].clone()
}

/// The last value of this column in each run of a campaign, by object and variant.
fn last_values(folder: &Folder, column: &str) -> BTreeMap<(String, String), f64> {
    let steps = folder.text("out/steps.csv");
    let mut rows = steps.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = rows.next().unwrap();
    let at = |name: &str| head.iter().position(|cell| *cell == name).unwrap();
    let (object, variant, column) = (at("object"), at("variant"), at(column));
    let key = |row: &[&str]| (row[object].to_owned(), row[variant].to_owned());
    rows.map(|row| (key(&row), row[column].parse().unwrap())).collect()
}

#[test]
fn reproduces_the_reported_coverage_of_a_part_and_a_bowl() {
    let test = "reproduces_the_reported_coverage_of_a_part_and_a_bowl";
    let files = ["tless/tless_06", "ycb/ycb_024_bowl"].map(|name| data(test, &format!("meshes/{name}.ply")));
    let [Some(part), Some(bowl)] = files else { return };
    let folder = Folder::new("reproduction-table-1");
    folder.write("spec.toml", VARIANTS);
    folder.ok(&["bench", "spec.toml", part.to_str().unwrap(), bowl.to_str().unwrap(), "--out", "out"]);
    let found = last_values(&folder, "voxel_coverage");
    assert_eq!(found.len(), 8);
    for ((object, variant), coverage) in found {
        let coverage = format!("{:.1}", 100.0 * coverage);
        assert_eq!(coverage, reported(TABLE_1, &object, &variant), "{object}, {variant}");
    }
}

/// A hollow test object, at 5 mm.
#[test]
fn reproduces_the_skill_of_the_default_planner() {
    let object = "ycb_019_pitcher_base";
    let test = "reproduces_the_skill_of_the_default_planner";
    let Some(mesh) = data(test, &format!("meshes/ycb/{object}.ply")) else { return };
    let folder = Folder::new("reproduction-planner");
    let spec = include_str!("../../../../benchmarks/planners/all.toml");
    let (head, _) = spec.split_once("[[variant]]").unwrap();
    let keys = "voxel_size_m = 0.005\n[[variant]]\nscan.planner = 'most-surface'\n";
    folder.write("spec.toml", format!("{}\n{keys}", head.trim_end()));
    folder.ok(&["bench", "spec.toml", mesh.to_str().unwrap(), "--out", "out"]);
    let runs = folder.text("out/runs.jsonl");
    let run: serde_json::Value = serde_json::from_str(runs.lines().next().unwrap()).unwrap();
    let skill = format!("{:.2}", run["result"]["done"]["record"]["skill"].as_f64().unwrap());
    assert_eq!(rows(SETTINGS, "| object | 5mm |")[object][0].split(' ').next(), Some(&*skill));
}

/// The planner of PB-NBV under its own protocol, on the object that it covers least of.
#[test]
fn reproduces_the_lowest_object_of_pb_nbv() {
    let report = include_str!("../../../../docs/reproduction/pb-nbv.md");
    let said = rows(report, "| planner |")["pb-nbv"][1];
    let (coverage, object) = said.trim_end_matches(')').split_once(" (").unwrap();
    let test = "reproduces_the_lowest_object_of_pb_nbv";
    let Some(mesh) = data(test, &format!("meshes/lm/{object}.ply")) else { return };
    let folder = Folder::new("reproduction-pb-nbv");
    let spec = include_str!("../../../nextview-campaign/src/spec/specs/pb-nbv.toml");
    let (head, _) = spec.split_once("[[variant]]").unwrap();
    folder.write("spec.toml", format!("{head}[[variant]]\nscan.planner = 'pb-nbv'\n"));
    folder.ok(&["bench", "spec.toml", mesh.to_str().unwrap(), "--out", "out"]);
    let found = last_values(&folder, "surface_coverage_5mm").into_values().next().unwrap();
    assert_eq!(format!("{:.1}", 100.0 * found), coverage);
}

/// The cells of the first table of this head, by the name in the first cell.
fn rows<'a>(text: &'a str, head: &str) -> BTreeMap<&'a str, Vec<&'a str>> {
    let (_, table) = text.split_once(head).unwrap_or_else(|| panic!("no table {head}"));
    let lines = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    let cells = |line: &'a str| line.split('|').map(str::trim).collect::<Vec<_>>();
    lines.map(cells).map(|cells| (cells[1], cells[2..].to_vec())).collect()
}

/// All planners in eight settings.
const SETTINGS: &str = include_str!("../../../../docs/planner/settings.md");

/// The table of all planners in docs/planner.md is that of the campaigns.
#[test]
fn the_planners_are_said_to_be_what_was_measured() {
    let (_, page) = include_str!("../../../../docs/planner.md").split_once("## All planners").unwrap();
    let all = rows(page, "| | 5 mm | 1 cm |");
    assert_eq!(all.len(), 26);
    let head = page.lines().find(|line| line.starts_with("| | 5 mm | 1 cm |")).unwrap();
    let settings: Vec<&str> = head.trim_matches(['|', ' ']).split(" | ").collect();
    assert_eq!(settings.len(), 8);
    let first = |cell: &'static str| cell.split(' ').next().unwrap();
    for (i, setting) in settings.into_iter().enumerate() {
        let heading = setting.replace(" mm", "mm").replace(" cm", "cm").replace(", ", "-");
        let (_, table) = SETTINGS.split_once(&format!("\n## {heading}\n")).unwrap();
        let measured = rows(table, "|  | skill | lowest |");
        assert_eq!(measured.len(), all.len());
        for (name, cells) in &all {
            let said = format!("{} ({})", first(measured[name][0]), first(measured[name][1]));
            assert_eq!(cells[i], said, "{name}, {setting}");
        }
    }
}

/// The default planner with five first views is said to be what its page has for each setting.
#[test]
fn the_default_planner_is_said_to_be_what_was_measured() {
    const DEFAULT: &str = include_str!("../../../../docs/planner/default.md");
    let page = include_str!("../../../../docs/planner.md");
    let said = rows(page, "| most-surface | skill | lowest | views to 95 % |");
    assert_eq!(said.len(), 6);
    for (setting, said) in said {
        let heading = setting.replace(" mm", "mm").replace(" cm", "cm").replace(", ", "-");
        let (_, table) = DEFAULT.split_once(&format!("\n## {heading}\n")).unwrap();
        let measured = rows(table, "|  | skill | lowest |").remove("most-surface").unwrap();
        let measured: Vec<String> = measured.iter().map(|cell| cell.replace('\\', "")).collect();
        assert_eq!(said[..4], measured[..4], "{setting}");
    }
}

/// The reports of the campaigns that README.md and docs/results.md begin with.
const HEADLINE: [&str; 2] = [
    include_str!("../../../../docs/planner/headline-5mm.md"),
    include_str!("../../../../docs/planner/headline-5mm-table-noise.md"),
];

/// The mean in a report's cell.
fn mean(cell: &str) -> &str {
    match cell.trim_start_matches("≥ ").split(' ').next().unwrap() {
        "-0.00" => "0.00",
        mean => mean,
    }
}

/// The mean in a report's cell and its interval.
fn mean_and_interval(cell: &str) -> String {
    let (_, interval) = cell.split_once(' ').unwrap();
    format!("{} {})", mean(cell), interval.split(", median").next().unwrap())
}

/// The numbers at the head of README.md are those of the campaigns.
#[test]
fn the_readme_says_what_was_measured() {
    let reality = rows(include_str!("../../../../docs/reality.md"), "| | skill, mean | lowest |");
    let views = rows(HEADLINE[0], "| variant | 90 % | 95 % | 99 % |");
    let reached = HEADLINE.map(|report| rows(report, "| variant | objects | voxel coverage, % |"));
    let readme = rows(include_str!("../../../../README.md"), "| planner | views to 95 %, all around |");
    assert_eq!(readme.len(), 5);
    for (name, said) in readme {
        let said: Vec<_> = said.iter().map(|cell| cell.trim_matches('*')).collect();
        let name = name.trim_matches('*').split([':', ',']).next().unwrap();
        let [around, noisy] = [0, 1].map(|setting: usize| mean(reached[setting][name][3]));
        let share = reality.get(name).map(|row| 100.0 * row[2].parse::<f64>().unwrap());
        let share = share.map(|share| format!("{share:.1}")).unwrap_or_default();
        assert_eq!(said[..4], [mean(views[name][1]), around, noisy, &share], "{name}");
    }
}

/// docs/results.md and docs/planner.md begin with what these campaigns measured, the lowest objects included.
#[test]
fn the_first_tables_are_those_of_the_campaigns() {
    let results =
        rows(include_str!("../../../../docs/results.md"), "| planner | 5 mm, all around | lowest |");
    let (_, mut page) =
        include_str!("../../../../docs/planner.md").split_once("## Beside other planners").unwrap();
    for (setting, report) in HEADLINE.into_iter().enumerate() {
        let reached = rows(report, "| variant | objects | voxel coverage, % |");
        let (_, worst) = report.split_once("The worst object").unwrap();
        let worst = rows(worst, "| variant | voxel coverage, % |");
        let views = rows(report, "| variant | 90 % | 95 % | 99 % |");
        let has = rows(report, "| variant | precision of the map, % |");
        let said = rows(page, "| | skill | median | lowest |");
        page = page.split_once("| | skill | median | lowest |").unwrap().1;
        assert!(said.len() == 6 && results.len() == 6);
        for (name, said) in said {
            let skill = [mean_and_interval(reached[name][3]), worst[name][2].replace('\\', "")];
            assert_eq!([said[0], said[2]], skill, "{name}, {setting}");
            assert_eq!(results[name][2 * setting..][..2], skill, "{name}, {setting}");
            let others = [views[name][0], views[name][1], views[name][2]].into_iter();
            let others = others.chain([reached[name][2], has[name][2]]);
            assert_eq!(said[3..8], others.map(mean).collect::<Vec<_>>(), "{name}, {setting}");
        }
    }
}

#[test]
fn the_results_are_those_of_the_report() {
    let report = include_str!("../../../../docs/reproduction/paper-1.md");
    let (_, summary) = report.split_once("What was reached with the last view").unwrap();
    let cells = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let (_, table) = include_str!("../../../../docs/results.md")
        .split_once("| planner | voxel coverage, % | skill |")
        .unwrap();
    let rows: Vec<_> = table.lines().skip(2).take_while(|line| line.starts_with('|')).map(cells).collect();
    assert!(rows.len() > 5);
    for row in rows {
        let reported = summary.lines().map(cells).find(|line| line.get(1) == row.get(1)).unwrap();
        assert_eq!((&row[2], &row[3]), (&reported[3], &reported[5]), "{}", row[1]);
    }
}
