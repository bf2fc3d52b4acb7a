//! Runs are pushed: the caller requests the next step and passes a frame.

use crate::common::{Folder, image, image_from, session};
use glam::{DQuat, DVec3};
use nextview::geometry::Pose;
use nextview::session::StopReason;
use nextview_scan::{FaultKind, Next, ScanJournal, ScanRun};

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

#[test]
fn a_cancelled_frame_comes_again() {
    let folder = Folder::new("cancelled-frame");
    let cancel = nextview::Cancel::default();
    for with_journal in [false, true] {
        let mut run = ScanRun::new(session().with_cancel(cancel.clone()));
        if with_journal {
            run = run.with_journal(ScanJournal::begin(&folder.path("scan"), "a test").unwrap());
        }
        for n_steps in 0..3 {
            let view = asked(&mut run);
            cancel.cancel();
            let fault = run.push(image(&view)).unwrap_err();
            assert_eq!((fault.kind, run.steps().len()), (FaultKind::Cancelled, n_steps));
            cancel.reset();
            match run.next().unwrap() {
                Next::Replay(frame) if with_journal => _ = run.push(frame).unwrap(),
                Next::Capture(again) if !with_journal => _ = run.push(image(&again)).unwrap(),
                other => panic!("{other:?}"),
            }
            assert_eq!(run.steps()[n_steps].view, view.view);
        }
        assert_eq!((run.steps().len(), run.session().visited().len()), (3, 3));
    }
}

#[test]
fn poses_that_are_nowhere_do_not_exist() {
    for x in [1e300, f64::NAN, f64::INFINITY, 1e9] {
        assert!(Pose::new(DQuat::IDENTITY, DVec3::X * x).is_err());
    }
    let mut run = ScanRun::new(session());
    let far = Pose::new(DQuat::IDENTITY, DVec3::X * 1e8).unwrap();
    for _ in 0..2 {
        let step = run.push(image_from(&far)).unwrap();
        assert!(step.trajectory_length_m.is_finite());
    }
}
