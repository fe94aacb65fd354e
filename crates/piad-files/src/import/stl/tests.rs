use crate::import::tests::HINTS;
use crate::import::{Hints, Imported, Kind, read as read_file};

fn surface(bytes: &[u8]) -> Result<Imported, String> {
    let kind = Some(Kind::Surface);
    read_file(bytes, &Hints { kind, ..HINTS }).map_err(|errors| errors.to_string())
}

/// Two triangles with an edge in common.
const CORNERS: [[f32; 3]; 6] = [
    [0.0, 0.0, 1.5],
    [1.0, 0.0, 0.25],
    [1.0, 1.0, 7.0],
    [-0.0, 0.0, 1.5],
    [1.0, 1.0, 7.0],
    [0.0, 1.0, -3.0],
];

const POINTS: [f64; 12] = [0.0, 0.0, 1.5, 1.0, 0.0, 0.25, 1.0, 1.0, 7.0, 0.0, 1.0, -3.0];

fn binary(title: &str, corners: &[[f32; 3]], said: u32) -> Vec<u8> {
    let mut bytes = title.as_bytes().to_vec();
    bytes.resize(80, 0);
    bytes.extend(said.to_le_bytes());
    for triangle in corners.chunks(3) {
        for number in [0.0, 0.0, 1.0].iter().chain(triangle.iter().flatten()) {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend([0x34, 0x12]);
    }
    bytes
}

fn text(corners: &[[f32; 3]]) -> String {
    let mut text = "solid a cap\n".to_owned();
    for triangle in corners.chunks(3) {
        text += "  facet normal 0 0 1\n    outer loop\n";
        for [x, y, z] in triangle {
            text += &format!("      vertex {x:e} {y} {z}\n");
        }
        text += "    endloop\n  endfacet\n";
    }
    text + "endsolid a cap\n"
}

#[test]
fn corners_are_points_once() {
    for title in ["", "solid by a program", "OFF", "ply\nformat ascii 1.0\n"] {
        let file = surface(&binary(title, &CORNERS, 2)).unwrap();
        assert_eq!(file.points.to_flat(), POINTS, "{title:?}");
        assert!(file.unordered && file.lines.is_empty());
        assert_eq!(
            file.notices[0],
            "The file has a mesh of 4 vertices and 2 triangles (STL)."
        );
    }
    for (from, to) in [
        ("\n", "\n"),
        ("\n", "\r\n"),
        ("\n", "\r"),
        ("vertex", "VERTEX"),
    ] {
        let file = surface(text(&CORNERS).replace(from, to).as_bytes()).unwrap();
        assert_eq!(file.points.to_flat(), POINTS, "{to:?}");
        assert_eq!(file.lines, [4, 5, 6, 13]);
        assert_eq!(file.name.as_deref(), Some("a cap"));
    }
    let two = text(&CORNERS[..3]) + &text(&CORNERS[3..]);
    assert_eq!(surface(two.as_bytes()).unwrap().points.to_flat(), POINTS);
    // A title is not STL.
    assert_eq!(surface(b"solid\n1 2\n3 4\n").unwrap().points.len(), 2);
}

#[test]
fn sizes_of_binary_files_match() {
    let whole = binary("made by hand", &CORNERS, 2);
    let error = |bytes: &[u8]| surface(bytes).unwrap_err();
    let says = |count: u32| binary("made by hand", &CORNERS, count);
    assert_eq!(
        error(&whole[..180]),
        "the file has 1 triangles, and says that it has 2 (STL)"
    );
    assert_eq!(
        error(&says(u32::MAX)),
        "the file has 2 triangles, and says that it has 4294967295 (STL)"
    );
    assert_eq!(
        error(&says(1)),
        "the file has 50 bytes below its 1 triangles (STL)"
    );
    assert_eq!(
        error(&[&whole[..], b"\r\n"].concat()),
        "the file has 2 bytes below its 2 triangles (STL)"
    );
    // No triangles, the other byte order, and invalid triangles.
    assert_eq!(
        error(&binary("", &[], 0)),
        "there are no points in the file"
    );
    let swapped: Vec<u8> = whole[80..]
        .chunks(4)
        .flat_map(|it| it.iter().rev().copied())
        .collect();
    let swapped = [&whole[..80], &swapped].concat();
    assert!(error(&swapped).contains("unknown format"));
    let few = Hints { most: 3, ..HINTS };
    let many = read_file(&whole, &few).unwrap_err();
    assert_eq!(many.to_string(), "there are more than 3 points, the limit");
    let broken = [
        [f32::NAN, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, f32::INFINITY, 1.0],
    ];
    let broken = binary("", &[&CORNERS[..], &broken].concat(), 3);
    let broken = surface(&broken).unwrap();
    assert_eq!(broken.points.len(), 4);
    assert!(broken.notices[1].starts_with("2 points have no coordinates"));
}

#[test]
fn errors_in_text_name_their_lines() {
    let whole = text(&CORNERS);
    for (from, to, expected) in [
        (
            "endsolid a cap\n",
            "",
            "the file ends below 2 triangles, without endsolid (STL)",
        ),
        (
            "vertex 1e0 0",
            "vertex 1e0 oops",
            "line 5: \"vertex 1e0 oops 0.25\" is no vertex with three numbers (STL)",
        ),
        (
            "vertex 1e0 0",
            "vertex 1e0 0 9",
            "line 5: \"vertex 1e0 0 9 0.25\" is no vertex with three numbers (STL)",
        ),
        (
            "vertex 1e0 0",
            "vertices 0 0",
            "line 5: \"vertices 0 0 0.25\" is not a line of an STL file",
        ),
        (
            "      vertex 1e0 0 0.25\n",
            "",
            "line 7: the triangle that ends here has 2 corners",
        ),
        (
            "  endfacet\n",
            "",
            "line 8: \"facet normal 0 0 1\" has no place here (STL)",
        ),
        (
            "  endfacet\n",
            "  endfacet\nvertex 1 2 3\n",
            "line 9: \"vertex 1 2 3\" has no place here (STL)",
        ),
    ] {
        let broken = whole.replacen(from, to, 1);
        assert_eq!(surface(broken.as_bytes()).unwrap_err(), expected);
    }
    let few = Hints { most: 3, ..HINTS };
    let many = read_file(whole.as_bytes(), &few).unwrap_err();
    assert_eq!(
        many.to_string(),
        "line 13: there are more than 3 points, the limit"
    );
}
