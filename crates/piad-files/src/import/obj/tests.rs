use crate::import::tests::HINTS;
use crate::import::{Hints, Imported, Kind, read as read_file, read_parts};

fn surface(text: &str) -> Result<Imported, String> {
    let kind = Some(Kind::Surface);
    read_file(text.as_bytes(), &Hints { kind, ..HINTS }).map_err(|errors| errors.to_string())
}

fn curves(text: &str) -> Result<Vec<Imported>, String> {
    read_parts(text.as_bytes(), &HINTS).map_err(|errors| errors.to_string())
}

const VERTICES: &str = "v 0 0 0\nv 1 0 1\nv 2 0.5 0\nv 3 2 0\n";

#[test]
fn vertices_are_the_points() {
    let text = format!(
        "# a mesh\nmtllib a.mtl\no cap\n{VERTICES}vt 0 0\nvn 0 0 1\ns off\nf 1/1/1 2/1/1 3/1/1\nf 1 3 4\n"
    );
    for end in ["\n", "\r\n", "\r"] {
        let mesh = surface(&text.replace('\n', end)).unwrap();
        assert_eq!(mesh.points.lane(0), [0.0, 1.0, 2.0, 3.0], "{end:?}");
        assert_eq!(
            (mesh.lines.as_slice(), mesh.unordered),
            (&[4, 5, 6, 7][..], true)
        );
        assert_eq!(mesh.name.as_deref(), Some("cap"));
        let notice = "The file has a mesh of 4 vertices and 2 faces (OBJ).";
        assert_eq!(mesh.notices[0], notice);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    }
    let other = "v 0 0 0 2\nv 1 0 1 255 0 0 # red\nvp 1 2\ncstype bspline\nv 2 \\\n0.5 \\\n 0\nf 1 2 3\nand more\n";
    let other = surface(other).unwrap();
    assert_eq!(
        (other.points.lane(1)[2], &other.lines[..]),
        (0.5, &[1, 2, 5][..])
    );
    assert_eq!(
        other.notices[1],
        "The weights of the vertices are not read."
    );
    assert_eq!(
        other.notices[2],
        "The colours of the vertices are not read."
    );
    assert!(other.notices[3].starts_with("The free-form curves and surfaces"));
    assert_eq!(other.notices[4], "Line 9 is not understood and not read.");
    // A table with such a name is not OBJ.
    assert_eq!(surface("v\n1 2\n3 4\n").unwrap().points.len(), 2);
}

#[test]
fn polylines_are_curves() {
    let text = format!("o first\n{VERTICES}l 1 2/7 3\no next one\nl -1 -2 \\\n-3 -4\n");
    let parts = curves(&text).unwrap();
    let points = |part: &Imported| part.points.lane(0).to_vec();
    assert_eq!(
        parts.iter().map(points).collect::<Vec<_>>(),
        [vec![0.0, 1.0, 2.0], vec![3.0, 2.0, 1.0, 0.0]]
    );
    assert_eq!(
        (&parts[0].lines[..], &parts[1].lines[..]),
        (&[2, 3, 4][..], &[5, 4, 3, 2][..])
    );
    assert_eq!(parts[1].name.as_deref(), Some("next one"));
    assert_eq!(parts[0].notices, ["The file has 2 polylines (OBJ)."]);
    assert!(!parts[0].unordered);
    // Lines of two vertices that follow each other, in either direction.
    for lines in ["l 1 2\nl 2 3\nl 3 4\n", "l 2 1\nl 3 2\nl 3 4\n"] {
        let parts = curves(&format!("{VERTICES}{lines}f 1 2 3\n")).unwrap();
        assert_eq!(
            parts.iter().map(points).collect::<Vec<_>>(),
            [[0.0, 1.0, 2.0, 3.0]]
        );
        assert_eq!(
            parts[0].notices,
            [
                "The file has a polyline (OBJ).",
                "The faces of the file are not read (1)."
            ]
        );
    }
    let parts = curves(&format!("{VERTICES}l 1 2\nl 3 4\n")).unwrap();
    assert_eq!(parts.len(), 2);
    // A line of three vertices is one of its own.
    let parts = curves(&format!("{VERTICES}l 1 2 3\nl 3 4\n")).unwrap();
    assert_eq!(parts.len(), 2);
}

#[test]
fn errors_name_their_lines() {
    let good = format!("{VERTICES}l 1 2 3\n");
    for (from, to, expected) in [
        (
            "v 1 0 1",
            "v 1 0",
            "line 2: this vertex has 2 numbers, and not 3, 4, 6 or 7 (OBJ)",
        ),
        ("v 1 0 1", "v 1 oops 1", "line 2: \"oops\" is no number"),
        ("v 1 0 1", "v 1 nan 1", "line 2: \"nan\" is no number"),
        (
            "l 1 2 3",
            "l 1",
            "line 5: a polyline has at least 2 vertices, and this one 1",
        ),
        (
            "l 1 2 3",
            "l 1 x",
            "line 5: \"x\" is not the number of a vertex (OBJ)",
        ),
        (
            "l 1 2 3",
            "l 1 0",
            "line 5: \"0\" is not the number of a vertex (OBJ)",
        ),
        (
            "l 1 2 3",
            "l 1 -5",
            "line 5: \"-5\" is not the number of a vertex (OBJ)",
        ),
        (
            "l 1 2 3",
            "l 1 -9223372036854775808",
            "line 5: \"-9223372036854775808\" is not the number of a vertex (OBJ)",
        ),
        (
            "l 1 2 3",
            "l 1 5",
            "line 5: there is no vertex 5, the file has 4 (OBJ)",
        ),
    ] {
        assert_eq!(curves(&good.replacen(from, to, 1)).unwrap_err(), expected);
    }
    let most = |most| read_parts(good.as_bytes(), &Hints { most, ..HINTS });
    let limit = "line 4: there are more than 3 points, the limit";
    assert_eq!(most(3).unwrap_err().to_string(), limit);
    let long = good.replace("l 1 2 3", "l 1 2 3 4 3 2 1");
    let long = read_parts(long.as_bytes(), &Hints { most: 6, ..HINTS }).unwrap_err();
    assert_eq!(
        long.to_string(),
        "line 5: there are more than 6 points, the limit"
    );
    assert_eq!(
        surface("o nothing\nv 0 0 0\n").unwrap_err(),
        "there is one point in the file, and a curve has at least 2"
    );
}
