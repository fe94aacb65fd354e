use super::*;
use crate::import::tests::HINTS;
use crate::import::{Imported, Kind, read as read_file};

fn surface(bytes: &[u8]) -> Result<Imported, String> {
    let kind = Some(Kind::Surface);
    read_file(bytes, &Hints { kind, ..HINTS }).map_err(|errors| errors.to_string())
}

const HEAD: &str = "element vertex 3\nproperty uchar red\nproperty float x\nproperty list uchar short near\nproperty double y\nproperty int z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";

const POINTS: [f64; 9] = [1.5, 0.1, -3.0, -2.0, 1e30, 4.0, 0.0, 0.25, 7.0];

/// The bytes of the face.
const FACE: usize = 13;

/// The vertices of `POINTS` in binary, and a face.
fn binary(big: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (near, point) in POINTS.chunks(3).enumerate() {
        let mut put = |little: &[u8]| match big {
            true => bytes.extend(little.iter().rev()),
            false => bytes.extend_from_slice(little),
        };
        put(&[200]);
        put(&(point[0] as f32).to_le_bytes());
        put(&[near as u8]);
        (0..near).for_each(|_| put(&7_i16.to_le_bytes()));
        put(&point[1].to_le_bytes());
        put(&(point[2] as i32).to_le_bytes());
    }
    bytes.push(3);
    for index in 0..3_i32 {
        let index = if big {
            index.to_be_bytes()
        } else {
            index.to_le_bytes()
        };
        bytes.extend(index);
    }
    bytes
}

fn of(format: &str, body: &[u8]) -> Vec<u8> {
    let mut file = format!("ply\nformat {format} 1.0\ncomment by hand\n{HEAD}").into_bytes();
    file.extend_from_slice(body);
    file
}

#[test]
fn vertices_are_the_points() {
    let text = b"200 1.5 0 0.1 -3\n\n200 -2 1 7 1e30 4\n200 0 2 7 7 .25 7\n3 0 1 2\n";
    let plain = surface(&of("ascii", text)).unwrap();
    assert_eq!(plain.points.to_flat(), POINTS);
    assert_eq!(
        (plain.lines.as_slice(), plain.unordered),
        (&[13, 15, 16][..], true)
    );
    for (format, big) in [("binary_little_endian", false), ("binary_big_endian", true)] {
        let file = surface(&of(format, &binary(big))).unwrap();
        assert_eq!(file.points, plain.points, "{format}");
        assert!(file.lines.is_empty());
        assert_eq!(file.notices, plain.notices);
    }
    assert_eq!(
        plain.notices[..2],
        [
            "The file has a mesh of 3 vertices and one face (PLY).",
            "Properties of the points that are not read: \"red\", \"near\"."
        ]
    );
    // As points of a curve they have no order.
    let hints = Hints {
        kind: Some(Kind::Curve),
        ..HINTS
    };
    let curve = read_file(&of("ascii", text), &hints).unwrap_err();
    assert!(curve.0[0].detail.contains("no order"), "{curve}");
}

#[test]
fn lines_end_in_any_way() {
    let text = "ply\nformat ascii 1.0\nobj_info a scan\nelement vertex 2\nproperty float X\nproperty float Y\nend_header\n1 2\n3 4\n";
    for end in ["\n", "\r\n", "\r"] {
        let file = surface(text.replace('\n', end).as_bytes()).unwrap();
        assert_eq!(file.points.to_flat(), [1.0, 2.0, 3.0, 4.0], "{end:?}");
        assert_eq!(file.lines, [8, 9]);
        // Bytes of binary data that look like ends of lines.
        let head = text.split_once("end_header").unwrap().0;
        let head = format!("{head}end_header\n").replace('\n', end);
        let mut bytes = head.replace("ascii", "binary_little_endian").into_bytes();
        let newline = f32::from_le_bytes(*b"\n\n\r\n");
        (0..4).for_each(|_| bytes.extend(newline.to_le_bytes()));
        let file = surface(&bytes).unwrap();
        assert_eq!(file.points.lane(0), [f64::from(newline); 2], "{end:?}");
    }
}

#[test]
fn elements_above_the_vertices_are_passed_over() {
    let head = "element camera 2\nproperty float a\nelement list 2\nproperty list uchar int b\nelement nothing 1000000000000000000\nelement vertex 2\nproperty float x\nproperty float y\nend_header\n";
    let text = format!("ply\nformat ascii 1.0\n{head}1\n2\n2 5 6\n0\n1 2\n3 4\n");
    assert_eq!(surface(text.as_bytes()).unwrap().points.lane(1), [2.0, 4.0]);
    let mut bytes = format!("ply\nformat binary_big_endian 1.0\n{head}").into_bytes();
    bytes.extend([0; 8]);
    bytes.extend([2, 0, 0, 0, 5, 0, 0, 0, 6, 0]);
    for x in [1_f32, 2.0, 3.0, 4.0] {
        bytes.extend(x.to_be_bytes());
    }
    assert_eq!(surface(&bytes).unwrap().points.lane(1), [2.0, 4.0]);
    let early = &bytes[..bytes.len() - 17];
    assert_eq!(
        surface(early).unwrap_err(),
        "the file has 0 vertices, and says that it has 2 (PLY)"
    );
}

#[test]
fn errors_name_the_reason() {
    let good = String::from_utf8(of("ascii", b"200 1 0 2 3\n200 4 0 5 6\n200 7 0 8 8\n")).unwrap();
    for (from, to, expected) in [
        (
            "200 7 0 8 8\n",
            "",
            "the file has 2 vertices, and says that it has 3 (PLY)",
        ),
        (
            "vertex 3",
            "vertex 1000000000000000000",
            "the file has 3 vertices, and says that it has 1000000000000000000 (PLY)",
        ),
        (
            "vertex 3",
            "vertex 1000000000000000000000",
            "line 4: \"element vertex 1000000000000000000000\" is not a line of a PLY header",
        ),
        (
            "vertex 3",
            "points 3",
            "the header has no element vertex (PLY)",
        ),
        (
            "float x",
            "float q",
            "line 4: the vertices have no properties x and y (PLY)",
        ),
        (
            "float x",
            "quad x",
            "line 6: \"property quad x\" is not a line of a PLY header",
        ),
        (
            "element vertex 3\n",
            "",
            "line 4: \"property uchar red\" is not a line of a PLY header",
        ),
        (
            "ascii",
            "ebcdic",
            "line 2: \"format ebcdic 1.0\" is not a line of a PLY header",
        ),
        (
            "format ascii 1.0\n",
            "",
            "the header has no line format (PLY)",
        ),
        (
            "end_header\n",
            "",
            "line 12: \"200 1 0 2 3\" is not a line of a PLY header",
        ),
        (
            "200 4 0 5 6",
            "200 4 0 oops 6",
            "line 14: \"y\": \"oops\" is no number",
        ),
        (
            "200 4 0 5 6",
            "200 4 0 5",
            "line 14: this vertex has no \"z\", its properties end before",
        ),
        (
            "200 4 0 5 6",
            "200 4 9999999999 5 6",
            "line 14: this vertex has no \"near\", its properties end before",
        ),
        (
            "200 4 0 5 6",
            "200 4 0 5 6 7",
            "line 14: there is more in this line than the properties of a vertex",
        ),
    ] {
        let broken = good.replacen(from, to, 1);
        assert_eq!(surface(broken.as_bytes()).unwrap_err(), expected);
    }
    let head = good.split_once("end_header").unwrap().0;
    assert_eq!(
        surface(head.as_bytes()).unwrap_err(),
        "the header has no end_header (PLY)"
    );
    let few = Hints { most: 2, ..HINTS };
    let many = read_file(good.as_bytes(), &few).unwrap_err();
    assert_eq!(
        many.to_string(),
        "line 15: there are more than 2 points, the limit"
    );
    // One vertex has a list of one item more than the last.
    let mut bytes = of("binary_little_endian", &binary(false));
    bytes.truncate(bytes.len() - FACE);
    assert_eq!(
        surface(&bytes).unwrap_err(),
        "the file has 0 faces, and says that it has 1 (PLY)"
    );
    bytes.pop();
    assert_eq!(
        surface(&bytes).unwrap_err(),
        "the file has 2 vertices, and says that it has 3 (PLY)"
    );
    // Tables that could be PLY are tables.
    assert_eq!(surface(b"ply\n1 2\n3 4\n").unwrap().points.len(), 2);
}

#[test]
fn points_that_are_none_are_left_out() {
    let file = surface(&of(
        "ascii",
        b"0 1 0 2 3\n0 nan 0 nan nan\n0 7 0 8 8\n3 0 1 2\n",
    ))
    .unwrap();
    assert_eq!((file.points.len(), file.lines), (2, vec![13, 15]));
    assert!(
        file.notices
            .contains(&"1 point has no coordinates and is left out.".to_owned())
    );
    // With the other byte order a file has other numbers, but never makes the reader panic.
    if let Ok(swapped) = surface(&of("binary_little_endian", &binary(true))) {
        assert_ne!(swapped.points.to_flat(), POINTS);
    }
}
