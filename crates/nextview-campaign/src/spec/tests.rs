use super::reading::OpenSpec;
use super::*;
use crate::synthetic;
use nextview_scan::Fault;
use std::fs;
use std::path::Path;

/// The faults of a specification, as in a file with this name.
fn faults(text: &str) -> Vec<String> {
    let reading = OpenSpec::of(text, Some(Path::new("mine.toml")));
    let faults = reading.and_then(|reading| Spec::complete(reading, Path::new(""), &[])).unwrap_err();
    let with_remedy = |fault: &Fault| match &fault.remedy {
        Some(remedy) => format!("{fault}; {remedy}"),
        None => fault.to_string(),
    };
    faults.iter().map(with_remedy).collect()
}

fn check(text: &str, expected: &[&str]) {
    let faults = faults(text);
    assert_eq!(faults.len(), expected.len(), "{faults:#?}");
    for (fault, expected) in faults.iter().zip(expected) {
        assert!(fault.starts_with("mine.toml") && fault.contains(expected), "{expected:?} in {faults:#?}");
    }
}

#[test]
fn all_faults_are_found_at_once_and_where_they_are() {
    let text = r#"
name = "a/b"
seeds = [1, 2, 1]
first_views = []
sedes = 3
objects = ["builtin:mug", 7, { file = "a.stl", size_m = 0, init = "mm" }, "none/*.ply"]

[scan]
candidates = 20
views = 5
max_flow.gamma = -1

[[variant]]
label = "{planer}"
scan.planner = "random"
scan.seed = 3
seeds = [3, 3]

[[variant]]
label = "x"
lable = "y"
scan.planner = "fast"
sweep.candidates = 100
sweep.map.background = []

[[variant]]
first_views = [30]
sweep."max_flow.theta" = [0, -2]
"#;
    check(
        text,
        &[
            "line 2, column 1: name is \"a/b\", expected letters",
            "line 3, column 1: seeds has 1 twice",
            "line 4, column 1: first_views is empty",
            "line 5, column 1: `sedes` is not a key",
            "line 6, column 1: object 2 is of type integer, expected a file or a table",
            "line 6, column 1: none/*.ply: matches no file",
            "line 6, column 48: object 3: `objects.2.size_m`: is 0, expected a positive number of metres",
            "line 6, column 60: object 3: `objects.2.init` is not a key",
            "line 11, column 10: `max_flow.gamma` is -1",
            "line 16, column 6: variant 1 (\"{planer}\"): `seed` cannot be set in [scan], `scan` or `sweep`",
            "line 17, column 1: variant 1 (\"{planer}\"): seeds has 3 twice",
            "line 21, column 1: variant 2: `variant.1.lable` is not a key",
            "line 22, column 6: variant 2 (\"x\"): `planner`",
            "line 23, column 7: variant 2 (\"x\"): sweep.candidates is 100, expected a list of values",
            "line 24, column 11: variant 2 (\"x\"): sweep.map.background is empty",
            "line 28, column 7: variant 3: `max_flow.theta` is -2",
        ],
    );
}

#[test]
fn what_only_the_whole_shows_is_found_too() {
    let of = |rest: &str| format!("name = \"x\"\n[scan]\ncandidates = 20\n{rest}");
    check(
        &of("views = 30\n[[variant]]\nscan.planner = \"rse\""),
        &["line 4, column 1: views is 30, expected 1 to 20"],
    );
    check(
        &of("[[variant]]\nfirst_views = [20]"),
        &["line 5, column 1: variant 1: first view 20 is not among the 20"],
    );
    check(
        &of("[[variant]]\nlabel = \"{planer}\""),
        &["line 5, column 1: variant 1 (\"{planer}\"): label \"{planer}\": {planer} is not a key"],
    );
    check(&of("[[variant]]\nlabel = \"{planner\""), &["a '{' without a '}'"]);
    check(
        &of("[[variant]]\n[[variant]]\nlabel = \"most-surface\""),
        &["two variants are labelled \"most-surface\""],
    );
    check(&of("recording.frames = \"a\""), &["line 4, column 1: `recording` is for single scans"]);
    let twice = "name = \"x\"\nobjects = [\"a.ply\", \"b/a.stl\"]";
    check(twice, &["line 2, column 1: two objects are named \"a\": "]);
    check(
        "name = \"x\"\nvariant = [3]",
        &["line 2, column 1: variant 1 is of type integer, expected a table"],
    );
    check("seeds = \"x\"", &["`name`: is missing", "line 1, column 1: `seeds` is \"x\", expected a list"]);
    check("name = \"x", &["line 1, column "]);
    check(
        "name = \"x\"\nviews = 3\n[[variant]]\nnois.model = 3",
        &[
            "line 2, column 1: `views` is not a key; in a campaign, it is `scan.views`",
            "line 4, column 1: variant 1: `variant.0.nois` is not a key; the keys of `variant.0` are label, ",
        ],
    );
    check("name = \"x\"\nobjects = []", &["line 2, column 1: objects is empty, expected at least one mesh"]);
    check(
        "name = \"x\"\n[scan]\nplanner = \"rse\"\nstop.completeness = 0.9",
        &["the planner rse cannot stop by completeness"],
    );
}

#[test]
fn what_multiplies_to_too_many_runs_is_refused_before_any_is_made() {
    let list = |n: usize| (0..n).map(|i| i.to_string()).collect::<Vec<_>>().join(", ");
    let swept = format!(
        "name = \"x\"\n[[variant]]\n[variant.sweep]\ncandidates = [{0}]\nseed = [{0}]\n\"map.rays\" = [{0}]",
        list(1000)
    );
    check(
        &swept,
        &[
            "line 3, column 10: variant 1: sweep gives 1000000000 variants (candidates 1000 x map.rays 1000 x seed \
           1000), expected at most 10000 more variants; sweep fewer values",
        ],
    );
    let seeds = format!(
        "name = \"x\"\nobjects = [\"builtin:mug\"]\nseeds = [{0}]\nview_seeds = [{0}]\n",
        list(10_000)
    );
    check(
        &seeds,
        &["100000000 runs (1 objects x 1 variants x up to 10000 seeds x 10000 view_seeds x 1 first_views)"],
    );
    let name = format!("name = \"{}\"", "a".repeat(201));
    check(&name, &["up to 200 bytes, since it names a folder"]);
}

#[test]
fn first_views_and_sets_of_candidates_are_checked() {
    let of = |rest: &str| format!("name = \"x\"\n{rest}");
    let few = "[scan]\ncandidates = 20\n";
    check(
        &of(&format!("first_views = 21\n{few}")),
        &["line 2, column 1: first_views is 21, expected 1 to 20"],
    );
    check(&of("first_views = 0"), &["line 2, column 1: first_views is 0, expected at least 1"]);
    check(
        &of("first_views = \"all\""),
        &["line 2, column 1: `first_views` is \"all\", expected a list of view numbers, or the number of \
             views to draw"],
    );
    check(&of("first_views = [1, -1]"), &["line 2, column 1: `first_views` is [1, -1], expected a list"]);
    check(
        &of("first_views = 2\nscan.view_space = \"mine.csv\""),
        &["line 2, column 1: first_views is a number, but the number of candidates in"],
    );
    check(&of("view_seeds = []"), &["line 2, column 1: view_seeds is empty"]);
    check(&of("[[variant]]\nview_seeds = [1, 1]"), &["line 3, column 1: variant 1: view_seeds has 1 twice"]);
    check(
        &of("view_seeds = [1]\nscan.view_seed = 2"),
        &["line 2, column 1: view_seeds conflicts with a `view_seed`"],
    );
    check(
        &of("[[variant]]\nview_seeds = [1, 2]\nscan.view_space = \"hemisphere\""),
        &["line 3, column 1: variant 1: view_seeds has 2 sets, but the candidates of hemisphere do not \
             depend on a seed"],
    );
}

/// A specification without any of the newer keys, as written by earlier builds.
#[test]
fn specifications_and_their_copies_read_back() {
    let folder = synthetic::folder("spec-copies");
    for text in [
        "name = \"x\"",
        "name = \"x\"\nseeds = [0, 1]\nfirst_views = [0, 7]",
        "name = \"x\"\nseed = 4\nview_seeds = [0, 3]\nfirst_views = 5\n[[variant]]\nview_seeds = [8]\nfirst_views = 2",
    ] {
        let spec = Spec::parse(text, Path::new("")).unwrap();
        fs::write(folder.join(Spec::FILE), spec.to_toml().unwrap()).unwrap();
        let copy = Spec::of_folder(&folder).unwrap();
        assert_eq!(copy, spec);
        assert!(copy.runs().unwrap().iter().eq(spec.runs().unwrap().iter()));
    }
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn paths_become_whole() {
    let folder = synthetic::folder("spec-paths");
    for name in ["b.ply", "a.ply", "c.stl"] {
        fs::write(folder.join(name), "").unwrap();
    }
    let text = r#"
name = "x"
objects = ["*.ply", { file = "c.stl", unit = "mm", name = "see" }, "builtin:mug"]
scan.view_space = "sphere"
[[variant]]
label = "{view_space}"
sweep.view_space = ["1.csv", "2.csv"]
"#;
    fs::write(folder.join("mine.toml"), text).unwrap();
    let spec = Spec::load(folder.join("mine.toml").to_str().unwrap(), &[]).unwrap();
    let whole = |name: &str| folder.join(name).into_os_string().into_string().unwrap();
    let files: Vec<&str> = spec.objects.iter().map(|object| object.file.as_str()).collect();
    assert_eq!(files, [&whole("a.ply"), &whole("b.ply"), &whole("c.stl"), "builtin:mug"]);
    assert_eq!(spec.objects.iter().map(ObjectSpec::name).collect::<Vec<_>>(), ["a", "b", "see", "mug"]);
    assert_eq!(spec.scan["view_space"].as_str(), Some("sphere"));
    let runs = spec.runs().unwrap();
    let labels: Vec<String> = runs.iter().take(2).map(|run| run.id.variant).collect();
    assert_eq!(labels, [whole("1.csv"), whole("2.csv")]);

    // The format of a campaign's folder.
    fs::write(folder.join(Spec::FILE), spec.to_toml().unwrap()).unwrap();
    assert_eq!(Spec::of_folder(&folder).unwrap(), spec);
    let spec = Spec::load(folder.join("mine.toml").to_str().unwrap(), &[whole("c*.stl")]).unwrap();
    assert_eq!(spec.objects, [ObjectSpec::new(whole("c.stl"))]);
    let faults = Spec::load("paper-1", &[whole("*.obj")]).unwrap_err();
    assert!(faults.to_string().contains("*.obj: matches no file"), "{faults}");
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn paths_of_weights_become_whole_however_the_key_is_written() {
    let text = r#"
name = "x"
[[variant]]
scan = { nbv_net.weights = "net.bin" }
sweep."nbv_net.weights" = ["1.bin", "2.bin"]
"#;
    let folder = std::path::absolute("folder").unwrap();
    let mut reading = OpenSpec::of(text, None).unwrap();
    reading.complete_variants(&folder);
    let whole = |name: &str| folder.join(name).into_os_string().into_string().unwrap();
    let variant = &reading.spec.variant[0];
    assert_eq!(variant.scan["nbv_net"]["weights"].as_str(), Some(&whole("net.bin")[..]));
    let swept = variant.sweep["nbv_net.weights"].as_array().unwrap();
    assert_eq!(swept[1].as_str(), Some(&whole("2.bin")[..]));
}

#[test]
fn sensors_are_names_or_files_by_their_whole_paths() {
    let text = "name = 'x'\nscan.sensor = 'mine.toml'\n[[variant]]\nsweep.sensor = ['d405', 'own.toml']\n";
    let folder = std::path::absolute("folder").unwrap();
    let mut reading = OpenSpec::of(text, None).unwrap();
    reading.complete_variants(&folder);
    let swept = reading.spec.variant[0].sweep["sensor"].as_array().unwrap();
    let own = folder.join("own.toml").into_os_string().into_string().unwrap();
    assert_eq!(swept.iter().map(|name| name.as_str().unwrap()).collect::<Vec<_>>(), ["d405", &own[..]]);
}

#[test]
fn a_specification_that_is_not_there_lists_those_that_are() {
    let faults = Spec::load("paper-9", &[]).unwrap_err();
    let fault = faults.iter().next().unwrap();
    assert!(fault.to_string().starts_with("paper-9: cannot be read"), "{fault}");
    assert!(fault.remedy.as_ref().is_some_and(|remedy| remedy.contains("paper-1, paper-2")), "{fault:?}");
}
