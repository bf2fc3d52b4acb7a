//! The report page, from made-up scans.

#[cfg(test)] // lets Clippy know that its `unwrap`s are those of a test
mod made_up;

use glam::{DVec3, Vec3};
use nextview::sensor::DepthImage;
use nextview_cli::report::render;

/// Writes the page to look at it: the path is printed.
#[test]
fn a_whole_page() {
    let page = render(&made_up::report(10, 640));
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("report.html");
    std::fs::write(&path, &page).unwrap();
    eprintln!("{} bytes in {}", page.len(), path.display());
    assert!(page.len() < 3_000_000);
    assert!(page.contains("<title>vase_with_ring.obj – nextview scan</title>"));
    assert_eq!(page.matches("<img ").count(), 10);
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 10);
}

#[test]
fn nothing_is_loaded_from_elsewhere() {
    let page = render(&made_up::report(2, 64));
    for word in ["http://", "https://", "@import", "url(", "srcset", "<iframe", "fetch(", "XMLHttp"] {
        assert!(!page.contains(word), "the page contains {word}");
    }
    for attribute in ["src=\"", "href=\""] {
        assert!(page.split(attribute).skip(1).all(|rest| rest.starts_with("data:")), "{attribute}");
    }
    assert!(page.contains("default-src 'none'"));
}

#[test]
fn equal_reports_give_equal_bytes() {
    assert_eq!(render(&made_up::report(3, 64)), render(&made_up::report(3, 64)));
}

#[test]
fn names_are_text_and_not_markup() {
    let evil = "<script>alert(1)</script>\"'&{{config}}";
    let mut report = made_up::report(2, 64);
    for text in [
        &mut report.object,
        &mut report.planner,
        &mut report.profile,
        &mut report.stop_reason,
        &mut report.command,
        &mut report.config,
    ] {
        *text = evil.to_owned();
    }
    report.summary = vec![(evil.to_owned(), evil.to_owned())];
    report.random.as_mut().unwrap().band = evil.to_owned();
    let page = render(&report);
    assert!(!page.contains("<script>alert"));
    let escaped = "&lt;script&gt;alert(1)&lt;/script&gt;&quot;&#39;&amp;{{config}}";
    assert_eq!(
        page.matches(escaped).count(),
        11,
        "title, heading, subtitle 3, legend 2, summary 2, command, config"
    );
}

#[test]
fn a_scan_without_baselines_and_coverage_has_no_empty_parts() {
    let mut report = made_up::report(3, 64);
    report.random = None;
    report.clairvoyant = None;
    let page = render(&report);
    assert!(
        page.contains("this scan") && !page.contains("random views") && !page.contains("knows the object")
    );
    for step in &mut report.steps {
        step.coverage = None;
    }
    let page = render(&report);
    assert!(page.contains("Coverage is not known") && !page.contains("<svg"));
}

#[test]
fn a_scan_of_one_view_or_none_is_a_page() {
    assert!(render(&made_up::report(1, 64)).contains("after view"));
    let page = render(&made_up::report(0, 64));
    assert!(page.contains("No view was taken") && !page.contains("NaN"));
}

#[test]
fn numbers_that_are_none_do_not_reach_the_page() {
    let mut report = made_up::report(3, 64);
    report.candidates.push(DVec3::NAN);
    let step = &mut report.steps[1];
    step.points.push(Vec3::new(0.0, f32::INFINITY, 0.0));
    step.coverage = Some(f64::NAN);
    step.plan_time = f64::NAN;
    step.travel = f64::INFINITY;
    step.path = vec![DVec3::ZERO, DVec3::NAN];
    step.depth = DepthImage::from_metres(4, 1, vec![f32::NAN, f32::INFINITY, 0.0, 1.0]).unwrap();
    report.random.as_mut().unwrap().mean[0] = f64::NAN;
    let page = render(&report);
    let (html, _) = page.split_once("<script>").unwrap();
    assert!(!html.contains("NaN") && !html.contains("inf,") && !html.contains("inf]"));
}

#[test]
fn images_without_surface_and_an_empty_cloud_are_fine() {
    let mut report = made_up::report(2, 64);
    for step in &mut report.steps {
        step.points.clear();
        step.depth = DepthImage::from_metres(2, 2, vec![f32::NAN; 4]).unwrap();
    }
    let page = render(&report);
    assert!(page.contains("\"points\":\"\"") && page.contains("no measurement"));
}

#[test]
fn a_huge_cloud_stays_below_3_mb() {
    let mut report = made_up::report(2, 64);
    report.steps[0].points = (0..2_000_000).map(|i| Vec3::new(i as f32, (i % 7) as f32, 1.0)).collect();
    let page = render(&report);
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
    assert!(page.contains("Shown are 150\u{202f}000 of 2\u{202f}00"));
}
