use proptest::prelude::*;

use crate::import::tests::HINTS;
use crate::import::{FileErrors, Hints, Imported, read_parts};

const MANY: Hints = Hints {
    most: 2000,
    ..HINTS
};

/// A file of these entities, `code value` each, after a header of 10 lines.
fn file(entities: &str) -> String {
    let header = "0 SECTION\n2 HEADER\n9 $INSUNITS\n70 4\n0 ENDSEC\n";
    let text = format!("{header}0 SECTION\n2 ENTITIES\n{entities}\n0 ENDSEC\n0 EOF\n");
    let pairs = text.lines().filter(|line| !line.trim().is_empty());
    pairs
        .map(|pair| pair.trim().replacen(' ', "\n", 1) + "\n")
        .collect()
}

fn parts(entities: &str) -> Result<Vec<Imported>, FileErrors> {
    read_parts(file(entities).as_bytes(), &MANY)
}

fn line(layer: &str, ends: [i32; 4]) -> String {
    let [a, b, c, d] = ends;
    format!("0 LINE\n8 {layer}\n10 {a}\n20 {b}\n30 0.0\n11 {c}\n21 {d}\n31 0\n")
}

fn points(part: &Imported) -> Vec<Vec<f64>> {
    (0..part.points.len())
        .map(|i| part.points.point(i).collect())
        .collect()
}

/// Checks that all points are this far from the centre.
fn check_radius(part: &Imported, centre: [f64; 2], radius: f64) {
    for point in points(part) {
        let distance = (point[0] - centre[0]).hypot(point[1] - centre[1]);
        assert!((distance - radius).abs() < 1e-9, "{point:?}");
    }
}

#[test]
fn polylines_are_parts_of_their_layers() {
    let polyline = |flags: u32| {
        format!("0 LWPOLYLINE\n8 C0\n90 3\n70 {flags}\n10 0\n20 0\n10 2\n20 0\n10 2\n20 1\n")
    };
    let text = format!("{}{}", polyline(0), polyline(129));
    let found = parts(&text).unwrap();
    assert_eq!(found.len(), 2);
    assert_eq!(points(&found[0]), [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]]);
    assert_eq!(found[0].lines, [24, 28, 32]);
    let names = found.iter().map(|part| part.name.as_deref());
    assert_eq!(names.collect::<Vec<_>>(), [Some("C0"), Some("C0 2")]);
    assert_eq!((found[0].closed, found[1].closed), (false, true));
    assert_eq!(found[0].notices, ["The drawing is in millimetres."]);
    // With a height, and turned over.
    let high = polyline(0).replace("90 3", "90 3\n38 7\n210 0\n220 0\n230 -1");
    let found = parts(&high).unwrap();
    assert_eq!(points(&found[0])[1], [-2.0, 0.0, -7.0]);
}

#[test]
fn bulges_are_arcs() {
    // Half a circle to the right of the way from 0 to 2, and a line back.
    let text = "0 LWPOLYLINE\n70 1\n10 0\n20 0\n42 1\n10 2\n20 0\n";
    let part = parts(text).unwrap().remove(0);
    assert_eq!(part.points.len(), 37);
    check_radius(&part, [1.0, 0.0], 1.0);
    assert!(part.points.lane(1).iter().all(|y| *y <= 1e-12));
    assert!(part.notices[1].contains("sampled"), "{:?}", part.notices);
    // A quarter to the left, in the form of R12.
    let bulge = -(std::f64::consts::PI / 8.0).tan();
    let text = format!(
        "0 POLYLINE\n66 1\n8 A\n70 0\n0 VERTEX\n10 1\n20 0\n42 {bulge}\n0 VERTEX\n10 0\n20 1\n42 5\n0 SEQEND\n8 A\n"
    );
    let part = parts(&text).unwrap().remove(0);
    assert_eq!(part.points.len(), 19);
    check_radius(&part, [1.0, 1.0], 1.0);
    assert_eq!(part.name.as_deref(), Some("A"));
}

#[test]
fn polylines_in_space_and_meshes() {
    let vertex =
        |x: u32, z: u32, flags: u32| format!("0 VERTEX\n10 {x}\n20 1\n30 {z}\n70 {flags}\n");
    let vertices: String = [(0, 5, 32), (9, 9, 16), (1, 6, 32), (2, 5, 32)]
        .map(|(x, z, flags)| vertex(x, z, flags))
        .concat();
    let text =
        format!("0 POLYLINE\n70 8\n{vertices}0 SEQEND\n0 POLYLINE\n70 16\n{vertices}0 SEQEND\n");
    let part = parts(&text).unwrap().remove(0);
    let expected = [[0.0, 1.0, 5.0], [1.0, 1.0, 6.0], [2.0, 1.0, 5.0]];
    assert_eq!(points(&part), expected);
    let notice = "Entities that are not read: 1 POLYLINE that is a mesh.";
    assert_eq!(part.notices[1], notice);
}

#[test]
fn lines_and_arcs_that_meet_are_one_curve() {
    let arc = "0 ARC\n8 A\n10 2\n20 1\n40 1\n50 270\n51 90\n";
    let text = [
        line("A", [0, 0, 2, 0]),
        line("B", [2, 0, 5, 5]),
        arc.to_owned(),
        line("A", [0, 2, 2, 2]),
        line("A", [0, 2, 0, 0]),
    ];
    let found = parts(&text.concat()).unwrap();
    let names = found.iter().map(|part| part.name.as_deref());
    assert_eq!(names.collect::<Vec<_>>(), [Some("A"), Some("B")]);
    assert_eq!((found[0].points.len(), found[0].closed), (39, true));
    assert_eq!(points(&found[0])[38], [0.0, 2.0]);
    // A contour of many lines takes no more points than it has.
    let contour: String = (0..1999)
        .map(|i| line("C", [i, i % 2, i + 1, (i + 1) % 2]))
        .collect();
    assert_eq!(parts(&contour).unwrap()[0].points.len(), 2000);
}

#[test]
fn circles_and_ellipses_are_sampled() {
    let circle = "0 CIRCLE\n10 3\n20 4\n40 5\n";
    let part = parts(circle).unwrap().remove(0);
    assert_eq!((part.points.len(), part.closed), (72, true));
    check_radius(&part, [3.0, 4.0], 5.0);
    let ellipse = "0 ELLIPSE\n10 0\n20 0\n11 2\n21 0\n40 0.5\n41 0\n42 6.283185307179586\n";
    let part = parts(ellipse).unwrap().remove(0);
    assert_eq!((part.points.len(), part.closed), (72, true));
    for point in points(&part) {
        assert!((point[0].powi(2) / 4.0 + point[1].powi(2) - 1.0).abs() < 1e-12);
    }
    let half = ellipse.replace("6.283185307179586", "1e300");
    assert!(parts(&half).unwrap()[0].points.len() <= 73);
    let cloud = "0 POINT\n8 P\n10 0\n20 0\n0 TEXT\n1 a\n0 POINT\n8 P\n10 1\n20 2\n";
    let part = parts(cloud).unwrap().remove(0);
    assert_eq!(points(&part), [[0.0, 0.0], [1.0, 2.0]]);
    assert_eq!(part.notices[1], "Entities that are not read: 1 TEXT.");
}

#[test]
fn splines_are_their_fit_points_or_sampled() {
    let fit = "0 SPLINE\n70 8\n71 3\n74 3\n11 0\n21 0\n31 0\n11 1\n21 2\n31 0\n11 3\n21 3\n31 0\n";
    let part = parts(fit).unwrap().remove(0);
    assert_eq!(points(&part), [[0.0, 0.0], [1.0, 2.0], [3.0, 3.0]]);
    // A quarter of a circle as a rational curve of degree 2.
    let weight = std::f64::consts::FRAC_1_SQRT_2;
    let control = "10 1\n20 0\n10 1\n20 1\n10 0\n20 1\n";
    let knots = "40 0\n40 0\n40 0\n40 1\n40 1\n40 1\n";
    let weights = format!("41 1\n41 {weight}\n41 1\n");
    let text = format!("0 SPLINE\n70 12\n71 2\n{knots}{weights}{control}");
    let part = parts(&text).unwrap().remove(0);
    assert_eq!(part.points.len(), 17);
    check_radius(&part, [0.0, 0.0], 1.0);
    // A closed one with knots that do not repeat.
    let knots: String = (0..11).map(|i| format!("40 {i}\n")).collect();
    let corners = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 0), (0, 1), (-1, 0)];
    let control = corners.map(|(x, y)| format!("10 {x}\n20 {y}\n")).concat();
    let text = format!("0 SPLINE\n70 11\n71 3\n{knots}{control}");
    let part = parts(&text).unwrap().remove(0);
    assert_eq!((part.points.len(), part.closed), (64, true));
    for (old, new, detail) in [
        ("40 10\n", "", "which do not fit"),
        ("71 3", "71 99999999999", "is of degree"),
        ("40 3\n", "40 33\n", "decrease"),
        ("70 11", "41 0", "positive weight"),
        ("40 3\n", "40 x\n", "\"x\" is not a number (group 40)"),
    ] {
        let error = parts(&text.replace(old, new)).unwrap_err();
        assert!(error.to_string().contains(detail), "{error}");
    }
}

#[test]
fn errors_name_their_lines() {
    for (text, line, detail) in [
        (
            "0 LINE\n10 0\n20 0\n11 1\n",
            16,
            "this LINE has no y (group 11)",
        ),
        (
            "0 LINE\n10 0\n20 a\n",
            20,
            "\"a\" is not a number (group 20)",
        ),
        (
            "0 CIRCLE\n10 0\n20 0\n40 -1\n",
            16,
            "the radius of this CIRCLE is -1",
        ),
        ("0 LINE\nx 0\n", 17, "\"x\" is not a group code of DXF"),
        (
            "0 CIRCLE\n40 1\n10 1\n20 1\n210 0\n",
            16,
            "the extrusion direction",
        ),
    ] {
        let error = parts(text).unwrap_err().0.remove(0);
        assert_eq!(error.line, Some(line), "{error}");
        assert!(error.detail.starts_with(detail), "{error}");
    }
    let few = Hints { most: 30, ..HINTS };
    let circle = file("0 CIRCLE\n10 3\n20 4\n40 5\n");
    let error = read_parts(circle.as_bytes(), &few).unwrap_err();
    assert!(error.to_string().contains("more than 30 points"), "{error}");
    let binary = b"AutoCAD Binary DXF\r\n\x1a\0\0SECTION\0";
    let error = read_parts(binary, &HINTS).unwrap_err();
    assert!(error.to_string().contains("binary DXF"), "{error}");
    let nothing = parts("0 TEXT\n1 a\n").unwrap_err();
    assert_eq!(nothing.to_string(), "there are no points in the file");
}

#[test]
fn files_that_are_cut_off_are_refused() {
    let whole = file(&line("A", [0, 0, 1, 1])).replace('\n', "\r\n");
    let end = whole.rfind("0\r\nENDSEC").unwrap();
    assert!(read_parts(whole.as_bytes(), &HINTS).is_ok());
    for end in (20..end).step_by(5) {
        assert!(read_parts(&whole.as_bytes()[..end], &HINTS).is_err());
    }
    let around = format!("\n999\na comment\n  {whole}\n\n");
    assert!(read_parts(around.as_bytes(), &HINTS).is_ok());
    let blocks = "0\nSECTION\n2\nBLOCKS\n0\nLINE\n10\n0\n0\nENDSEC\n";
    let inserts = format!("0 INSERT\n2 a\n10 0\n20 0\n{}", line("A", [0, 0, 1, 1]));
    let text = format!("{blocks}{}", file(&inserts));
    let part = read_parts(text.as_bytes(), &HINTS).unwrap().remove(0);
    assert_eq!(
        part.notices[1],
        "Entities that are not read: 1 INSERT of a block without entities in the file."
    );
}

/// The names of blocks, and their entities.
type Blocks<'a> = &'a [(&'a str, &'a str)];

/// The parts of a drawing with these blocks and entities.
fn with_blocks(blocks: Blocks<'_>, entities: &str) -> Result<Vec<Imported>, FileErrors> {
    let block =
        |(name, inner): &(&str, &str)| format!("0 BLOCK\n2 {name}\n10 1\n20 1\n{inner}0 ENDBLK\n");
    let blocks: String = blocks.iter().map(block).collect();
    let text = format!(
        "0 ENDSEC\n0 SECTION\n2 BLOCKS\n{blocks}0 ENDSEC\n0 SECTION\n2 ENTITIES\n{entities}"
    );
    parts(&text)
}

fn insert(block: &str, more: &str) -> String {
    format!("0 INSERT\n2 {block}\n8 placed\n10 10\n20 20\n{more}")
}

#[test]
fn blocks_are_where_references_place_them() {
    let vee = "0 LWPOLYLINE\n8 own\n10 1\n20 1\n10 2\n20 1\n10 2\n20 3\n";
    let points_of = |entities: &str| {
        let found = with_blocks(&[("vee", vee)], entities).unwrap();
        found.iter().map(points).collect::<Vec<_>>()
    };
    let near = |found: &[Vec<f64>], expected: &[[f64; 2]]| {
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            let distance = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            assert!(distance < 1e-12, "{found:?} {expected:?}");
        }
    };
    // The base of the block is placed at the reference.
    let plain = points_of(&insert("vee", ""));
    near(&plain[0], &[[10.0, 20.0], [11.0, 20.0], [11.0, 22.0]]);
    let turned = points_of(&insert("vee", "41 2\n42 3\n50 90\n"));
    near(&turned[0], &[[10.0, 20.0], [10.0, 22.0], [4.0, 22.0]]);
    let mirrored = points_of(&insert("vee", "41 -1\n"));
    near(&mirrored[0], &[[10.0, 20.0], [9.0, 20.0], [9.0, 22.0]]);
    // Turned over, its place is in its own coordinate system.
    let below = points_of(&insert("vee", "210 0\n220 0\n230 -1\n"));
    near(&below[0], &[[-10.0, 20.0], [-11.0, 20.0], [-11.0, 22.0]]);
    // Rows and columns.
    let all = points_of(&insert("vee", "70 2\n71 3\n44 5\n45 7\n"));
    assert_eq!(all.len(), 6);
    assert_eq!(
        (&all[1][0], &all[5][0]),
        (&vec![15.0, 20.0], &vec![15.0, 34.0])
    );
    let found = with_blocks(&[("vee", vee)], &insert("vee", "")).unwrap();
    assert_eq!(found[0].name.as_deref(), Some("own"));
    assert_eq!(
        found[0].notices[1],
        "1 INSERTs are read as the entities of their blocks."
    );
}

#[test]
fn blocks_in_blocks_are_read() {
    let line = "0 LINE\n8 0\n10 1\n20 1\n11 2\n21 1\n";
    let arc = "0 ARC\n8 0\n10 1\n20 2\n40 1\n50 270\n51 360\n";
    let point = "0 POINT\n8 own\n10 1\n20 1\n0 POINT\n8 own\n10 5\n20 1\n";
    let outer = format!(
        "{}{}{}",
        insert("line", "8 0\n"),
        insert("line", "50 90\n").replace("8 placed", "8 0"),
        insert("points", "41 2\n")
    );
    let blocks = [
        ("outer", &*outer),
        ("line", line),
        ("arc", arc),
        ("points", point),
    ];
    let found = with_blocks(
        &blocks,
        &(insert("outer", "41 2\n42 2\n") + &insert("arc", "")),
    )
    .unwrap();
    let names: Vec<_> = found.iter().map(|part| part.name.as_deref()).collect();
    // Layer 0 of a block is that of its reference. Lines of two blocks meet.
    assert_eq!(names, [Some("placed"), Some("own"), Some("placed 2")]);
    assert_eq!(
        points(&found[0]),
        [[28.0, 60.0], [28.0, 58.0], [30.0, 58.0]].map(Vec::from)
    );
    assert_eq!(
        points(&found[1]),
        [[28.0, 58.0], [44.0, 58.0]].map(Vec::from)
    );
    check_radius(&found[2], [10.0, 21.0], 1.0);
}

#[test]
fn blocks_have_limits() {
    let line = "0 LINE\n10 1\n20 1\n11 2\n21 1\n";
    let twice = |name: &str| insert(name, "").repeat(2);
    let cases: [(Blocks<'_>, String, &str); 5] = [
        (
            &[("a", &twice("a"))],
            insert("a", ""),
            "nested more than 16 deep",
        ),
        (
            &[("a", &twice("b")), ("b", &twice("a"))],
            insert("a", ""),
            "nested more than 16 deep",
        ),
        (
            &[("a", line)],
            insert("a", "70 30000\n71 30000\n"),
            "more than 2000 points",
        ),
        (
            &[("a", line)],
            insert("a", "41 x\n"),
            "\"x\" is not a number (group 41)",
        ),
        (
            &[("a", line)],
            insert("a", "41 1e308\n").replace("10 10", "10 1e308"),
            "too large",
        ),
    ];
    for (blocks, entities, detail) in cases {
        let error = with_blocks(blocks, &entities).unwrap_err();
        assert!(error.to_string().contains(detail), "{error}");
    }
    // A few nested references place very many entities, even if these have no points.
    let inner: Vec<(String, String)> = (0..12)
        .map(|i| {
            (
                format!("b{i}"),
                insert(&format!("b{}", i + 1), "").repeat(10),
            )
        })
        .collect();
    let blocks: Vec<(&str, &str)> = inner
        .iter()
        .map(|(name, inner)| (&**name, &**inner))
        .collect();
    let error = with_blocks(&blocks, &insert("b0", "")).unwrap_err();
    assert!(
        error.to_string().contains("more than 1000000 groups"),
        "{error}"
    );
    let error =
        with_blocks(&[("a", line)], &insert("a", "70 300\n71 300\n44 2\n45 2\n")).unwrap_err();
    assert!(
        error.to_string().contains("more than 2000 points"),
        "{error}"
    );
    let missing = with_blocks(&[("a", "")], &(insert("a", "") + &insert("b", "") + line)).unwrap();
    assert!(missing[0].notices[1].contains("2 INSERT of a block without entities"));
}

proptest! {
    #[test]
    fn no_entities_panic(
        names in prop::collection::vec("LINE|ARC|CIRCLE|ELLIPSE|LWPOLYLINE|POLYLINE|VERTEX|SEQEND|SPLINE|POINT|INSERT|BLOCK|ENDBLK", 1..6),
        groups in prop::collection::vec(("[1-4][0-2]|7[0-4]|2[1-3]0", "-?[0-9]{1,2}|1e300|1e-300"), 0..60),
    ) {
        let mut groups = groups.into_iter();
        let mut text = String::new();
        for name in names {
            text += &format!("0 {name}\n");
            for (code, value) in groups.by_ref().take(10) {
                text += &format!("{code} {value}\n");
            }
        }
        let _ = parts(&text);
    }
}
