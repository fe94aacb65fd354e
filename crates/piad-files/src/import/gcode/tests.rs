use proptest::prelude::*;

use super::is_gcode;
use crate::import::tests::HINTS;
use crate::import::{FileErrors, Hints, Imported, read_parts};

const MANY: Hints = Hints {
    most: 1000,
    ..HINTS
};

fn parts(text: &str) -> Result<Vec<Imported>, FileErrors> {
    read_parts(text.as_bytes(), &MANY)
}

fn points(part: &Imported) -> Vec<Vec<f64>> {
    (0..part.points.len())
        .map(|i| part.points.point(i).collect())
        .collect()
}

#[test]
fn paths_are_parts_between_rapid_moves() {
    let text = "%\nO100 (a plate)\nN10 G21 G90 G17 ; modes\nG0 X0 Y0 Z5\nG1 Z-1 F100\nX10\nY5 (up)\ng91 x-2 y1\nG90 G0 Z5\nX20\nG1 Z-1\nX30 Y1\nG1 X31\nM5\nM30\n%\n";
    let found = parts(text).unwrap();
    assert_eq!(found.len(), 2);
    let expected = [[0.0, 0.0], [10.0, 0.0], [10.0, 5.0], [8.0, 6.0]];
    assert_eq!(points(&found[0]), expected);
    assert_eq!(found[0].lines, [5, 6, 7, 8]);
    assert_eq!(points(&found[1]), [[20.0, 6.0], [30.0, 1.0], [31.0, 1.0]]);
    assert_eq!(
        found[0].notices,
        [
            "The coordinates are in millimetres (G21).",
            "Moves straight up or down at the ends of paths are left out.",
            "All points have z = -1, which is left out."
        ]
    );
    // Where the tool is before is not known, and its height counts where it changes.
    let part = parts("G1 X1 Y1\nX2 Z1\nX3 Z2\n").unwrap().remove(0);
    assert_eq!(
        points(&part),
        [[1.0, 1.0, 0.0], [2.0, 1.0, 1.0], [3.0, 1.0, 2.0]]
    );
    let part = parts("G91 G1 X1 Y1\nX2\n").unwrap().remove(0);
    assert_eq!(points(&part), [[0.0, 0.0], [1.0, 1.0], [3.0, 1.0]]);
}

#[test]
fn arcs_are_sampled() {
    for (arc, end, count) in [
        ("G3 X0 Y1 I-1 J0", [0.0, 1.0], 19),
        ("G2 X0 Y1 I-1 J0", [0.0, 1.0], 55),
        ("G03 X0 Y1 R1", [0.0, 1.0], 19),
        ("G02 X0 Y1 R1", [0.0, 1.0], 0),
        ("G2 X0 Y1 R-1", [0.0, 1.0], 55),
        ("G3 X-1 Y0 R0.99999", [-1.0, 0.0], 37),
        ("G90.1 G3 X0 Y1 I0 J0", [0.0, 1.0], 19),
    ] {
        let part = parts(&format!("G0 X1 Y0\n{arc}\n")).unwrap().remove(0);
        let found = points(&part);
        // One of the arcs with a radius has its centre elsewhere.
        if count > 0 {
            assert_eq!(found.len(), count, "{arc}");
            for point in &found {
                assert!((point[0].hypot(point[1]) - 1.0).abs() < 1e-4, "{arc}");
            }
        }
        assert_eq!(found.last().map(Vec::as_slice), Some(&end[..]), "{arc}");
        assert!(part.notices[0].contains("sampled"));
    }
    let circle = parts("G0 X1 Y0\nG2 I-1\n").unwrap().remove(0);
    assert_eq!((circle.points.len(), circle.closed), (72, true));
    // A helix, and an arc of another plane.
    let helix = parts("G0 X1 Y0 Z0\nG3 X-1 Z1 I-1 J0\n").unwrap().remove(0);
    assert_eq!(points(&helix)[18][2], 0.5);
    let across = parts("G0 X1 Y7 Z0\nG18 G2 X0 Z1 I-1 K0\n")
        .unwrap()
        .remove(0);
    for point in points(&across) {
        assert!((point[0].hypot(point[2]) - 1.0).abs() < 1e-12);
        assert_eq!(point[1], 7.0);
    }
    for (arc, detail) in [
        ("G2 X5", "line 2: this arc has no centre"),
        (
            "G2 X1 R1",
            "line 2: an arc with a radius (R) ends elsewhere",
        ),
        (
            "G2 X5 R1",
            "line 2: no arc of radius 1 leads to a place 4 away",
        ),
        ("G2 X5 R0", "line 2: no arc of radius 0 leads"),
        ("G2 X9 I-1", "line 2: the ends of this arc are 1 and 9 away"),
    ] {
        let error = parts(&format!("G0 X1 Y0\n{arc}\n")).unwrap_err();
        assert!(error.to_string().starts_with(detail), "{error}");
    }
}

#[test]
fn statements_without_a_path_are_skipped() {
    let text = "G20 G0 X0 Y0\nG1 X1 Y1 A5\nG28 Z0\nG1 X2 Y2\nG1 X3 Y2\nG81 X5 Y5 Z-1 R1\nX6\nG80\nG4 X2\nG1 X7 Y7\nG92 X0 Y0\nG1 X1 Y2\n";
    let found = parts(text).unwrap();
    let all: Vec<_> = found.iter().map(points).collect();
    assert_eq!(
        all,
        [
            vec![[0.0, 0.0], [1.0, 1.0]],
            vec![[2.0, 2.0], [3.0, 2.0], [7.0, 7.0]],
            vec![[0.0, 0.0], [1.0, 2.0]]
        ]
    );
    assert_eq!(
        found[0].notices,
        [
            "The coordinates are in inches (G20).",
            "Words that are not read: 1 A, 1 G81, 1 G92."
        ]
    );
    // A printer: moves without material are not paths.
    let text = "M104 S200\nG92 E0\nG1 X0 Y0 F9000\nG1 X1 Y0 E1\nG1 X1 Y1 E2\nG1 E1\nG1 X5 Y5\nG1 X6 Y5 E3\nM117 done\n";
    let found = parts(text).unwrap();
    assert_eq!(points(&found[0]), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    assert_eq!(points(&found[1]), [[5.0, 5.0], [6.0, 5.0]]);
    assert!(found[0].notices[0].contains("feed no material"));
}

#[test]
fn errors_name_their_lines() {
    for (text, detail) in [
        (
            "G1 X1 Y1\nG1 X#5 Y[2]\n",
            "line 2: \"X#5 Y[2]\" is not a word",
        ),
        ("G20 G1 X1 Y1\nX2\nG21\n", "line 3: the units change here"),
        ("G0 X1 Y1\nX2\n", "there are no points in the file"),
    ] {
        let error = parts(text).unwrap_err();
        assert!(error.to_string().starts_with(detail), "{error}");
    }
    let circles = "G1 X1 Y0\n".to_owned() + &"G2 I-1\n".repeat(20);
    let error = parts(&circles).unwrap_err();
    assert!(
        error.0[0].detail.contains("more than 1000 points"),
        "{error}"
    );
    let far = format!("G1 X{} Y0\nX0\n", "9".repeat(400));
    let error = parts(&far).unwrap_err();
    assert!(error.to_string().contains("too large"), "{error}");
}

#[test]
fn tables_are_no_gcode() {
    for (text, expected) in [
        ("%\n\n(a)\nG0 X1\n", true),
        ("\u{feff}; made\r\nN1 G21\r\nN2 G1 X1 Y1\r\n", true),
        ("T1\nM6\nG0 Z5\n", true),
        ("N0012\n1.0 0.0\n0.5 0.1\n", false),
        ("X1 Y2\nX2 Y3\n", false),
        ("G1\nG2\n", false),
        ("x,y\n1,2\n", false),
        ("G1 X1 is no G-code\n", false),
        ("", false),
    ] {
        let text = text.trim_start_matches('\u{feff}');
        assert_eq!(is_gcode(text), expected, "{text}");
    }
}

proptest! {
    #[test]
    fn no_program_panics(text in "(G(0|1|2|3|17|18|19|28|81|90|91|92|91\\.1|90\\.1)? ?|[XYZIJKREP]-?[0-9]{1,3}(\\.[0-9])?|\n){0,60}") {
        let _ = parts(&format!("G0 X0 Y0\n{text}"));
    }
}
