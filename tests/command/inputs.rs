//! Every kind of input.

use serde_json::{Value, json};

use crate::support::{Finished, Folder, PROGRAM, curve, field};

const WING: &str = "NACA 2412\n1 0.0013\n0.95 0.0114\n0.9 0.0208\n0.8 0.0375\n0.7 0.0518\n";

#[test]
fn points_of_curves_come_in_many_kinds() {
    let folder = Folder::with_curve();
    let expected = folder.result(&["curve.csv"])["control_points"].clone();
    assert_eq!(expected.as_array().unwrap().len(), 42);
    let semicolons = curve(40).replace(',', ";");
    let blanks = curve(40).replace(',', "  ").replace("x  y", "# x y");
    folder.write("semicolons.txt", &semicolons);
    folder.write("blanks.xyz", &blanks);
    let points: Vec<Value> = curve(40)
        .lines()
        .skip(1)
        .map(|line| serde_json::from_str(&format!("[{line}]")).unwrap())
        .collect();
    folder.write("points.json", &json!(points).to_string());
    let job = json!({"curve": {"points": points}});
    folder.write("job.json", &job.to_string());
    for name in ["semicolons.txt", "blanks.xyz", "points.json", "job.json"] {
        assert_eq!(folder.result(&[name])["control_points"], expected, "{name}");
    }
    let finished = folder.fit_from(&curve(40), &["-"]);
    assert_eq!(finished.json()["control_points"], expected);
    assert!(
        finished.err.contains("<stdin>: curve of degree 3"),
        "{}",
        finished.err
    );
}

/// Files as people have them, and what is finished of them: docs/reference/command-line.md has the same table.
const ODD: [(&[u8], i32, &str); 23] = [
    (b"x;y\r\n0;0\r\n1,5;2\r\n3;1\r\n4,5;3\r\n", 0, "4 points"),
    (b"\xef\xbb\xbfx,y\r\n0,0\r\n1,2\r\n3,1\r\n", 0, "3 points"),
    (b"0 0\r1 2\r3 1\r", 0, "3 points"),
    (b"\"x\",\"y\"\n\"0\",\"0\"\n\"1\",\"2\"\n", 0, "2 points"),
    (b"0.0D0 0.0D0\n1.0D0 2.0D0\n3.0d0 1.0d0\n", 0, "3 points"),
    (b"# scan\n0 0 0\n1 2 2\n3 1 3\n# end\n", 0, "3 points"),
    (b"y,x\n2,1\n1,3\n3,4\n", 0, "3 points"),
    (
        b"0 0 0 255\n1 2 0 255\n3 1 0 255\n",
        0,
        "Columns 1, 2, 3 of 4 are the coordinates",
    ),
    (b"L\xe4nge;H\xf6he\n0;0\n1;2\n3;1\n", 0, "3 points"),
    (
        b"2,0\n3,1\n3,2\n2,3\n1,3\n0,2\n0,1\n1,0\n2,0\n",
        0,
        "the curve is closed",
    ),
    (
        b"TEST\n1 0\n.5 .06\n0 0\n.5 -.04\n1 0\n",
        0,
        "the curve stays open",
    ),
    (
        b"TEST\n 3. 3.\n\n0 0\n.5 .06\n1 0\n\n0 0\n.5 -.04\n1 0\n",
        0,
        "(Lednicer)",
    ),
    (
        b"0 0 0\n1 0 1\n\n0 1 0\n1 1 2\n",
        0,
        "2 rows of 2: blank lines",
    ),
    (
        b"0 0 0\n1 0 1\n2 0 3\n0 1 0\n1 1 2\n2 1 1\n",
        0,
        "2 rows of 3: x and y form a grid",
    ),
    (
        b"0 0 0\n0 1 1\n\n1 0 0\n",
        2,
        ":4: this part has one point, and a curve has at least 2",
    ),
    (
        b"x,y\n0,0\n1,2\n1,2\n3,1\n",
        0,
        "The point in line 4 equals the one before, and is kept once.",
    ),
    (
        b"x,y\n0,0\n1,2,5\n3,1\n",
        2,
        ":3: 3 columns here, and 2 in the first line of numbers",
    ),
    (
        b"x,y\n0,0\n1,two\n3,1\n",
        2,
        ":3: column 2: \"two\" is no number",
    ),
    (
        b"x,y\n0,0\n1,nan\n3,1\n",
        0,
        "The point in line 3 has no coordinates and is left out.",
    ),
    (
        b"0,0\n1,1e999\n3,1\n",
        2,
        ":2: column 2: \"1e999\" is no number",
    ),
    (b"", 2, "there are no points in the file"),
    (b"1,2\n", 2, "there is one point in the file"),
    (b"[[0,0],[1,2]", 2, ":1: EOF while parsing a list"),
];

#[test]
fn odd_files_are_fitted_or_refused_at_their_lines() {
    let folder = Folder::new();
    for (bytes, status, expected) in ODD {
        std::fs::write(folder.path("odd"), bytes).unwrap();
        let finished = folder.fit(&["odd"]);
        let file = String::from_utf8_lossy(bytes);
        assert_eq!(finished.status, status, "{file}: {}", finished.err);
        let lines: Vec<&str> = finished
            .err
            .lines()
            .filter(|it| it.starts_with("odd:"))
            .collect();
        assert!(
            lines.iter().any(|it| it.contains(expected)),
            "{file}: {}",
            finished.err
        );
        // What is refused is finished with the file, line by line, and nothing else is.
        let all = lines.len() == finished.err.lines().count();
        assert!(status == 0 || all, "{file}: {}", finished.err);
    }
}

/// Points of a scan in any order are no curve; they are scattered points of a surface.
#[test]
fn points_without_order_are_scattered() {
    let folder = Folder::new();
    folder.write("scan.xyz", include_str!("../../examples/scan.xyz"));
    let finished = folder.fit(&["scan.xyz"]);
    assert_eq!(
        (finished.status, finished.out.len()),
        (2, 0),
        "{}",
        finished.err
    );
    let lines: Vec<&str> = finished.err.lines().collect();
    assert_eq!(lines.len(), 1, "{}", finished.err);
    assert!(
        lines[0].starts_with("scan.xyz: the points have no order"),
        "{}",
        finished.err
    );
    assert!(lines[0].contains("--surface") && lines[0].contains("--order given"));
    let finished = folder.fit(&["scan.xyz", "--surface", "--control-points", "6x6"]);
    assert_eq!(
        (finished.status, &finished.json()["kind"]),
        (0, &json!("surface")),
        "{}",
        finished.err
    );
    assert!(
        finished.err.contains("scattered points of a surface"),
        "{}",
        finished.err
    );
    let set = "surface.parameters=project";
    let expected = folder.result(&[
        "scan.xyz",
        "--surface",
        "--control-points",
        "6x6",
        "--set",
        set,
    ]);
    assert_eq!(
        finished.json()["control_points"],
        expected["control_points"]
    );
    let finished = folder.fit(&["scan.xyz", "--order", "given", "--method", "direct"]);
    assert_eq!(finished.json()["kind"], "curve", "{}", finished.err);
    assert!(
        finished.err.contains("warning: fewer than a third"),
        "{}",
        finished.err
    );
}

/// The examples of the help run as they stand, with files of these names.
#[test]
fn examples_of_the_help_run() {
    let folder = Folder::new();
    folder.write("wing.dat", include_str!("../../examples/naca2412.dat"));
    folder.write("scan.xyz", include_str!("../../examples/scan.xyz"));
    folder.write("points.csv", &curve(40));
    let row = |i: u32| (0..60).map(move |j| format!("{i} {j} {}\n", f64::from(i * j % 7)));
    folder.write("grid.xyz", &(0..40).flat_map(row).collect::<String>());
    let help = folder.fit(&["--help"]).out;
    let help = String::from_utf8(help).unwrap();
    let commands = help
        .lines()
        .filter(|line| line.starts_with("  ") && line.contains("piad fit "));
    let here: Vec<&str> = commands.filter(|line| !line.contains("--server")).collect();
    assert_eq!(here.len(), 4, "{help}");
    let programs = std::path::Path::new(PROGRAM).parent().unwrap();
    for line in here {
        let path = format!("PATH={}:$PATH; {line}", programs.display());
        let mut shell = std::process::Command::new("sh");
        let output = shell.args(["-c", &path]).current_dir(folder.path("."));
        let finished = Finished::of(output.output().unwrap());
        assert_eq!(finished.status, 0, "{line}: {}", finished.err);
    }
    assert!(help.contains("iteration-00.step"), "{help}");
}

/// A bare array is what the same numbers in a table are: closed, or rows of heights.
#[test]
fn arrays_are_read_as_tables_are() {
    let folder = Folder::new();
    let outline = "2,0\n3,1\n3,2\n2,3\n1,3\n0,2\n0,1\n1,0\n2,0\n";
    folder.write("outline.csv", outline);
    let points: Vec<String> = outline.lines().map(|line| format!("[{line}]")).collect();
    folder.write("outline.json", &format!("[{}]", points.join(",")));
    let around = points.join(",").replacen("[2,0]", "[2,2.4e-16]", 1);
    folder.write("rounded.json", &format!("[{around}]"));
    for name in ["outline.csv", "outline.json", "rounded.json"] {
        for flags in [
            &["--tolerance", "1e-4"][..],
            &["--closed", "--tolerance", "1e-4"],
        ] {
            let finished = folder.fit(&[&[name], flags].concat());
            assert_eq!(finished.json()["closed"], true, "{name}: {}", finished.err);
            assert!(
                finished.err.contains("the curve is closed"),
                "{}",
                finished.err
            );
        }
    }
    folder.write(
        "heights.json",
        "[[1,2,3,4,2],[2,3,1,2,1],[1,0,1,2,3],[3,1,2,2,1]]",
    );
    let finished = folder.fit(&["heights.json", "--degree", "3,2"]);
    assert_eq!(finished.json()["kind"], "surface", "{}", finished.err);
    assert!(
        finished.err.contains("4 rows of 5 heights"),
        "{}",
        finished.err
    );
    let finished = folder.fit(&["heights.json", "-o", "out.step"]);
    assert_eq!(finished.status, 2, "{}", finished.err);
    assert!(
        finished.err.starts_with("out.step: step holds"),
        "{}",
        finished.err
    );
    // With a spacing they are points of space.
    let spacing = "surface.spacing=[10,10]";
    let finished = folder.fit(&["heights.json", "--set", spacing, "-o", "out.step"]);
    assert_eq!(finished.status, 0, "{}", finished.err);
    folder.write(
        "job.json",
        r#"{"surface": {"points": [[1,2,3,4],[2,3,1,2],[1,0,1,2]], "spacing": [1, 1], "degree": 2}}"#,
    );
    let finished = folder.fit(&["job.json", "-o", "out.step"]);
    assert_eq!(finished.status, 0, "{}", finished.err);
}

#[test]
fn scattered_points_are_no_outline() {
    let folder = Folder::new();
    folder.write(
        "scan.xyz",
        "2 0 0\n3 1 0\n3 2 1\n2 3 1\n1 3 0\n0 2 0\n0 1 1\n1 0 1\n2 0 0\n",
    );
    let flags = ["--surface", "--set", "surface.parameters=project"];
    let finished = folder.fit(
        &[
            &["scan.xyz", "--control-points", "2x2", "--degree", "1"],
            &flags[..],
        ]
        .concat(),
    );
    assert!(
        !finished.err.contains("the first one again"),
        "{}",
        finished.err
    );
    assert!(
        finished.err.contains("surface of degree 1 × 1"),
        "{}",
        finished.err
    );
}

#[test]
fn airfoils_keep_their_names() {
    let folder = Folder::new();
    folder.write("wing.dat", WING);
    let wing = folder.result(&["wing.dat", "--tolerance", "1e-4"]);
    assert_eq!(wing["name"], "NACA 2412");
    let wing = folder.result(&["wing.dat", "--set", "name=007"]);
    assert_eq!(wing["name"], "007");
}

#[test]
fn surfaces_are_said_or_seen() {
    let folder = Folder::new();
    folder.write("lattice.csv", &field(""));
    folder.write("blank.csv", &field("\n"));
    let points: Vec<Value> = field("")
        .lines()
        .map(|line| serde_json::from_str(&format!("[{}]", line.replace(' ', ","))).unwrap())
        .collect();
    folder.write("flat.json", &json!(points).to_string());
    let rows: Vec<&[Value]> = points.chunks(5).collect();
    folder.write("rows.json", &json!(rows).to_string());
    let expected = folder.result(&["lattice.csv"])["control_points"].clone();
    assert_eq!(expected.as_array().unwrap().len(), 8);
    assert_eq!(expected[0].as_array().unwrap().len(), 7);
    for arguments in [
        vec!["blank.csv"],
        vec!["blank.csv", "--surface"],
        vec!["lattice.csv", "--surface", "6x5"],
        vec!["flat.json", "--surface", "6x5"],
        vec!["rows.json"],
    ] {
        let result = folder.result(&arguments);
        assert_eq!(result["control_points"], expected, "{arguments:?}");
    }
    // Flags go where they belong without being finished whether it is a surface.
    for name in ["lattice.csv", "rows.json"] {
        let result = folder.result(&[name, "--degree", "3,1", "--ends", "repeated"]);
        assert_eq!(result["degree"], json!({"u": 3, "v": 1}), "{name}");
    }
    let scattered = folder.fit(&[
        "lattice.csv",
        "--surface",
        "--set",
        "surface.parameters=project",
        "--control-points",
        "4x4",
    ]);
    assert!(scattered.err.contains("surface"), "{}", scattered.err);
}

#[test]
fn flags_are_fields_of_the_job() {
    let folder = Folder::with_curve();
    let result = folder.result(&["curve.csv", "--method", "direct", "--degree", "2"]);
    assert_eq!(
        (&result["degree"], &result["iteration"]),
        (&json!(2), &json!(1))
    );
    let result = folder.result(&[
        "curve.csv",
        "--control-points",
        "9",
        "--set",
        "method.variant=direct",
    ]);
    assert_eq!(result["control_points"].as_array().unwrap().len(), 9);
    let finished = folder.fit(&[
        "curve.csv",
        "--control-points",
        "auto",
        "--tolerance",
        "1e-3",
    ]);
    let count = finished.json()["control_points"].as_array().unwrap().len();
    assert!(
        count < 30 && finished.err.contains(&format!("{count} control points")),
        "{}",
        finished.err
    );
    let zigzag = (0..17).map(|i: i32| format!("{i},{}\n", (i % 8 - 4).abs()));
    folder.write("zigzag.csv", &zigzag.collect::<String>());
    for corners in ["auto", "60deg", "4,8,12"] {
        let result = folder.result(&["zigzag.csv", "--corners", corners, "--method", "direct"]);
        let knots = result["knots"].as_array().unwrap();
        // Four pieces of five control points each.
        assert_eq!(knots.len(), 17 + 4, "{corners}");
        assert!(
            knots
                .windows(3)
                .filter(|knots| knots[0] == knots[2])
                .count()
                == 2 + 3 + 2,
            "{corners}: {knots:?}"
        );
    }
    let result = folder.result(&["curve.csv", "--closed", "--method", "chebyshev"]);
    assert_eq!(result["closed"], true);
    let result = folder.result(&[
        "curve.csv",
        "--basis",
        "bernstein",
        "--method",
        "direct",
        "--tolerance",
        "1",
    ]);
    assert_eq!(result["basis"], "bernstein");
    // Flags go over a file, which goes over the job.
    folder.write("job.json", r#"{"name": "job", "curve": {"degree": 5, "points": [[0,0],[1,2],[3,1],[4,3],[5,5],[7,4],[8,2]]}}"#);
    folder.write(
        "more.json",
        r#"{"name": "more", "curve": {"degree": 4}, "method": {"kind": "weighted", "omega": 1.2}}"#,
    );
    let result = folder.result(&["job.json", "--json", "more.json", "--degree", "3"]);
    assert_eq!(
        (&result["name"], &result["degree"]),
        (&json!("more"), &json!(3))
    );
    let result = folder.result(&["curve.csv", "--json", "more.json", "--method", "direct"]);
    assert_eq!(
        (&result["iteration"], &result["degree"]),
        (&json!(1), &json!(4))
    );
}

/// Points of a disc, which a surface is trimmed to.
#[test]
fn surfaces_are_trimmed() {
    let folder = Folder::with_curve();
    let part = |k: usize, step: f64| 20.0 * (k as f64 * step).fract() - 10.0;
    let points = (0..1500).map(|k| [part(k, 0.754_877_666), part(k, 0.569_840_29)]);
    let inside = points.filter(|[x, y]| x.hypot(*y) < 9.5);
    let lines = inside.map(|[x, y]| format!("{x} {y} {}\n", 0.01 * x * y));
    folder.write("disc.xyz", &lines.collect::<String>());
    let trim = |flags: &[&str]| {
        let fixed = ["disc.xyz", "--control-points", "5"];
        folder.result(&[&fixed[..], flags].concat())["trim"].clone()
    };
    let usual = trim(&["--trim"]);
    assert_eq!(usual["loops"].as_array().unwrap().len(), 1);
    let automatic = folder.result(&["disc.xyz", "--trim", "--tolerance", "0.1"]);
    assert_eq!(automatic["trim"]["loops"].as_array().unwrap().len(), 1);
    let wide = trim(&["--trim", "1.5"]);
    assert_eq!(wide["distance"], 1.5);
    assert!(wide["area"].as_f64() > usual["area"].as_f64());
    let finished = folder.fit(&["disc.xyz", "--trim", "-2", "--control-points", "5"]);
    assert_eq!(finished.status, 2, "{}", finished.err);
    assert!(finished.err.contains("--trim"), "{}", finished.err);
    let finished = folder.fit(&["--trim", "disc.xyz"]);
    assert!(
        finished.err.contains("a file comes before --trim"),
        "{}",
        finished.err
    );
}
