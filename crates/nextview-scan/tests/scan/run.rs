//! Runs are pushed: asked for the next step, given a frame.

use crate::common::{image, image_from, session};
use nextview::session::StopReason;
use nextview_scan::{Next, ScanRun};

fn asked(run: &mut ScanRun<'_>) -> nextview::session::NextView {
    match run.next().unwrap() {
        Next::Capture(view) => view,
        other => panic!("{other:?}"),
    }
}

#[test]
fn asked_twice_the_answer_is_the_same() {
    let mut run = ScanRun::new(session());
    for _ in 0..3 {
        let view = asked(&mut run);
        assert_eq!(asked(&mut run), view);
        run.push(image(&view)).unwrap();
    }
    assert_eq!(run.steps().iter().map(|step| step.step).collect::<Vec<_>>(), [1, 2, 3]);
}

#[test]
fn a_frame_of_another_pose_counts_for_the_view_that_was_asked_for() {
    let mut run = ScanRun::new(session());
    let view = asked(&mut run);
    let elsewhere = run.session().views().pose(17);
    let step = run.push(image_from(&elsewhere)).unwrap();
    assert_eq!((step.view, step.position_m), (view.view, elsewhere.translation().to_array()));
    assert_eq!(run.session().visited(), [view.view.unwrap()]);
}

#[test]
fn a_frame_that_was_not_asked_for_is_mapped_and_is_no_view() {
    let mut run = ScanRun::new(session());
    let elsewhere = run.session().views().pose(17);
    let step = run.push(image_from(&elsewhere)).unwrap();
    assert_eq!((step.view, step.plan_time_ms), (None, 0.0));
    assert!(step.new_voxels > 0 && run.session().visited().is_empty());
    assert_eq!(asked(&mut run).view, Some(0), "the first view is still to be taken");
}

#[test]
fn a_skipped_view_is_never_proposed_again() {
    let mut run = ScanRun::new(session());
    let mut skipped = Vec::new();
    for i in 0.. {
        let view = match run.next().unwrap() {
            Next::Capture(view) => view,
            Next::Stop(StopReason::ViewLimit) => break,
            other => panic!("{other:?}"),
        };
        let number = view.view.unwrap();
        assert!(!skipped.contains(&number));
        if i % 2 == 0 {
            run.skip(number, "a test").unwrap();
            skipped.push(number);
        } else {
            run.push(image(&view)).unwrap();
        }
    }
    assert_eq!((run.steps().len(), skipped.len()), (8, 8));
    let fault = run.skip(40, "there are 40").unwrap_err();
    assert_eq!((fault.key.as_deref(), fault.expected.as_deref()), (Some("view"), Some("0 to 39")));
}

#[test]
fn a_cancelled_decision_can_be_asked_for_again() {
    let cancel = nextview::Cancel::default();
    let mut run = ScanRun::new(session().with_cancel(cancel.clone()));
    let mut undisturbed = ScanRun::new(session());
    loop {
        cancel.cancel();
        let is_first = run.steps().is_empty();
        let disturbed = run.next().unwrap();
        assert!(is_first || matches!(disturbed, Next::Stop(StopReason::Cancelled | StopReason::ViewLimit)));
        cancel.reset();
        match (run.next().unwrap(), undisturbed.next().unwrap()) {
            (Next::Capture(view), Next::Capture(expected)) => {
                assert_eq!(view, expected);
                run.push(image(&view)).unwrap();
                undisturbed.push(image(&view)).unwrap();
            }
            (Next::Stop(reason), Next::Stop(expected)) => break assert_eq!(reason, expected),
            (other, expected) => panic!("{other:?}, expected {expected:?}"),
        }
    }
}
