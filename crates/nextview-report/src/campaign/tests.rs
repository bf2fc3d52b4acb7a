use super::comparison_text;
use super::synthetic::{Campaign, campaign, record_mut};
use nextview_campaign::statistics::{Comparison, compare};
use nextview_campaign::{RunRecord, RunResult};
use nextview_scan::{PlannerName, ScanConfig};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

fn compared(a: &Campaign, b: &Campaign) -> Comparison {
    a.stored(|a| b.stored(|b| compare(a, b).unwrap()))
}

/// The pages.
fn campaign_report(campaign: &Campaign) -> [String; 2] {
    let mut files = files(campaign);
    ["report.html", "report.md"].map(|name| files.remove(name).unwrap())
}

/// All files.
fn files(campaign: &Campaign) -> BTreeMap<&'static str, String> {
    let files = campaign.stored(|campaign| super::campaign_report(campaign).unwrap());
    assert_eq!(files.iter().map(|(name, _)| *name).collect::<Vec<_>>(), super::CAMPAIGN_REPORT_FILES);
    files.into_iter().collect()
}

/// Writes a page into the temporary folder for inspection.
fn write(name: &str, page: &str) {
    std::fs::write(std::env::temp_dir().join(name), page).unwrap();
}

/// Four variants, a failed run, a run with two seeds, one that stopped early.
fn varied() -> Campaign {
    let mut campaign = campaign(&["random", "rse", "apora", "max-flow"], 6);
    campaign.runs[3].result = RunResult::Failed("the box needs 9000 MB | more than 4096".to_owned());
    record_mut(&mut campaign.runs[8]).steps.truncate(6);
    let mut again = campaign.runs[9].clone();
    again.seed = 1;
    record_mut(&mut again)
        .steps
        .iter_mut()
        .for_each(|step| step.voxel_coverage = step.voxel_coverage.map(|c| 0.97 * c));
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

/// The Markdown of a synthetic campaign must equal `golden.md`. After an intended change, check the file that
/// the test writes into the temporary folder, and keep it.
#[test]
fn the_report_is_as_it_was() {
    let [html, markdown] = campaign_report(&varied());
    write("nextview-made-up.html", &html);
    write("nextview-made-up.md", &markdown);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/campaign/golden.md");
    let golden = std::fs::read_to_string(path).unwrap_or_default();
    for (is, was) in markdown.lines().zip(golden.lines()) {
        assert_eq!(is, was);
    }
    assert_eq!(markdown.len(), golden.len());
}

#[test]
fn both_forms_show_the_same_numbers() {
    let [html, markdown] = campaign_report(&varied());
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

/// Each number of the page is in a file, and each of the files on the page.
#[test]
fn the_files_have_the_numbers_of_the_page() {
    let mut files = files(&varied());
    let [_, markdown] = ["report.html", "report.md"].map(|name| files.remove(name).unwrap());
    let setup = files.remove("setup.csv").unwrap();
    assert!(
        setup.starts_with("variant,parameter,value\n,runs,\"") && setup.contains("\nrse,planner,rse\n"),
        "{setup}"
    );
    let numbers = |text: &str| -> BTreeSet<String> {
        let words = text.split(|c: char| !c.is_ascii_digit() && c != '.');
        words.filter(|word| word.contains('.') && word.len() > 2).map(str::to_owned).collect()
    };
    let (_, page) = markdown.split_once("## Progress").unwrap();
    // Without what the paper published.
    let own = page.lines().filter(|line| line.starts_with('|') && !line.starts_with("| **the paper's"));
    let own = own.flat_map(|line| line.split('|')).map(|cell| cell.split("(paper ").next().unwrap());
    let own = own.collect::<Vec<_>>().join("|");
    let data: String = files.values().map(String::as_str).collect();
    let (shown, kept) = (numbers(&own), numbers(&data));
    assert_eq!(shown.difference(&kept).collect::<Vec<_>>(), Vec::<&String>::new(), "only on the page");
    let page = numbers(page);
    assert_eq!(kept.difference(&page).collect::<Vec<_>>(), Vec::<&String>::new(), "only in the files");
}

#[test]
fn the_page_is_whole_and_loads_nothing() {
    for campaign in [varied(), of_gamma(&[0.0, 0.25, 0.5, 0.75, 1.0]), campaign(&["max-flow"], 1)] {
        let [html, _] = campaign_report(&campaign);
        for word in ["http://", "https://", "@import", "url(", "<script", "NaN", "inf "] {
            assert!(!html.contains(word), "{word}");
        }
        for tag in ["section", "table", "tr", "div", "svg", "g", "figure", "details", "small"] {
            let opened =
                html.matches(&format!("<{tag}>")).count() + html.matches(&format!("<{tag} ")).count();
            assert_eq!(opened, html.matches(&format!("</{tag}>")).count(), "{tag}");
        }
        assert_eq!(campaign_report(&campaign), campaign_report(&campaign));
    }
}

/// Lengths and shares whose sums overflow are dashes with a reason.
#[test]
fn no_page_shows_what_is_no_number() {
    let campaign = changed(&campaign(&["apora", "max-flow", "random"], 6), |run| {
        let record = record_mut(run);
        record.skill = Some(f64::MAX);
        record.random_curve = Some(vec![-f64::MAX; 10]);
        for step in &mut record.steps {
            (step.path_length_m, step.trajectory_time_s) = (f64::MAX, f64::MAX);
            (step.voxel_coverage, step.reachable_coverage) = (Some(f64::MAX), Some(f64::MAX));
            (step.plan_time_ms, step.entropy_share) = (f64::MAX, f64::MAX);
        }
    });
    for page in campaign_report(&campaign) {
        for word in ["inf", "NaN"] {
            let is_number = |at: usize| !page[at + word.len()..].starts_with(char::is_alphabetic);
            let mut places = page.match_indices(word).map(|(at, _)| at).filter(|&at| is_number(at));
            assert!(places.next().is_none(), "{word} in {page}");
        }
        assert!(page.contains("too large for a number"));
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
    let [html, _] = campaign_report(&campaign);
    assert!(!html.contains("<script") && html.contains("{{style}}"));
}

#[test]
fn a_parameter_study_makes_the_papers_table() {
    let [_, markdown] = campaign_report(&of_gamma(&[0.5, 0.0, 1.0]));
    write("nextview-gamma.html", &campaign_report(&of_gamma(&[0.0, 0.25, 0.5, 0.75, 1.0]))[0]);
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
            run.config.planner = PlannerName::Apora.into();
        }
        configure[run.variant.rsplit(' ').next().unwrap().parse::<usize>().unwrap()](&mut run.config);
    }
    let [_, markdown] = campaign_report(&campaign);
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
                config.multi_resolution.coarsest_voxel_size = Some(0.04);
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
fn scans_without_a_cloud_leave_out_its_columns() {
    let without = changed(&varied(), |run| {
        if let RunResult::Done(done) = &mut run.result {
            done.record.set_cloud(None);
        }
    });
    let [with, without] = [varied(), without].map(|campaign| campaign_report(&campaign)[1].clone());
    let column = "accuracy of the cloud, mm";
    assert!(with.contains(column) && !without.contains(column));
}

#[test]
fn all_runs_failed_is_still_a_report() {
    let mut campaign = campaign(&["a", "b"], 2);
    for run in &mut campaign.runs {
        run.result = RunResult::Failed("no luck".to_owned());
    }
    let [html, markdown] = campaign_report(&campaign);
    assert!(html.contains("no luck") && markdown.contains("0 done, 4 failed") && !html.contains("<svg"));
}

/// The campaign with every run changed by `change`.
fn changed(a: &Campaign, change: impl Fn(&mut RunRecord)) -> Campaign {
    let mut b = a.clone();
    b.runs.iter_mut().for_each(change);
    b
}

#[test]
fn equal_campaigns_are_identical_apart_from_times() {
    let a = varied();
    let b = changed(&a, |run| {
        if let RunResult::Done(done) = &mut run.result {
            done.extra_memory_mb = None;
            done.record.steps.iter_mut().for_each(|step| step.plan_time_ms *= 3.0);
        }
    });
    let comparison = compared(&a, &b);
    assert!(comparison.is_identical() && comparison.n_pairs == a.runs.len());
    let text = comparison_text(&comparison, "a", "b");
    assert!(text.contains("identical apart from times") && text.contains("x 3.00"), "{text}");
    assert!(comparison.variants.iter().all(|v| v.better.is_empty() && v.worse.is_empty()));
}

#[test]
fn differences_are_found_and_judged() {
    let a = campaign(&["apora", "max-flow"], 6);
    let mut b = changed(&a, |run| {
        let shift = if run.object == "mug" { -0.02 } else { 0.01 };
        if run.variant == "apora" {
            record_mut(run).steps.iter_mut().for_each(|step| step.path_length_m -= 0.5);
        } else {
            record_mut(run)
                .steps
                .iter_mut()
                .for_each(|step| step.voxel_coverage = step.voxel_coverage.map(|c| c + shift));
        }
    });
    b.runs.remove(6);
    b.runs[0].result = RunResult::Failed("x".to_owned());
    let comparison = compared(&a, &b);
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
    write("nextview-compare.txt", &comparison_text(&comparison, "a", "b"));
    serde_json::to_string(&comparison).unwrap();
}

#[test]
fn two_single_variants_are_compared_with_each_other() {
    let (a, b) = (campaign(&["apora"], 4), campaign(&["rse"], 6));
    let comparison = compared(&a, &b);
    assert_eq!((comparison.n_pairs, comparison.only_in_b.len()), (4, 2));
    assert!(comparison_text(&comparison, "a", "b").contains("apora (A) against rse (B), 4 objects"));
    let comparison = compared(&campaign(&["x", "y"], 1), &b);
    assert_eq!((comparison.n_pairs, comparison.variants.len()), (0, 0));
}

/// The campaign with `n_seeds` seeds, and with `n_objects` objects in place of each.
fn multiplied(campaign: &Campaign, n_seeds: u64, n_objects: usize) -> Campaign {
    let copies = campaign.runs.iter().flat_map(|run| {
        let of_object = move |i| RunRecord { object: format!("{}-{i}", run.object), ..run.clone() };
        (0..n_objects)
            .map(of_object)
            .flat_map(move |run| (0..n_seeds).map(move |seed| RunRecord { seed, ..run.clone() }))
    });
    Campaign { runs: copies.collect(), ..campaign.clone() }
}

/// A page of half a million runs must open in a browser: it is as small as that of few runs, without a row
/// for each of many objects.
#[test]
fn the_page_of_many_runs_is_as_small_as_that_of_few() {
    let few = campaign(&["apora", "max-flow"], 6);
    let size = |n_seeds, n_objects| {
        let campaign = multiplied(&few, n_seeds, n_objects);
        campaign_report(&campaign).map(|text| text.len())
    };
    let of_few = size(3, 1);
    // 24,000 runs, and 12,000 objects.
    for of_many in [size(2000, 1), size(1, 2000)] {
        for (few, many) in of_few.into_iter().zip(of_many) {
            assert!(many < few + 20_000, "{many} bytes, {few} of a few runs");
        }
    }
}
