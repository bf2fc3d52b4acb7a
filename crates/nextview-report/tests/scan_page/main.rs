//! The page of a scan, from synthetic records.

#[cfg(test)] // lets Clippy know that its `unwrap`s are those of a test
mod synthetic;
#[cfg(test)]
mod walls;

use glam::{DVec3, IVec3, Vec3};
use nextview::sensor::DepthImage;
use nextview_report::{ViewPicture, live, summary, summary_text};
use nextview_scan::{BoxRule, HandEyeRecord, OtherBodyRecord, ScanRecord, TableRule};
use serde_json::Value;
use std::collections::HashSet;
use synthetic::{SyntheticRecording, scan};
use walls::{scene, walls};

/// Writes the page for inspection, and prints its path.
fn write(name: &str, page: &str) {
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, page).expect("the target folder is writable");
    eprintln!("{} bytes in {}", page.len(), path.display());
}

#[test]
fn a_whole_page() {
    let page = scan(10, 640).page();
    write("scan.html", &page);
    assert!(page.len() < 3_000_000);
    assert!(page.contains("<title>vase_with_ring – nextview scan</title>"));
    assert!(page.contains("stopped: <b>the view limit was reached</b>") && !page.contains("under way"));
    assert_eq!(page.matches("<img width").count(), 10);
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 10);
}

#[test]
fn nothing_is_loaded_from_elsewhere() {
    // The legend's colours, which are in the page.
    let page = scan(2, 64).page().replace("url(#depths)", "");
    for word in ["http://", "https://", "@import", "url(", "srcset", "<iframe", "fetch(", "XMLHttp"] {
        assert!(!page.contains(word), "the page contains {word}");
    }
    for attribute in ["src=\"", "href=\""] {
        assert!(page.split(attribute).skip(1).all(|rest| rest.starts_with("data:")), "{attribute}");
    }
    assert!(page.contains("default-src 'none'"));
}

#[test]
fn equal_scans_give_equal_bytes() {
    assert_eq!(scan(3, 64).page(), scan(3, 64).page());
}

#[test]
fn names_are_text_and_not_markup() {
    let evil = "<script>alert(1)</script>\"'&{{config}}";
    let mut scan = scan(2, 64);
    for text in [&mut scan.record.object, &mut scan.command, &mut scan.config_text] {
        *text = evil.to_owned();
    }
    // A frame that hit nothing is named in the summary.
    (scan.record.steps[1].frame, scan.record.steps[1].hit_voxels) = (Some(evil.to_owned()), 0);
    let page = scan.page();
    assert!(!page.contains("<script>alert"));
    let escaped = "&lt;script&gt;alert(1)&lt;/script&gt;&quot;&#39;&amp;{{config}}";
    assert_eq!(page.matches(escaped).count(), 5, "title, heading, summary, command, config");
}

#[test]
fn a_scan_under_way_is_a_page() {
    for n_views in 0..4 {
        let mut scan = scan(n_views, 64);
        scan.record.stop_reason = None;
        let page = scan.page();
        assert!(page.contains("<b>under way</b>") && !page.contains("stopped"), "{n_views} views");
        if n_views == 3 {
            write("scan-under-way.html", &page);
        }
        // The object is unknown, and there are no pictures yet.
        scan.record.steps.iter_mut().for_each(|step| {
            forget_truth(step);
            forget_estimate(step);
        });
        scan.record = ScanRecord { steps: scan.record.steps, ..ScanRecord::default() };
        scan.depths.clear();
        let page = scan.page();
        assert!(
            page.contains("under way") && page.contains("Coverage is not known") && !page.contains("NaN")
        );
    }
    assert!(scan(0, 64).page().contains("No view was taken.</p>"));
    let scan = SyntheticRecording { record: ScanRecord::default(), ..scan(0, 64) };
    assert!(scan.page().contains("No view was taken yet.</p>"));
}

fn forget_truth(step: &mut nextview_scan::StepRecord) {
    step.reachable_coverage = None;
    step.voxel_coverage = None;
    step.surface_coverage_2mm = None;
}

fn forget_estimate(step: &mut nextview_scan::StepRecord) {
    step.estimated_completeness = None;
}

#[test]
fn a_scan_without_baselines_and_coverage_has_no_empty_parts() {
    let mut scan = scan(3, 64);
    scan.record.random_curve = None;
    scan.record.random_low_curve = None;
    scan.record.random_high_curve = None;
    scan.record.clairvoyant_curve = None;
    scan.record.skill = None;
    let page = scan.page();
    assert!(
        page.contains("this scan") && !page.contains("random views") && !page.contains("knows the object")
    );
    scan.record.steps.iter_mut().for_each(|step| step.reachable_coverage = None);
    let page = scan.page();
    assert!(page.contains("surface within 2 mm, %") && page.contains("estimated by the planner"));
    scan.record.steps.iter_mut().for_each(forget_truth);
    assert!(scan.page().contains("estimated completeness, %"));
    scan.record.steps.iter_mut().for_each(forget_estimate);
    let page = scan.page();
    assert!(page.contains("Coverage is not known") && !page.contains("class=\"chart\""));
}

#[test]
fn a_scan_of_one_view_or_none_is_a_page() {
    assert!(scan(1, 64).page().contains("after view"));
    let page = scan(0, 64).page();
    assert!(page.contains("No view was taken") && !page.contains("NaN"));
}

#[test]
fn numbers_that_are_none_do_not_reach_the_page() {
    let mut scan = scan(5, 64);
    scan.candidates.push(DVec3::NAN);
    scan.points[1].push(Vec3::new(0.0, f32::INFINITY, 0.0));
    scan.paths[1] = vec![DVec3::ZERO, DVec3::NAN];
    scan.depths[1] = DepthImage::from_metres(4, 1, vec![f32::NAN, f32::INFINITY, 0.0, 1.0]).unwrap();
    scan.record.random_curve.as_mut().unwrap()[0] = f64::NAN;
    let step = &mut scan.record.steps[1];
    step.reachable_coverage = Some(f64::NAN);
    step.estimated_completeness = Some(f64::NAN);
    step.plan_time_ms = f64::NAN;
    step.path_length_m = f64::INFINITY;
    step.quaternion_xyzw = [f64::NAN; 4];
    let page = scan.page();
    let (html, _) = page.split_once("<script>").unwrap();
    assert!(!html.contains("NaN") && !html.contains("inf,") && !html.contains("inf]"));
}

#[test]
fn images_without_surface_and_an_empty_cloud_are_fine() {
    let mut scan = scan(2, 64);
    scan.points.iter_mut().for_each(Vec::clear);
    scan.depths.fill(DepthImage::from_metres(2, 2, vec![f32::NAN; 4]).unwrap());
    let page = scan.page();
    assert!(page.contains("\"data\":\"\"") && page.contains("no measurement"));
}

#[test]
fn a_huge_cloud_stays_below_3_mb() {
    let mut scan = scan(2, 64);
    scan.points[0] = (0..2_000_000).map(|i| Vec3::new(i as f32, (i % 7) as f32, 1.0)).collect();
    let page = scan.page();
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
    assert!(page.contains("100\u{202f}000 of 2\u{202f}00"));
}

#[test]
fn a_scan_that_stops_early_is_compared_with_as_many_views() {
    let SyntheticRecording { mut record, config, .. } = scan(4, 64);
    assert!(record.stop_reason.is_some());
    record.random_curve = Some(vec![0.1, 0.2, 0.3, 0.4, 0.5]);
    record.clairvoyant_curve = Some(vec![0.5, 0.6, 0.7, 0.8, 0.9]);
    let rows = summary(&record, &config);
    for (label, value) in [("  random views", "40.0 %"), ("  clairvoyant", "80.0 %")] {
        assert!(rows.contains(&(label.to_owned(), value.to_owned())), "{label}: {rows:?}");
    }
}

#[test]
fn the_summary_names_what_is_known() {
    let SyntheticRecording { mut record, mut config, .. } = scan(4, 64);
    let text = summary_text(&record, &config);
    let labels: Vec<&str> = text.lines().map(|line| line[..22].trim_end()).collect();
    let expected = [
        "views taken",
        "stopped because",
        "reachable coverage",
        "  random views",
        "  clairvoyant",
        "skill",
        "mean coverage",
        "voxel coverage",
        "false voxels",
        "map",
        "surface coverage 2 mm",
        "surface coverage 5 mm",
        "cloud",
        "  F-score",
        "path length",
        "trajectory",
        "planning time",
        "map update",
        "peak memory",
    ];
    assert_eq!(labels, expected);

    config.object_box.rule = BoxRule::Grows;
    config.object_box.table = TableRule::Fit;
    record.skipped = vec!["frame 7: no pose".to_owned()];
    (record.alignment_moved_mm, record.alignment_turned_deg) = (Some(3.2), Some(0.5));
    let last = record.steps.last_mut().unwrap();
    (last.box_min_m, last.box_max_m) = (Some([-0.1, -0.1, 0.002]), Some([0.1, 0.15, 0.182]));
    (last.table_normal, last.table_offset_m) = (Some([0.0, 0.0, 1.0]), Some(0.002));
    (last.frame, last.hit_voxels) = (Some("frame-9".to_owned()), 0);
    (last.accuracy_mean_mm, last.accuracy_median_mm, last.accuracy_p95_mm) =
        (Some(0.5), Some(0.4), Some(1.5));
    record.mesh_filled_share = Some(0.123);
    let rows = summary(&record, &config);
    for (label, value) in [
        ("filled in", "12.3 % of the mesh, which is watertight"),
        ("box found", "200 x 250 x 180 mm"),
        ("table found", "at z = 2.0 mm"),
        ("skipped", "1 of the recording"),
        ("nothing in the box", "frame-9"),
        ("accuracy", "mean 0.50 mm, median 0.40 mm, 95 % within 1.50 mm"),
        ("mean coverage", "77.4 % over the views, 70.2 % over 60 s"),
        ("  F-score", "90.2 % at 1 mm, 96.1 % at 2 mm, 98.4 % at 5 mm; Chamfer distance 0.43 mm"),
        ("model aligned", "by 3.2 mm and 0.50 degrees to the true object, for the evaluation"),
    ] {
        assert!(rows.contains(&(label.to_owned(), value.to_owned())), "{label}: {rows:?}");
    }
    // A table is known before an object is, and a tilted one crosses the axis elsewhere.
    let last = record.steps.last_mut().unwrap();
    (last.box_min_m, last.box_max_m) = (None, None);
    (last.table_normal, last.table_offset_m) = (Some([0.6, 0.0, 0.8]), Some(0.002));
    record.other_bodies = vec![OtherBodyRecord { size_m: [0.1; 3], center_m: [0.2; 3], gap_m: 0.0521 }];
    record.frame_residual_mm = Some(0.273);
    let hand_eye = HandEyeRecord {
        translation_m: [0.0, 0.003, 0.0],
        quaternion_xyzw: [0.0, 0.0, 0.0, 1.0],
        moved_mm: 3.0,
        turned_deg: 0.0,
        deviation_mm: 0.41,
        deviation_deg: 0.071,
    };
    record.hand_eye = Some(hand_eye);
    let rows = summary(&record, &config);
    for (label, value) in [
        ("frames agree", "within 0.27 mm"),
        (
            "hand-eye calibration",
            "off by 3.0 ± 0.4 mm and 0.00 ± 0.07 degrees; `hand_eye` in record.json corrects it",
        ),
        ("box found", "none"),
        ("table found", "at z = 2.5 mm"),
        (
            "other body",
            "100 x 100 x 100 mm at (0.200, 0.200, 0.200) m; to include it, set `object_box.max_gap_m` to \
             0.053 or more",
        ),
    ] {
        assert!(rows.contains(&(label.to_owned(), value.to_owned())), "{label}: {rows:?}");
    }
    record.hand_eye = Some(HandEyeRecord { deviation_mm: 1.7, ..hand_eye });
    let unknown = "no error shown; these views determine it to ± 1.7 mm and ± 0.07 degrees".to_owned();
    assert!(summary(&record, &config).contains(&("hand-eye calibration".to_owned(), unknown)));
    let nothing = summary(&ScanRecord::default(), &config);
    assert!(nothing.contains(&("state".to_owned(), "under way".to_owned())), "{nothing:?}");
    assert!(nothing.contains(&("box found".to_owned(), "none".to_owned())), "{nothing:?}");
}

#[test]
fn pictures_hold_the_points_that_are_new() {
    let (scan, _, bounds) = walls(3);
    let pictures = ViewPicture::of_scan(&scan);
    assert_eq!(pictures.len(), 3);
    assert!(pictures[0].path.is_empty() && pictures[1].path.len() > 1);
    let size = scan.detail(bounds);
    let all = scan.session.frames().iter().flat_map(|frame| frame.points_in(bounds));
    let cells: HashSet<IVec3> = all.map(|point| (point / size).floor().as_ivec3()).collect();
    let n_points: Vec<usize> = pictures.iter().map(|picture| picture.points.len()).collect();
    assert_eq!(n_points.iter().sum::<usize>(), cells.len());
    assert!(n_points.iter().all(|&n| n > 0), "{n_points:?}");
}

#[test]
fn a_live_scene_holds_what_is_new() {
    let (all, update) = (scene(3, 0), scene(3, 2));
    let n = |scene: &Value, list: &str| scene[list].as_array().unwrap().len();
    assert_eq!([n(&all, "views"), n(&update, "views")], [3, 3]);
    assert_eq!([n(&all, "ends"), n(&update, "ends")], [3, 1]);
    assert_eq!((all["n_views"].as_u64(), update["after"].as_u64()), (Some(3), Some(2)));
    assert_eq!(all["surface"], update["surface"], "the surface is always the whole");
    assert!(all["surface"].is_object() && all["next"]["view"].is_u64());
    let pictures = |scene: &Value| scene["panels"]["pictures"].as_array().unwrap().len();
    assert_eq!([pictures(&all), pictures(&update)], [3, 1]);
    assert!(update["panels"]["views"].as_str().unwrap().matches("<tr>").count() == 4, "a head and 3 rows");
}

#[test]
fn a_live_scene_before_the_first_view_and_with_too_few_views_is_one() {
    let empty = scene(0, 0);
    assert!(empty["surface"].is_null() && empty["expected"].is_null() && empty["next"].is_object());
    assert_eq!(scene(1, 7)["after"], 1, "no more views were taken");
}

#[test]
fn the_live_page_has_no_script_and_no_style_of_its_own() {
    for (part, n) in
        [("<script", 1), ("<script src=\"/assets/viewer.js\">", 1), ("<style", 0), (" style=", 0)]
    {
        assert_eq!(live::PAGE.matches(part).count(), n, "{part}");
    }
    for word in ["http://", "https://", "@import", "url(", "eval(", ".style."] {
        assert!(!live::PAGE.contains(word) && !live::SCRIPT.contains(word), "{word}");
        assert!(!live::STYLE.contains(word), "{word}");
    }
    assert!(!live::CONTENT_SECURITY_POLICY.contains("unsafe"));
}
