use super::*;
use crate::bench::{RunRecord, RunResult};
use crate::scan::{PlannerName, ScanConfig};
use made_up::{campaign, measures_mut};
use std::path::Path;

/// Writes the page to look at it: the path is printed.
fn write(name: &str, page: &str) {
    let path = std::env::temp_dir().join(name);
    std::fs::write(&path, page).unwrap();
    eprintln!("{} bytes in {}", page.len(), path.display());
}

/// Four variants, a failed run, a run with two seeds, one that stopped early.
fn varied() -> Campaign {
    let mut campaign = campaign(&["random", "rse", "apora", "max-flow"], 6);
    campaign.runs[3].result = RunResult::Failed("the box needs 9000 MB | more than 4096".to_owned());
    measures_mut(&mut campaign.runs[8]).steps.truncate(6);
    let mut again = campaign.runs[9].clone();
    again.seed = 1;
    measures_mut(&mut again).steps.iter_mut().for_each(|step| step.voxel_coverage *= 0.97);
    campaign.runs.push(again);
    campaign.torn = true;
    campaign
}

/// Variants of max-flow with these values of gamma.
fn of_gamma(values: &[f64]) -> Campaign {
    let names: Vec<String> = values.iter().map(|gamma| format!("gamma {gamma}")).collect();
    let mut campaign = campaign(&names.iter().map(String::as_str).collect::<Vec<_>>(), 3);
    for run in &mut campaign.runs {
        run.config.max_flow.gamma = run.variant.rsplit(' ').next().unwrap().parse().unwrap();
    }
    campaign
}

/// The Markdown of a made-up campaign is exactly what `golden.md` holds. After a change on purpose, look at it and write it
/// anew: the test writes what it should be into the temporary folder.
#[test]
fn the_report_is_as_it_was() {
    let [html, markdown] = report(&varied());
    write("nextview-made-up.html", &html);
    write("nextview-made-up.md", &markdown);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/study/golden.md");
    assert_eq!(markdown, std::fs::read_to_string(path).unwrap_or_default());
}

#[test]
fn both_forms_show_the_same_numbers() {
    let [html, markdown] = report(&varied());
    let numbers = |text: &str| -> Vec<String> {
        let words = text.split(|c: char| !c.is_ascii_digit() && c != '.');
        let mut words: Vec<String> =
            words.filter(|w| w.contains('.') && w.len() > 2).map(str::to_owned).collect();
        words.sort();
        words.dedup();
        words
    };
    let tables: String = html.split("<table").skip(1).map(|t| t.split("</table>").next().unwrap()).collect();
    let in_markdown = numbers(&markdown);
    for number in numbers(&tables) {
        assert!(in_markdown.contains(&number), "{number} is only in the HTML");
    }
}

#[test]
fn the_page_is_whole_and_loads_nothing() {
    for campaign in [varied(), of_gamma(&[0.0, 0.25, 0.5, 0.75, 1.0]), campaign(&["max-flow"], 1)] {
        let [html, _] = report(&campaign);
        for word in ["http://", "https://", "@import", "url(", "<script", "NaN", "inf "] {
            assert!(!html.contains(word), "{word}");
        }
        for tag in ["section", "table", "tr", "div", "svg", "g", "figure", "details", "small"] {
            let opened =
                html.matches(&format!("<{tag}>")).count() + html.matches(&format!("<{tag} ")).count();
            assert_eq!(opened, html.matches(&format!("</{tag}>")).count(), "{tag}");
        }
        assert_eq!(report(&campaign), report(&campaign));
    }
}

#[test]
fn names_are_text_and_not_markup() {
    let mut campaign = campaign(&["a"], 1);
    let evil = "<script>alert(1)</script>|{{style}}".to_owned();
    campaign.name.clone_from(&evil);
    let run = &mut campaign.runs[0];
    (run.object, run.data_set, run.variant) = (evil.clone(), evil.clone(), evil.clone());
    run.host.name.clone_from(&evil);
    let [html, _] = report(&campaign);
    assert!(!html.contains("<script") && html.contains("{{style}}"));
}

#[test]
fn a_parameter_study_makes_the_papers_table() {
    let [_, markdown] = report(&of_gamma(&[0.5, 0.0, 1.0]));
    write("nextview-gamma.html", &report(&of_gamma(&[0.0, 0.25, 0.5, 0.75, 1.0]))[0]);
    let (_, table) = markdown.split_once("Table IV").unwrap();
    let lines: Vec<&str> = table.lines().skip(2).take(3).collect();
    assert_eq!(lines[0], "| history | measure | γ = 0 | γ = 0.5 | γ = 1 |");
    assert!(lines[2].starts_with("| with history | voxel coverage, % | 9"), "{}", lines[2]);
    assert!(lines[2].contains("(paper 89.6)") && lines[2].contains("(paper 91.7)"));
    for other in ["Table III.", "Table V.", "Table VII."] {
        assert!(!markdown.contains(other), "{other}");
    }
}

/// The rows of the paper's table with this number, over these configurations of apora and max-flow.
fn rows_of(number: &str, configure: [fn(&mut ScanConfig); 3]) -> Vec<String> {
    let names: Vec<String> = ["apora", "max-flow"]
        .iter()
        .flat_map(|planner| (0..3).map(move |i| format!("{planner} {i}")))
        .collect();
    let mut campaign = campaign(&names.iter().map(String::as_str).collect::<Vec<_>>(), 3);
    for run in &mut campaign.runs {
        if run.variant.starts_with("apora") {
            run.config.planner = PlannerName::Apora;
        }
        configure[run.variant.rsplit(' ').next().unwrap().parse::<usize>().unwrap()](&mut run.config);
    }
    let [_, markdown] = report(&campaign);
    let (_, table) = markdown.split_once(&format!("Table {number}. ")).unwrap();
    table.lines().skip(2).take_while(|line| line.starts_with('|')).map(str::to_owned).collect()
}

#[test]
fn resolutions_thresholds_and_movement_have_their_tables() {
    let rows = rows_of(
        "III",
        [
            |_| (),
            |config| config.multi_resolution.enabled = true,
            |config| {
                config.multi_resolution.enabled = true;
                config.multi_resolution.coarsest_voxel_size_m = Some(0.04);
            },
        ],
    );
    let columns = ["single", "multi from 0.04 m", "multi"].map(|name| format!("multi-resolution = {name} |"));
    assert_eq!(rows[0], format!("| method | measure | {}", columns.join(" ")));
    assert!(
        rows[2].starts_with("| APORA | voxel coverage, %") && rows[2].contains("(paper 88.9)"),
        "{rows:?}"
    );
    assert!(rows[5].starts_with("| Ours | computing time") && rows[5].contains("(paper 6.972)"), "{rows:?}");

    let rows = rows_of(
        "V",
        [
            |config| config.multi_resolution.q_thresh = 0.0,
            |config| config.multi_resolution.q_thresh = 0.5,
            |config| config.multi_resolution.q_thresh = 1.0,
        ],
    );
    assert_eq!(rows[0], r"| method | measure | q\_thresh = 0 | q\_thresh = 0.5 | q\_thresh = 1 |");
    assert!(rows[3].contains("(paper 92.6)") && rows[3].contains("(paper 93)"), "{rows:?}");

    let rows = rows_of(
        "VII",
        [
            |config| (config.max_flow.theta, config.greedy.theta) = (0.0, 0.0),
            |config| (config.max_flow.theta, config.greedy.theta) = (0.5, 0.5),
            |config| (config.max_flow.theta, config.greedy.theta) = (1.0, 1.0),
        ],
    );
    assert_eq!(rows[0], "| method | measure | θ = 0 | θ = 0.5 | θ = 1 |");
    assert!(rows.iter().any(|row| row.contains("(paper 48.7)")), "{rows:?}");
}

#[test]
fn campaigns_without_ways_have_no_running_times() {
    let old = changed(&varied(), |run| {
        if let RunResult::Done(measures) = &mut run.result {
            measures.steps.iter_mut().for_each(|step| (step.way_m, step.move_time_s) = (None, None));
        }
    });
    let [_, markdown] = report(&old);
    assert!(markdown.contains("Table II.") && !markdown.contains("Table VI") && !markdown.contains("robot"));
    assert!(compare(&varied(), &old).is_identical(), "all that both measured is the same");
}

#[test]
fn campaigns_of_old_have_no_cloud() {
    let mut old = varied();
    for run in &mut old.runs {
        if let RunResult::Done(measures) = &mut run.result {
            measures.cloud = None;
        }
        let line = serde_json::to_string(run).unwrap();
        assert!(!line.contains("cloud") && serde_json::from_str::<RunRecord>(&line).unwrap() == *run);
    }
    let [now, then] = [varied(), old].map(|campaign| report(&campaign)[1].clone());
    let column = "accuracy of the cloud, mm";
    assert!(now.contains(column) && !then.contains(column));
}

#[test]
fn all_runs_failed_is_still_a_report() {
    let mut campaign = campaign(&["a", "b"], 2);
    for run in &mut campaign.runs {
        run.result = RunResult::Failed("no luck".to_owned());
    }
    let [html, markdown] = report(&campaign);
    assert!(html.contains("no luck") && markdown.contains("0 done, 4 failed") && !html.contains("<svg"));
}

/// B with this done to its runs.
fn changed(a: &Campaign, change: impl Fn(&mut RunRecord)) -> Campaign {
    let mut b = a.clone();
    b.runs.iter_mut().for_each(change);
    b
}

#[test]
fn equal_campaigns_are_identical_apart_from_times() {
    let a = varied();
    let b = changed(&a, |run| {
        if let RunResult::Done(measures) = &mut run.result {
            measures.extra_memory_mb = None;
            measures.steps.iter_mut().for_each(|step| step.plan_time_ms *= 3.0);
        }
    });
    let comparison = compare(&a, &b);
    assert!(comparison.is_identical() && comparison.n_pairs == a.runs.len());
    let text = comparison.to_text("a", "b");
    assert!(text.contains("identical apart from times") && text.contains("x 3.00"), "{text}");
    assert!(comparison.variants.iter().all(|v| v.better.is_empty() && v.worse.is_empty()));
}

#[test]
fn differences_are_found_and_judged() {
    let a = campaign(&["apora", "max-flow"], 6);
    let mut b = changed(&a, |run| {
        let shift = if run.object == "mug" { -0.02 } else { 0.01 };
        if run.variant == "apora" {
            measures_mut(run).steps.iter_mut().for_each(|step| step.path_length_m -= 0.5);
        } else {
            measures_mut(run).steps.iter_mut().for_each(|step| step.voxel_coverage += shift);
        }
    });
    b.runs.remove(6);
    b.runs[0].result = RunResult::Failed("x".to_owned());
    let comparison = compare(&a, &b);
    assert!(!comparison.pairs_are_identical);
    assert_eq!((comparison.only_in_a.len(), comparison.only_in_b.len()), (1, 0));
    assert_eq!((comparison.failed_only_in_a.len(), comparison.failed_only_in_b.len()), (0, 1));
    let [apora, max_flow] = &comparison.variants[..] else { panic!() };
    assert_eq!((apora.n_objects, max_flow.n_objects), (5, 5));
    let path = apora.measures.iter().find(|m| m.name == "path length, m").unwrap();
    assert!(
        (path.difference + 0.5).abs() < 1e-9 && path.is_more_than_noise && path.b_is_better == Some(true)
    );
    let coverage = &max_flow.measures[0];
    assert!((coverage.difference - 0.4).abs() < 1e-9 && !coverage.is_more_than_noise);
    assert_eq!((max_flow.better.len(), max_flow.worse.len()), (4, 1));
    assert_eq!(max_flow.worse[0].0, "mug");
    write("nextview-compare.txt", &comparison.to_text("a", "b"));
    serde_json::to_string(&comparison).unwrap();
}

#[test]
fn two_single_variants_are_compared_with_each_other() {
    let (a, b) = (campaign(&["apora"], 4), campaign(&["rse"], 6));
    let comparison = compare(&a, &b);
    assert_eq!((comparison.n_pairs, comparison.only_in_b.len()), (4, 2));
    assert!(comparison.to_text("a", "b").contains("apora (A) against rse (B), 4 objects"));
    let comparison = compare(&campaign(&["x", "y"], 1), &b);
    assert_eq!((comparison.n_pairs, comparison.variants.len()), (0, 0));
}
