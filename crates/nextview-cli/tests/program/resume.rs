//! Scans that are interrupted and resumed.

use crate::common::{Folder, Run};
use crate::recording::{self, write_recording};
use nextview::geometry::random::Random;
use nextview_scan::{Journal, JournalEntry};
use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// The planner decides by the map, and the noise follows from a seed. It takes nine views.
const SCAN: [&str; 6] = ["scan", "builtin:bracket", "--config", "small.toml", "--out", "out"];

const CONFIG: &str = "\
views = 15
candidates = 40
voxel_size_m = 0.014
baselines = false
noise = { model = \"d435i\", pose_error_mm = 1 }
camera = { width = 160, height = 120, fx = 150, fy = 150, cx = 79.5, cy = 59.5 }
";

fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("small.toml", CONFIG);
    folder
}

/// The result files of a scan, and the views it took.
fn results(folder: &Folder, name: &str) -> (Vec<Vec<u8>>, Vec<usize>) {
    let files =
        ["map.ot", "views.csv", "cloud.ply", "mesh.ply"].map(|file| folder.bytes(&format!("{name}/{file}")));
    let views = folder.text(&format!("{name}/views.csv"));
    let views = views.lines().skip(1).map(|line| line.split(',').nth(1).unwrap().parse().unwrap());
    (files.to_vec(), views.collect())
}

/// The views that a process printed, until it was killed after this time, and whether it had finished.
fn killed_after(mut child: Child, time: Duration) -> (Vec<usize>, bool) {
    let stdout = BufReader::new(child.stdout.take().unwrap());
    let reader = thread::spawn(move || stdout.lines().map_while(Result::ok).collect::<Vec<String>>());
    thread::sleep(time);
    let _ = child.kill(); // SIGKILL
    let has_finished = child.wait().unwrap().success();
    let lines = reader.join().unwrap();
    let view = |line: &String| {
        let mut words = line.split_whitespace();
        words.next()?.parse::<usize>().ok()?;
        words.next()?.parse().ok()
    };
    (lines.iter().filter_map(view).collect(), has_finished)
}

/// Kills the scan again and again, at any time. `NEXTVIEW_KILLS` sets how often (default 25; 200
/// in `.ci/full`).
#[test]
fn whenever_it_is_killed_no_frame_is_lost_and_it_goes_on_alike() {
    let n_kills = std::env::var("NEXTVIEW_KILLS").map_or(25, |n| n.parse().unwrap());
    let folder = folder("resume-killed");
    let start = Instant::now();
    folder.ok(&[&SCAN[..5], &["whole"]].concat());
    let duration = start.elapsed();
    let whole = results(&folder, "whole");
    let journal = folder.path("out/scan.journal");
    let (mut n_killed, mut n_finished, mut n_known, mut n_torn) = (0, 0, 0, 0);
    let mut random = Random::new(n_kills as u64, 0);
    while n_killed < n_kills {
        let args: &[&str] = if journal.exists() { &["scan", "--resume", "out"] } else { &SCAN };
        let child = folder.command(args).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        // At any time of the scan; one in six is done before.
        let time = duration.mul_f64(0.6 * (random.in_cube().x + 1.0));
        let (told, has_finished) = killed_after(child, time);
        assert!(whole.1.starts_with(&told), "{told:?}, expected {:?}", whole.1);
        if has_finished {
            assert!(results(&folder, "out") == whole);
            fs::remove_dir_all(folder.path("out")).unwrap();
            (n_finished, n_known) = (n_finished + 1, 0);
            continue;
        }
        n_killed += 1;
        // Before the first frame there may be no journal, and when all is written there is none any more.
        if journal.exists() {
            let (_, kept) = Journal::open(&journal).unwrap();
            let view = |entry: &JournalEntry| match entry {
                JournalEntry::Frame(kept) => kept.view.unwrap(),
                JournalEntry::Skip(_) => panic!("nothing is skipped"),
            };
            let views: Vec<usize> = kept.entries.iter().map(view).collect();
            assert!(
                views.len() >= told.len().max(n_known),
                "{} frames were lost",
                told.len().max(n_known) - views.len()
            );
            assert!(whole.1.starts_with(&views));
            n_known = views.len();
            n_torn += kept.damage.is_some() as usize;
        } else {
            assert!(told.is_empty() && n_known == 0 || results(&folder, "out") == whole);
            n_known = 0;
        }
    }
    println!(
        "{n_killed} times killed, {n_torn} times while a frame was written; {n_finished} times finished"
    );
    if journal.exists() {
        assert_eq!(folder.run(&["scan", "--resume", "out"]).code, Some(0));
        assert!(results(&folder, "out") == whole);
    }
}

/// A scan that was interrupted after a few frames.
fn interrupted(folder: &Folder, scan: &[&str], n_frames: usize) {
    let mut child = folder.command(scan).stdout(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    (0..3 + n_frames).for_each(|_| drop(lines.next().unwrap().unwrap()));
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn so_do_scans_of_recorded_frames() {
    let folder = folder("resume-recorded");
    write_recording(&folder, 12);
    let scan = [&recording::SCAN[..5], &["--views", "10", "--out"]].concat();
    folder.ok(&[&scan[..], &["whole"]].concat());
    interrupted(&folder, &[&scan[..], &["out"]].concat(), 4);
    let resumed = folder.run(&["scan", "--resume", "out"]);
    assert_eq!(resumed.code, Some(0), "{}", resumed.stderr);
    assert!(results(&folder, "out") == results(&folder, "whole"));
}

#[test]
fn an_interrupted_scan_is_not_overwritten() {
    let folder = folder("resume-kept");
    interrupted(&folder, &SCAN, 3);
    let journal = folder.bytes("out/scan.journal");
    let again = folder.run(&SCAN);
    assert_eq!(again.code, Some(1));
    assert_eq!(again.stdout, "", "told before anything is computed");
    assert!(again.stderr.contains("out: holds an interrupted scan"), "{}", again.stderr);
    assert!(again.stderr.contains("--resume out resumes it"), "{}", again.stderr);
    assert_eq!(folder.bytes("out/scan.journal"), journal);
    let resumed = folder.run(&["scan", "--resume", "out", "--json"]);
    assert_eq!(resumed.code, Some(0), "{}", resumed.stderr);
    assert!(resumed.stderr.starts_with("note: resuming after "), "{}", resumed.stderr);
    assert!(!folder.names("out").contains(&"scan.journal".to_owned()), "{:?}", folder.names("out"));
    assert_eq!(folder.run(&[&SCAN[..], &["--force"]].concat()).code, Some(0), "it may be made anew");
}

#[test]
fn up_to_the_damage_a_journal_is_of_use() {
    let folder = folder("resume-damaged");
    folder.ok(&[&SCAN[..5], &["whole"]].concat());
    interrupted(&folder, &SCAN, 3);
    let mut journal = folder.bytes("out/scan.journal");
    let last = journal.len() - 10;
    journal[last] ^= 1;
    folder.write("out/scan.journal", &journal);
    let resumed = folder.run(&["scan", "--resume", "out"]);
    assert_eq!(resumed.code, Some(0), "{}", resumed.stderr);
    let told = |part: &str| assert!(resumed.stderr.contains(part), "{}", resumed.stderr);
    told("scan.journal: damaged from byte ");
    told("bytes from there are now in out/scan.journal.damaged-1");
    assert!(results(&folder, "out") == results(&folder, "whole"));
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let folder = folder("resume-refused");
    let refused = |args: &[&str], code, part: &str| {
        let run = folder.run(args);
        assert_eq!(run.code, Some(code), "{args:?}: {}", run.stderr);
        assert!(run.stderr.contains(part), "{args:?}: {}", run.stderr);
    };
    refused(&["scan", "--resume", "out"], 1, "out: holds no interrupted scan");
    refused(&["scan", "--resume", "out", "--views", "3"], 2, "only --json can be combined with it");
    folder.write("out/scan.journal", "nvframes and no more");
    refused(&["scan", "--resume", "out"], 1, "out/scan.journal: byte 8: ");
    fs::remove_file(folder.path("out/scan.journal")).unwrap();
    // The object is another one by now.
    folder.write("part.off", tetrahedron(0.1));
    let scan = ["scan", "part.off", "--unit", "m", "--config", "small.toml", "--out", "out"];
    interrupted(&folder, &scan, 5);
    folder.write("part.off", tetrahedron(-0.1));
    refused(&["scan", "--resume", "out"], 1, "scan.journal: frame ");
}

fn tetrahedron(x: f64) -> String {
    format!("OFF\n4 4 0\n0 0 0\n{x} 0 0\n0 0.1 0\n0 0 {x}\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
}

/// `ulimit -f` stands for a full disk: what would make a file larger fails, and does not end the program.
#[test]
fn a_full_disk_costs_no_frame_that_was_kept() {
    let folder = folder("resume-full");
    folder.ok(&[&SCAN[..5], &["whole"]].concat());
    let script = format!("ulimit -f 100; exec {} {}", env!("CARGO_BIN_EXE_nextview"), SCAN.join(" "));
    let mut command = Command::new("bash");
    command.args(["-c", &script]).current_dir(folder.path("."));
    let run = Run::of(command);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(run.stderr.contains("scan.journal: cannot be written: File too large"), "{}", run.stderr);
    assert!(run.stderr.contains("is there a limit to the size of files"), "{}", run.stderr);
    assert!(run.stderr.contains("--resume out resumes the scan after "), "{}", run.stderr);
    let resumed = folder.run(&["scan", "--resume", "out"]);
    assert_eq!(resumed.code, Some(0), "{}", resumed.stderr);
    assert!(results(&folder, "out") == results(&folder, "whole"));
}
