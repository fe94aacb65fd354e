//! Every kind of output, and what is finished.

use std::fs;

use serde_json::Value;

use crate::support::{Folder, field};

/// How a file of each ending begins.
const BEGINNINGS: [(&str, &[u8]); 12] = [
    ("json", b"{\"id\":"),
    ("step", b"ISO-10303-21;"),
    ("STP", b"ISO-10303-21;"),
    ("igs", b""),
    ("iges", b""),
    ("obj", b""),
    ("glb", b"glTF"),
    ("gltf", b"glTF"),
    ("stl", b""),
    ("dxf", b""),
    ("svg", b"<?xml"),
    ("csv", b"u,v,x,y,z\n"),
];

#[test]
fn files_are_of_the_format_of_their_ending() {
    let folder = Folder::new();
    folder.write("field.csv", &field(""));
    let names = BEGINNINGS.map(|(ending, _)| format!("out.{ending}"));
    let mut arguments = vec!["field.csv", "--plot", "picture.svg", "--units", "m"];
    for name in &names {
        arguments.extend(["-o", name]);
    }
    let finished = folder.fit(&arguments);
    assert_eq!(
        (finished.status, finished.out.len()),
        (0, 0),
        "{}",
        finished.err
    );
    for (name, (_, beginning)) in names.iter().zip(BEGINNINGS) {
        let bytes = folder.read(name);
        assert!(!bytes.is_empty() && bytes.starts_with(beginning), "{name}");
        assert!(
            finished.err.contains(&format!("wrote {name} (")),
            "{}",
            finished.err
        );
    }
    assert!(folder.read("picture.svg").starts_with(b"<?xml"));
    assert_eq!(folder.names().len(), names.len() + 2);
}

#[test]
fn results_go_to_the_standard_output() {
    let folder = Folder::with_curve();
    let finished = folder.fit(&["curve.csv", "--format", "step"]);
    assert!(finished.out.starts_with(b"ISO-10303-21;"));
    let finished = folder.fit(&["curve.csv", "-o", "-", "-o", "out.csv"]);
    assert_eq!(finished.json()["state"], "converged");
    assert!(folder.read("out.csv").starts_with(b"t,x,y\n"));
    // The format that is said is that of all names.
    let finished = folder.fit(&["curve.csv", "-o", "out.txt", "--format", "csv"]);
    assert_eq!(finished.status, 0, "{}", finished.err);
    assert_eq!(folder.read("out.txt"), folder.read("out.csv"));
}

#[test]
fn files_that_are_there_are_replaced() {
    let folder = Folder::with_curve();
    folder.write("old.step", "what was here");
    #[cfg(unix)]
    std::os::unix::fs::symlink(folder.path("old.step"), folder.path("link.step")).unwrap();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(folder.path("old.step"), fs::Permissions::from_mode(0o640)).unwrap();
        assert_eq!(folder.fit(&["curve.csv", "-o", "link.step"]).status, 0);
        assert!(
            fs::symlink_metadata(folder.path("link.step"))
                .unwrap()
                .is_symlink()
        );
        let mode = fs::metadata(folder.path("old.step"))
            .unwrap()
            .permissions()
            .mode();
        assert_eq!(mode & 0o777, 0o640);
    }
    assert!(folder.read("old.step").starts_with(b"ISO-10303-21;"));
    // Devices stay what they are.
    assert_eq!(
        folder
            .fit(&["curve.csv", "--format", "step", "-o", "/dev/null"])
            .status,
        0
    );
}

#[test]
fn iterations_are_files_too() {
    let folder = Folder::with_curve();
    let finished = folder.fit(&["curve.csv", "--iterations", "all", "-o", "out.json"]);
    let last = serde_json::from_slice::<Value>(&folder.read("out.json")).unwrap();
    let last = last["iteration"].as_u64().unwrap();
    let count = fs::read_dir(folder.path("all")).unwrap().count() as u64;
    assert_eq!(count, last + 1, "{}", finished.err);
    let first: Value = serde_json::from_slice(&folder.read("all/iteration-0.json")).unwrap();
    assert_eq!(first["iteration"], 0);
    folder.fit(&[
        "curve.csv",
        "--iterations",
        "some",
        "--every",
        "4",
        "--max-iterations",
        "6",
        "--tolerance",
        "1e-14",
        "-o",
        "out.igs",
    ]);
    for k in [0, 4, 6] {
        assert!(
            folder.path(&format!("some/iteration-{k}.igs")).exists(),
            "{k}"
        );
    }
    assert_eq!(fs::read_dir(folder.path("some")).unwrap().count(), 3);
}

#[test]
fn shapes_are_files_too() {
    let folder = Folder::with_curve();
    let finished = folder.fit(&[
        "curve.csv",
        "-o",
        "out.json",
        "--shape",
        "shape.json",
        "--samples",
        "12",
    ]);
    assert_eq!(finished.status, 0, "{}", finished.err);
    let shape: Value = serde_json::from_slice(&folder.read("shape.json")).unwrap();
    let result: Value = serde_json::from_slice(&folder.read("out.json")).unwrap();
    assert_eq!(shape["iteration"], result["iteration"]);
    let curvature = shape["samples"]["curvature"].as_array().unwrap();
    assert_eq!(curvature.len(), 12);
    assert!(shape["length"].as_f64().unwrap() > 0.0);
}

#[test]
fn the_status_says_whether_it_has_converged() {
    let folder = Folder::with_curve();
    let finished = folder.fit(&["curve.csv", "--max-iterations", "1", "-o", "out.step"]);
    assert_eq!(finished.status, 1);
    assert!(
        finished.err.contains("exhausted after 1 iteration"),
        "{}",
        finished.err
    );
    assert!(folder.path("out.step").exists());
    // A format that cannot hold the result keeps no other back.
    folder.write("far.csv", "0,0\n1e39,2e39\n3e39,1e39\n4e39,3e39\n");
    let finished = folder.fit(&["far.csv", "-o", "out.glb", "-o", "out.obj"]);
    assert_eq!(finished.status, 1);
    assert!(
        finished.err.contains("out.glb: a coordinate is"),
        "{}",
        finished.err
    );
    assert!(folder.path("out.obj").exists() && !folder.path("out.glb").exists());
}

/// What no result for the points can be written to is refused before the fit, and nothing is written.
#[test]
fn formats_that_cannot_hold_the_points_are_refused_before_the_fit() {
    let folder = Folder::with_curve();
    folder.write(
        "heights.json",
        r#"{"surface": {"points": [[1, 2, 3, 4], [2, 3, 1, 2], [1, 0, 1, 2], [3, 1, 2, 2]]}}"#,
    );
    folder.write("values.csv", "1\n3\n2\n4\n");
    folder.write(
        "list.json",
        r#"{"curve": {"points": [[0, 0], [1, 2], [3, 1]]}}"#,
    );
    let before = folder.names();
    for (arguments, expected) in [
        (
            vec!["curve.csv", "-o", "out.stl", "-o", "out.obj"],
            "out.stl: stl files hold",
        ),
        (
            vec!["list.json", "--format", "stl"],
            "<stdout>: stl files hold",
        ),
        (
            vec!["heights.json", "-o", "out.step"],
            "out.step: step holds",
        ),
        (
            vec!["heights.json", "-o", "out.csv", "-o", "out.glb"],
            "out.glb: gltf holds",
        ),
        (
            vec!["values.csv", "-o", "out.json", "--plot", "out.svg"],
            "out.svg: svg holds",
        ),
        (
            vec!["values.csv", "-o", "out.json", "--shape", "shape.json"],
            "shape.json: the points have one coordinate",
        ),
        (
            vec!["values.csv", "-o", "out.json", "--shape", "out.json"],
            "out.json: it is given twice",
        ),
    ] {
        let finished = folder.fit(&arguments);
        assert_eq!(
            (finished.status, finished.out.len()),
            (2, 0),
            "{arguments:?}: {}",
            finished.err
        );
        assert!(
            finished.err.starts_with(expected),
            "{arguments:?}: {}",
            finished.err
        );
        assert_eq!(finished.err.lines().count(), 1, "{}", finished.err);
        assert_eq!(folder.names(), before);
    }
    let finished = folder.fit(&["heights.json", "-o", "out.csv", "-o", "out.json"]);
    assert_eq!(finished.status, 0, "{}", finished.err);
}

#[test]
fn progress_and_a_summary_are_printed_unless_quiet() {
    let folder = Folder::with_curve();
    let finished = folder.fit(&["curve.csv", "-o", "out.step"]);
    for words in [
        " of about ",
        "curve.csv: curve of degree 3 (bspline), 40 points, 42 control points, method global",
        "converged after",
        "wrote out.step",
    ] {
        assert!(finished.err.contains(words), "{words}: {}", finished.err);
    }
    // One that did not converge is named in a line: `fits_that_did_not_converge_are_named_with_quiet`.
    let finished = folder.fit(&["curve.csv", "--quiet", "-o", "out.step"]);
    assert_eq!((finished.err.as_str(), finished.out.len()), ("", 0));
}

/// A least-squares minimum above the requested tolerance is no success, but is written.
#[test]
fn a_minimum_above_the_tolerance_sets_the_exit_status() {
    let folder = Folder::new();
    let points = "[[0, 0], [1, 2], [2, -1], [3, 2], [4, 0], [5, 3], [6, 1]]";
    let method = r#"{"kind": "least_squares", "control_points": 4}"#;
    for (stop, status, said) in [
        ("", 0, "no tolerance was requested"),
        (
            r#", "stop": {"tolerance": 1e-4}"#,
            1,
            "use more control points",
        ),
    ] {
        let job = format!(r#"{{"curve": {{"points": {points}}}, "method": {method}{stop}}}"#);
        folder.write("job.json", &job);
        let finished = folder.fit(&["job.json", "-o", "curve.step"]);
        assert_eq!(finished.status, status, "{}", finished.err);
        assert!(finished.err.contains(said), "{}", finished.err);
        assert!(!folder.read("curve.step").is_empty());
    }
}
