//! Files with several parts, and several files at once.

use serde_json::Value;

use crate::support::{Folder, curve};

/// Two curves with a blank line between them.
const TWO: &str = "x,y\n0,0\n1,2\n2,1\n\n5,5\n6,7\n7,9\n8,6\n";

#[test]
fn all_parts_go_to_one_file() {
    let folder = Folder::new();
    folder.write("two.csv", TWO);
    for (name, counted, count) in [
        ("a.dxf", "POLYLINE", 2),
        ("a.step", "=B_SPLINE_CURVE_WITH_KNOTS(", 2),
        ("a.svg", "<path ", 2),
        ("a.geojson", "\"LineString\"", 2),
        ("a.obj", "\ncurv ", 2),
        ("a.csv", "t,x,y", 1),
    ] {
        let finished = folder.fit(&["two.csv", "-o", name]);
        assert_eq!(finished.status, 0, "{}", finished.err);
        assert!(
            finished.err.contains("2 converged, 0 did not"),
            "{}",
            finished.err
        );
        let file = String::from_utf8_lossy(&folder.read(name)).into_owned();
        assert_eq!(file.matches(counted).count(), count, "{name}: {file}");
    }
    let exact = folder.fit(&["two.csv", "-o", "b.dxf", "--dxf", "r2000", "-q"]);
    assert_eq!((exact.status, &*exact.err), (0, ""));
    let file = String::from_utf8_lossy(&folder.read("b.dxf")).into_owned();
    assert_eq!(file.matches("\nSPLINE\n").count(), 2, "{file}");
    let json: Value = folder.fit(&["two.csv"]).json();
    let items = json["items"].as_array().unwrap();
    assert_eq!(items.len(), 2);
    assert_eq!(items[1]["curve"]["degree"], 3);
    // What was found out about the file is reported once.
    folder.write(
        "ids.csv",
        "id,x,y\n7,0,0\n8,1,2\n9,2,1\n\n4,5,5\n6,6,7\n5,7,9\n",
    );
    let finished = folder.fit(&["ids.csv", "-o", "ids.json"]);
    assert_eq!(
        finished.err.matches("(id) is not read").count(),
        1,
        "{}",
        finished.err
    );
    // One of them, as before.
    let second = folder.result(&["two.csv", "--part", "2"]);
    assert_eq!(
        second["control_points"],
        items[1]["curve"]["control_points"]
    );
}

#[test]
fn a_part_that_fails_keeps_no_other_back() {
    let folder = Folder::new();
    folder.write("two.csv", &TWO.replace("2,1\n", "1e17,0\n1e17,1\n"));
    let finished = folder.fit(&["two.csv", "-o", "two.svg"]);
    assert_eq!(finished.status, 1, "{}", finished.err);
    assert!(
        finished.err.contains("1 converged, 1 did not"),
        "{}",
        finished.err
    );
    assert!(finished.err.contains("part 1"), "{}", finished.err);
    let file = String::from_utf8_lossy(&folder.read("two.svg")).into_owned();
    assert_eq!(file.matches("<path ").count(), 1);
    // Also where nothing else is finished.
    let finished = folder.fit(&["two.csv", "-q", "-o", "two.svg"]);
    assert!(
        finished.err.starts_with("part 1: failed"),
        "{}",
        finished.err
    );
}

#[test]
fn options_of_one_curve_are_rejected_for_several() {
    let folder = Folder::new();
    folder.write("two.csv", TWO);
    folder.write("curve.csv", &curve(10));
    for (arguments, detail) in [
        (
            &["two.csv", "--plot", "p.svg"][..],
            "--plot: the file has several parts",
        ),
        (
            &["two.csv", "--part", "3"],
            "--part: the file has parts 1 to 2",
        ),
        (&["two.csv", "-o", "a.gpx"], "origin"),
        (&["curve.csv", "two.csv"], "name it with -o DIR/"),
        (
            &["curve.csv", "two.csv", "-o", "curve.csv"],
            "this is a file",
        ),
        (&["curve.csv", "curve.csv", "-o", "out/"], "given twice"),
        (
            &["curve.csv", "-o", "a.step", "--svg", "path"],
            "--svg path: no output is SVG",
        ),
        (
            &["curve.csv", "-o", "a.csv", "--spacing", "0"],
            "more than 0",
        ),
    ] {
        let finished = folder.fit(arguments);
        assert_eq!(finished.status, 2, "{arguments:?}: {}", finished.err);
        assert!(
            finished.err.contains(detail),
            "{arguments:?}: {}",
            finished.err
        );
    }
}

/// A batch of a curve and a surface, with defaults of both.
const BATCH: &str = r#"{
  "defaults": {"stop": {"tolerance": 1e-9}, "curve": {"degree": 2}},
  "items": [
    {"name": "arch", "curve": {"points": [[0, 0, 0], [1, 2, 0], [2, 1, 1], [3, 0, 1]]}},
    {"name": "patch", "surface": {"points": [[[0, 0, 0], [0, 1, 0], [0, 2, 0], [0, 3, 1]], [[1, 0, 0], [1, 1, 1], [1, 2, 0], [1, 3, 0]],
      [[2, 0, 1], [2, 1, 0], [2, 2, 0], [2, 3, 0]], [[3, 0, 0], [3, 1, 0], [3, 2, 1], [3, 3, 0]]]}}
  ]
}"#;

#[test]
fn the_items_of_a_batch_are_parts() {
    let folder = Folder::new();
    folder.write("batch.json", BATCH);
    let finished = folder.fit(&["batch.json", "-o", "out.step"]);
    assert_eq!(finished.status, 0, "{}", finished.err);
    assert!(
        finished.err.contains("2 converged, 0 did not"),
        "{}",
        finished.err
    );
    let step = String::from_utf8_lossy(&folder.read("out.step")).into_owned();
    for part in ["'arch'", "'patch'"] {
        assert!(step.contains(part), "{part}");
    }
    // Defaults hold, and flags go over them and over the items.
    let items = |arguments: &[&str]| folder.fit(arguments).json()["items"].clone();
    let plain = items(&["batch.json"]);
    assert_eq!(plain[0]["curve"]["degree"], 2);
    assert_eq!(plain[1]["surface"]["degree"]["u"], 3);
    let flags = items(&["batch.json", "--degree", "1", "--set", "method.kind=direct"]);
    assert_eq!(flags[0]["curve"]["degree"], 1);
    assert_eq!(flags[1]["surface"]["degree"]["u"], 1);
    // Beside other files, each goes to a file of a directory.
    folder.write("curve.csv", &curve(10));
    let finished = folder.fit(&["batch.json", "curve.csv", "-o", "out/", "--format", "step"]);
    assert_eq!(finished.status, 0, "{}", finished.err);
    assert!(
        finished.err.contains("batch.json: arch"),
        "{}",
        finished.err
    );
    assert_eq!(std::fs::read_dir(folder.path("out")).unwrap().count(), 2);
}

#[test]
fn errors_of_a_batch_have_locations() {
    let folder = Folder::new();
    let with = |old: &str, new: &str| BATCH.replacen(old, new, 1);
    for (text, arguments, status, detail) in [
        // An item that fails keeps no other back.
        (
            with("[1, 2, 0]", "[0, 0, 0]"),
            &["-o", "out.step"][..],
            1,
            "arch  ",
        ),
        (
            with("1e-9", "-1"),
            &["-o", "out.step"],
            1,
            "/defaults/stop/tolerance",
        ),
        (
            with("\"stop\"", "\"stopp\""),
            &[],
            2,
            "batch.json:2: /defaults",
        ),
        (with("\"arch\",", "\"arch\""), &[], 2, "batch.json:4: "),
        (
            "{\"items\": []}".to_owned(),
            &[],
            2,
            "there is nothing to fit",
        ),
        ("{\"items\": 7}".to_owned(), &[], 2, "batch.json:1: /items"),
        ("{\"items\": [7]}".to_owned(), &[], 1, "part 1"),
        (
            "{\"items\": [], \"curve\": {}}".to_owned(),
            &[],
            2,
            "unknown field \"curve\"",
        ),
        (BATCH.to_owned(), &["--part", "1"], 2, "is a whole batch"),
        (
            BATCH.to_owned(),
            &["-o", "a.svg", "--plot", "p.svg"],
            2,
            "--plot: the batch has several fits",
        ),
        (BATCH.to_owned(), &["-o", "out.stl"], 2, "out.stl"),
    ] {
        folder.write("batch.json", &text);
        let finished = folder.fit(&[&["batch.json"], arguments].concat());
        assert_eq!(finished.status, status, "{text}: {}", finished.err);
        assert!(finished.err.contains(detail), "{text}: {}", finished.err);
    }
}

#[test]
fn fits_that_did_not_converge_are_named_with_quiet() {
    let folder = Folder::new();
    folder.write("curve.csv", &curve(30));
    let few = ["curve.csv", "-o", "a.step", "-q", "--max-iterations", "1"];
    let finished = folder.fit(&[&few[..], &["--method", "global"]].concat());
    assert_eq!(finished.status, 1, "{}", finished.err);
    assert_eq!(finished.err.lines().count(), 1, "{}", finished.err);
    assert!(
        finished
            .err
            .starts_with("curve.csv: exhausted, error at most "),
        "{}",
        finished.err
    );
    assert!(finished.err.contains("tolerance"), "{}", finished.err);
    let finished = folder.fit(&["curve.csv", "-o", "a.step", "-q"]);
    assert_eq!((finished.status, &*finished.err), (0, ""));
}

#[test]
fn many_files_go_to_a_directory() {
    let folder = Folder::new();
    let mut arguments: Vec<String> = Vec::new();
    for i in 0..25 {
        let name = format!("wing{i}.csv");
        folder.write(&name, &curve(10 + i));
        arguments.push(name);
    }
    folder.write("two.csv", TWO);
    folder.write("bad.csv", "x,y\n0,0\n1,oops\n2,1\n");
    arguments.extend(["two.csv", "bad.csv", "-o", "out/", "--format", "step"].map(str::to_owned));
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let finished = folder.fit(&arguments);
    assert_eq!(finished.status, 1, "{}", finished.err);
    assert!(finished.err.contains("bad.csv"), "{}", finished.err);
    assert!(
        finished.err.contains("27 files: 27 converged, 1 did not"),
        "{}",
        finished.err
    );
    assert!(finished.err.contains("… and 8 more"), "{}", finished.err);
    assert_eq!(std::fs::read_dir(folder.path("out")).unwrap().count(), 26);
}

/// A section of the NACA series of four digits, from its trailing edge over the upper side and back.
fn naca(digits: &str) -> String {
    let number = |range: std::ops::Range<usize>| digits[range].parse::<f64>().unwrap();
    let (camber, place, thickness) = (
        number(0..1) / 100.0,
        number(1..2) / 10.0,
        number(2..4) / 100.0,
    );
    let point = |i: i32| {
        let x = (1.0 - (f64::from(i) * std::f64::consts::PI / 40.0).cos()) / 2.0;
        let root = 0.2969 * x.sqrt();
        let half =
            5.0 * thickness * (root - x * (0.126 + x * (0.3516 - x * (0.2843 - x * 0.1015))));
        let (reach, from) = match x < place {
            true => (place, x),
            false => (1.0 - place, 1.0 - x),
        };
        let line = camber * from * (2.0 * reach - from) / (reach * reach);
        format!("{x:.6} {:.6}\n", line - half.copysign(f64::from(i)))
    };
    let points: String = (-40..=40).map(point).collect();
    format!("NACA {digits}\n{points}")
}

#[test]
fn a_hundred_airfoils_take_one_command() {
    let folder = Folder::new();
    let of_camber =
        |camber: usize| (8..28).map(move |thickness| format!("{camber}4{thickness:02}"));
    let names: Vec<String> = (1..6).flat_map(of_camber).collect();
    let files: Vec<String> = names.iter().map(|name| format!("naca{name}.dat")).collect();
    for (file, name) in files.iter().zip(&names) {
        folder.write(file, &naca(name));
    }
    let how = [
        "--control-points",
        "auto",
        "--tolerance",
        "1e-3",
        "--format",
        "json",
    ];
    let all: Vec<&str> = files.iter().map(String::as_str).collect();
    let finished = folder.fit(&[&all[..], &["-o", "out/"], &how].concat());
    assert_eq!(finished.status, 0, "{}", finished.err);
    let totals = "100 files: 100 converged, 0 did not";
    assert!(finished.err.contains(totals), "{}", finished.err);
    for name in &names {
        let result: Value =
            serde_json::from_slice(&folder.read(&format!("out/naca{name}.json"))).unwrap();
        assert_eq!(result["name"], format!("NACA {name}"));
        let count = result["control_points"].as_array().unwrap().len();
        assert!((6..40).contains(&count), "{name}: {count} control points");
    }
    // Each is what it is alone.
    for name in [&names[0], &names[57]] {
        let file = format!("naca{name}.dat");
        let alone = folder.result(&[&[file.as_str()][..], &how].concat());
        let result: Value =
            serde_json::from_slice(&folder.read(&format!("out/naca{name}.json"))).unwrap();
        for field in ["knots", "control_points", "error"] {
            assert_eq!(result[field], alone[field], "{name}: {field}");
        }
    }
}

#[test]
fn parts_of_many_files_are_named_after_their_files() {
    let folder = Folder::new();
    folder.write("curve.csv", &curve(10));
    folder.write("two.csv", &TWO.replace("2,1\n", "1e17,0\n1e17,1\n"));
    for (quiet, count) in [(&[][..], 1), (&["-q"], 1)] {
        let arguments = [&["curve.csv", "two.csv", "-o", "out/"], quiet].concat();
        let finished = folder.fit(&arguments);
        assert_eq!(finished.status, 1, "{}", finished.err);
        assert_eq!(
            finished.err.matches("two.csv: part 1").count(),
            count,
            "{}",
            finished.err
        );
    }
}
