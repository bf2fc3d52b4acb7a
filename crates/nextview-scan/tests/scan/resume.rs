//! After an interruption, the journal replays its frames before any capture is requested.

use crate::common::{Folder, image, image_from, session};
use nextview_scan::{Interrupted, Journal, Next, ScanJournal, ScanRun, StepRecord};
use std::thread;
use std::time::Duration;

/// Performs the next steps of a scan, one after the other. Adds the numbers of the captured views to
/// `captured`.
fn act(run: &mut ScanRun<'_>, n_steps: usize, captured: &mut Vec<usize>) {
    for _ in 0..n_steps {
        match run.next().unwrap() {
            Next::Replay(frame) => _ = run.push(frame).unwrap(),
            Next::Stop(_) => return,
            Next::Capture(view) => {
                let number = view.view.unwrap();
                if run.steps().len() == 2 && captured.len() == 2 {
                    run.skip(number, "every scan skips the third view that is proposed").unwrap();
                    let elsewhere = run.session().views().pose(5);
                    run.push(image_from(&elsewhere)).unwrap(); // not asked for
                    captured.push(usize::MAX);
                    continue;
                }
                captured.push(number);
                run.push(image(&view)).unwrap();
            }
        }
    }
}

/// The steps without times.
fn timeless(steps: &[StepRecord]) -> Vec<StepRecord> {
    let without = |step: &StepRecord| StepRecord {
        plan_time_ms: 0.0,
        map_time_ms: 0.0,
        capture_time_ms: 0.0,
        ..step.clone()
    };
    steps.iter().map(without).collect()
}

#[test]
fn no_view_is_asked_for_again_and_the_scan_is_the_same() {
    let folder = Folder::new("resume");
    let mut undisturbed = ScanRun::new(session());
    let mut expected = Vec::new();
    act(&mut undisturbed, 20, &mut expected);
    for n_steps in 1..9 {
        let dir = folder.path(&n_steps.to_string());
        let mut captured = Vec::new();
        let mut run = ScanRun::new(session()).with_journal(ScanJournal::begin(&dir, "a ball").unwrap());
        act(&mut run, n_steps, &mut captured);
        let n_before = captured.len();
        drop(run); // as a kill: the journal stays
        let Interrupted { heading, journal, n_frames, damage } = ScanJournal::resume(&dir).unwrap();
        assert_eq!((&heading[..], n_frames, damage), ("a ball", n_before, None));
        let mut run = ScanRun::new(session()).with_journal(journal);
        for _ in 0..n_before {
            let Next::Replay(frame) = run.next().unwrap() else { panic!("the journal answers first") };
            run.push(frame).unwrap();
        }
        act(&mut run, 20, &mut captured);
        assert_eq!(captured, expected, "interrupted after {n_steps} steps");
        assert_eq!(timeless(run.steps()), timeless(undisturbed.steps()));
        run.finish(None).forget_journal();
        assert!(!ScanJournal::is_in(&dir));
    }
}

#[test]
fn another_frame_than_that_of_the_journal_is_refused() {
    let folder = Folder::new("resume-other");
    let dir = folder.path("scan");
    let mut run = ScanRun::new(session()).with_journal(ScanJournal::begin(&dir, "").unwrap());
    act(&mut run, 2, &mut Vec::new());
    drop(run);
    let mut run = ScanRun::new(session()).with_journal(ScanJournal::resume(&dir).unwrap().journal);
    assert!(matches!(run.next().unwrap(), Next::Replay(_)));
    let elsewhere = run.session().views().pose(9);
    let fault = run.push(image_from(&elsewhere)).unwrap_err();
    assert!(fault.remedy.unwrap().contains("unchanged"));
    assert!(run.skip(3, "too early").is_err());
}

#[test]
fn a_scan_that_decides_otherwise_is_refused() {
    let folder = Folder::new("resume-differs");
    let dir = folder.path("scan");
    let mut run = ScanRun::new(session()).with_journal(ScanJournal::begin(&dir, "").unwrap());
    for view in [0, 3] {
        run.next().unwrap();
        let pose = run.session().views().pose(view);
        run.push(image_from(&pose)).unwrap();
    }
    drop(run);
    let journal = ScanJournal::resume(&dir).unwrap().journal;
    let mut other = session();
    other.skip(0);
    let mut run = ScanRun::new(other).with_journal(journal);
    let fault = run.next().unwrap_err();
    assert!(
        fault.to_string().contains("frame 1 was taken from view 0, but the planner now chooses view 1"),
        "{fault}"
    );
}

#[test]
fn a_folder_with_an_interrupted_scan_is_not_taken() {
    let folder = Folder::new("resume-free");
    let dir = folder.path("scan");
    assert!(ScanJournal::resume(&dir).is_err());
    drop(ScanJournal::begin(&dir, "no frame").unwrap());
    assert!(!dir.exists(), "a journal without frames is of no use");
    let mut run = ScanRun::new(session()).with_journal(ScanJournal::begin(&dir, "").unwrap());
    act(&mut run, 1, &mut Vec::new());
    drop(run);
    let fault = ScanJournal::begin(&dir, "").map(drop).unwrap_err();
    assert!(fault.to_string().ends_with("scan: holds an interrupted scan"), "{fault}");
}

#[test]
fn a_folder_that_is_being_scanned_is_said_to_be() {
    let folder = Folder::new("resume-busy");
    let dir = folder.path("scan");
    let first = ScanJournal::begin(&dir, "").unwrap();
    let begun = ScanJournal::begin(&dir, "").map(drop).unwrap_err();
    let resumed = ScanJournal::resume(&dir).map(drop).unwrap_err();
    for fault in [&begun, resumed.iter().next().unwrap()] {
        assert!(fault.to_string().ends_with("scan: is in use by a running scan, here or in another process"));
        assert!(!fault.remedy.as_ref().unwrap().contains("remove"), "{fault:?}");
    }
    // A scan killed before its first frame leaves nothing that could be lost.
    drop(first);
    std::fs::create_dir(&dir).unwrap();
    drop(Journal::create(&dir.join(ScanJournal::FILE), "killed").unwrap());
    drop(ScanJournal::begin(&dir, "").unwrap());
    assert!(!ScanJournal::is_in(&dir));
}

#[test]
fn of_many_who_begin_a_scan_one_does() {
    let folder = Folder::new("resume-race");
    for round in 0..50 {
        let dir = folder.path(&round.to_string());
        let begun: Vec<_> = thread::scope(|scope| {
            let threads: Vec<_> = (0..4).map(|_| scope.spawn(|| ScanJournal::begin(&dir, ""))).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        let refused: Vec<String> =
            begun.iter().filter_map(|begun| Some(begun.as_ref().err()?.to_string())).collect();
        assert_eq!(refused.len(), 3, "{refused:?}");
        assert!(refused.iter().all(|said| said.contains("is in use by a running scan")), "{refused:?}");
    }
}

/// The scan's journal is removed while somebody waits for it.
#[test]
fn a_scan_that_is_finished_meanwhile_is_not_said_to_be_lost() {
    let folder = Folder::new("resume-finished");
    let dir = folder.path("scan");
    for _ in 0..10 {
        let journal = ScanJournal::begin(&dir, "").unwrap();
        let faults = thread::scope(|scope| {
            let resumed = scope.spawn(|| ScanJournal::resume(&dir).map(drop).unwrap_err());
            thread::sleep(Duration::from_millis(5));
            journal.finish();
            resumed.join().unwrap()
        });
        let said = faults.iter().next().unwrap().to_string();
        // If a thread is late, the journal is not removed in between.
        let expected = ["holds no interrupted scan", "is in use by a running scan"];
        assert!(expected.iter().any(|part| said.contains(part)), "{said}");
    }
}

#[cfg(unix)]
#[test]
fn a_scan_leaves_the_journal_of_another_alone() {
    let folder = Folder::new("resume-others");
    let dir = folder.path("scan");
    let first = ScanJournal::begin(&dir, "first").unwrap();
    std::fs::remove_file(dir.join(ScanJournal::FILE)).unwrap();
    let second = ScanJournal::begin(&dir, "second").unwrap();
    drop(first);
    assert!(ScanJournal::is_in(&dir));
    drop(second);
    assert!(!ScanJournal::is_in(&dir));
}
