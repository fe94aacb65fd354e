//! Every kind of input.

use serde_json::{Value, json};

use crate::support::{Folder, curve, field};

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
    let told = folder.fit_from(&curve(40), &["-"]);
    assert_eq!(told.json()["control_points"], expected);
    assert!(
        told.err.contains("<stdin>: curve of degree 3"),
        "{}",
        told.err
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
    // Flags go where they belong without being told whether it is a surface.
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
    let told = folder.fit(&[
        "curve.csv",
        "--control-points",
        "auto",
        "--tolerance",
        "1e-3",
    ]);
    let count = told.json()["control_points"].as_array().unwrap().len();
    assert!(
        count < 30 && told.err.contains(&format!("{count} control points")),
        "{}",
        told.err
    );
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
