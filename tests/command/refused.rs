//! Errors are reported at their line or flag before anything is written.

use crate::support::Folder;

#[test]
fn errors_in_files_name_their_lines() {
    let folder = Folder::new();
    folder.write("bad.csv", "x,y\n1,2\n\n3,oops\n4,5,6\n");
    folder.write("resting.csv", "x,y\n1,2\n1,2\n1,2\n");
    folder.write("comma.json", "[[0, 0],\n [1, 1],\n]");
    folder.write("points.json", "[[0,0],\n[1,2],\n[2,1],\n[2]]");
    folder.write(
        "job.json",
        "{\"curve\": {\n \"points\": [[0,0],[1,1],\n  [1,1],[2,0]]},\n \"method\": \"fast\"}",
    );
    folder.write("empty.csv", "");
    for (name, expected) in [
        (
            "bad.csv",
            "bad.csv:4: column 2: \"oops\" is no number\nbad.csv:5: 3 columns here",
        ),
        ("resting.csv", "resting.csv:3: point 1 equals point 0"),
        ("comma.json", "comma.json:3: "),
        ("points.json", "points.json:4: this point has 1 coordinates"),
        ("job.json", "job.json:4: /method"),
        ("empty.csv", "empty.csv"),
        ("missing.csv", "missing.csv: No such file"),
    ] {
        let finished = folder.fit(&[name, "-o", "out.step"]);
        assert_eq!(finished.status, 2, "{name}: {}", finished.err);
        assert!(
            finished.err.starts_with(expected),
            "{name}: {}",
            finished.err
        );
        assert!(!folder.path("out.step").exists());
    }
    let finished = folder.fit_from("1,2\nx,y\n", &["-"]);
    assert!(finished.err.starts_with("<stdin>:2: "), "{}", finished.err);
}

#[test]
fn errors_in_flags_name_them() {
    let folder = Folder::with_curve();
    for (arguments, expected) in [
        (
            vec!["--method", "fast"],
            "--method: unknown kind of method \"fast\"",
        ),
        (vec!["--degree", "0"], "--degree: "),
        (vec!["--degree", "three"], "--degree: "),
        (vec!["--basis", "nurbs"], "--basis: "),
        (vec!["--tolerance", "small"], "--tolerance: "),
        (vec!["--tolerance", "-1"], "--tolerance: "),
        (vec!["--max-iterations", "many"], "--max-iterations: "),
        (vec!["--control-points", "few"], "--control-points: "),
        (vec!["--ends", "loose"], "--ends: "),
        (vec!["--corners", "sharp"], "--corners sharp: give indices"),
        (vec!["--corners", "0"], "--corners: point 0 is an end"),
        (vec!["--surface", "7x7"], ""),
        (vec!["--set", "method.speed=9"], "--set method.speed: "),
        (vec!["--set", "degree"], "--set degree: "),
        (
            vec!["--set", "stop.tolerance=1", "--tolerance", "1"],
            "--set stop.tolerance: it is given twice",
        ),
        (vec!["--json", "missing.json"], "missing.json: No such file"),
        (
            vec!["-o", "out.foo"],
            "out.foo: its extension is none of json, step",
        ),
        (vec!["-o", "out"], "out: its extension is none of"),
        (
            vec!["-o", "nowhere/out.step"],
            "nowhere/out.step: there is no directory nowhere",
        ),
        (
            vec!["-o", "out.step", "-o", "out.step"],
            "out.step: it is given twice",
        ),
        (
            vec!["--format", "foo"],
            "--format foo: there are json, step",
        ),
        (vec!["--units", "m", "-o", "out.obj"], "--units m: "),
        (vec!["--units", "miles"], "error: invalid value 'miles'"),
        (vec!["--every", "2"], "error: "),
        (vec!["--server", "fits"], "--server fits: "),
        (vec!["--iterations", "no/where"], "--iterations no/where: "),
    ] {
        let finished = folder.fit(&[vec!["curve.csv"], arguments.clone()].concat());
        assert_eq!(finished.status, 2, "{arguments:?}: {}", finished.err);
        assert!(
            finished.err.starts_with(expected),
            "{arguments:?}: {}",
            finished.err
        );
        assert!(finished.out.is_empty());
    }
    assert_eq!(folder.names(), ["curve.csv"]);
}

/// Foot points are on the surface of a job, and there is none without a server.
#[test]
fn foot_points_need_a_server() {
    let folder = Folder::new();
    folder.write(
        "job.json",
        "{\"surface\": {\"scattered\": [[0,0,0],[1,0,1],[0,1,1],[1,1,0]],\n  \"parameters\": {\"foot_points\": {\"job\": \"01a1e1b6-7c2e-7d58-9b5f-6c1f6f3c1b7a\"}}}}",
    );
    folder.write("scan.xyz", "0 0 0\n1 0 1\n0 1.1 1\n1 1 0\n");
    for (arguments, expected) in [
        (
            vec!["job.json"],
            "job.json:2: /surface/parameters: foot points are",
        ),
        (
            vec![
                "scan.xyz",
                "--surface",
                "--set",
                "surface.parameters=foot_points",
            ],
            "--set surface.parameters: foot points are",
        ),
        (
            vec![
                "scan.xyz",
                "--surface",
                "--set",
                "surface.parameters.foot_points.job=01a1e1b6",
            ],
            "--set surface.parameters.foot_points.job: foot points are",
        ),
    ] {
        let finished = folder.fit(&arguments);
        assert_eq!(finished.status, 2, "{arguments:?}: {}", finished.err);
        assert!(
            finished.err.starts_with(expected),
            "{arguments:?}: {}",
            finished.err
        );
        assert!(finished.err.contains("--server"), "{}", finished.err);
    }
}
