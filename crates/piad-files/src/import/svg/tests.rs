use proptest::prelude::*;

use crate::import::tests::HINTS;
use crate::import::{FileErrors, Hints, Imported, read_parts};

const MANY: Hints = Hints {
    most: 1000,
    ..HINTS
};

fn parts(body: &str) -> Result<Vec<Imported>, FileErrors> {
    let text = format!(
        "<?xml version=\"1.0\"?>\n<!-- made -->\n<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 200 100\">\n{body}\n</svg>"
    );
    read_parts(text.as_bytes(), &MANY)
}

fn points(part: &Imported) -> Vec<Vec<f64>> {
    (0..part.points.len())
        .map(|i| part.points.point(i).collect())
        .collect()
}

#[test]
fn outlines_are_upright_in_their_groups() {
    let found = parts(
        "<g transform='translate(10 5)'>\n<path id='a' d='M0 0 H80 V40 l-20 20 H0 z M1 1 2 2'/><g transform='scale(2)' style='fill:none'><polyline points='1,1 2,2 3,1'/></g></g>\n<polygon points='0 0 1 0 1 1'/>",
    )
    .unwrap();
    let names: Vec<_> = found.iter().map(|part| part.name.as_deref()).collect();
    assert_eq!(names, [Some("a"), Some("a 2"), None, None]);
    let expected = [[10, 95], [90, 95], [90, 55], [70, 35], [10, 35]];
    assert_eq!(
        points(&found[0]),
        expected.map(|point| point.map(f64::from))
    );
    assert_eq!((found[0].closed, found[1].closed), (true, false));
    assert_eq!(found[0].lines, [5; 5]);
    assert_eq!(points(&found[2])[0], [12.0, 93.0]);
    assert!(found[3].closed);
    assert_eq!(
        found[0].notices,
        ["y points up, as in CAD: it is 100 minus that of the file, where it points down."]
    );
}

#[test]
fn basic_shapes_are_outlines() {
    let found = parts(
        "<line x1='1' y1='2' x2='3' y2='4'/><rect x='10' y='10' width='20' height='10'/><rect width='20' height='10' rx='2'/><circle cx='50' cy='50' r='25.4mm'/><ellipse rx='4' ry='2'/><rect width='4' height='4' rx='9'/>",
    )
    .unwrap();
    let counts: Vec<_> = found.iter().map(|part| part.points.len()).collect();
    assert_eq!(counts, [2, 4, 4 + 4 * 18, 72, 72, 72]);
    let closed: Vec<_> = found.iter().map(|part| part.closed).collect();
    assert_eq!(closed, [false, true, true, true, true, true]);
    for point in points(&found[3]) {
        assert!(((point[0] - 50.0).hypot(point[1] - 50.0) - 96.0).abs() < 1e-9);
    }
    assert!(found[3].notices[1].contains("sampled"));
    assert_eq!(found[1].notices.len(), 1);
}

#[test]
fn skipped_elements_are_reported() {
    let found = parts(
        "<defs><path d='M0 0 9 9'/><clipPath><rect width='1' height='1'/></clipPath></defs><symbol><path d='M0 0 9 9'/></symbol>\n<use href='#a'/><use href='#b'/><text>a<path d='M0 0 1 1'/></text><svg><path d='M0 0 1 1'/></svg>\n<path style='stroke: red; display : none' d='M0 0 1 1'/><g display='none'><path d='M0 0 1 1'/></g>\n<rect width='100%' height='100%'/><x:path d='M0 0 1 1'/><path d='M1 1 2 2'/>",
    )
    .unwrap();
    assert_eq!(found.len(), 1);
    assert_eq!(
        found[0].notices[1..],
        [
            "Elements that are not read: 1 rect with lengths in % or of fonts, 1 svg, 1 text, 2 use of what is not in the file.",
            "2 elements are hidden (display: none), and are left out."
        ]
    );
}

#[test]
fn references_are_drawn_where_they_are() {
    let defs = "<defs><path id='a' d='M0 0 1 0 1 1'/><g id='b' transform='scale(2)'><use href='#a' x='1'/></g></defs>\n";
    let uses = "<use href='#a' transform='translate(10 0)' x='1' y='2'/><use xlink:href='#b' x='5'/>\n<path id='c' d='M7 7 8 8'/><use href='#c' y='1'/>";
    let found = parts(&format!("{uses}{defs}")).unwrap();
    let firsts: Vec<_> = found
        .iter()
        .map(|part| points(part)[..2].to_vec())
        .collect();
    let expected = [
        [[11.0, 98.0], [12.0, 98.0]],
        [[7.0, 100.0], [9.0, 100.0]],
        [[7.0, 93.0], [8.0, 92.0]],
        [[7.0, 92.0], [8.0, 91.0]],
    ];
    assert_eq!(
        firsts,
        expected.map(|two| two.map(Vec::from)).map(Vec::from)
    );
    let names: Vec<_> = found.iter().map(|part| part.name.as_deref()).collect();
    assert_eq!(names, ["a", "a 2", "c", "c 2"].map(Some));
    assert_eq!(found[0].lines[0], 5);
    // Symbols are drawn by references only, fitted into their windows.
    let symbol = "<symbol id='s'><path d='M0 0 1 1'/></symbol><symbol id='w' viewBox='10 10 20 10'><path d='M10 10 30 20'/></symbol>";
    let uses =
        "<use href='#s' x='3'/><use href='#w' x='100' width='40' height='40'/><use href='#w'/>";
    let found = parts(&format!("{symbol}{uses}")).unwrap();
    assert_eq!(found.len(), 2);
    assert_eq!(
        points(&found[0]),
        [[3.0, 100.0], [4.0, 99.0]].map(Vec::from)
    );
    assert_eq!(
        points(&found[1]),
        [[100.0, 90.0], [140.0, 70.0]].map(Vec::from)
    );
    assert_eq!(
        found[0].notices[1],
        "Elements that are not read: 1 symbol in a window of unknown size."
    );
}

#[test]
fn references_have_limits() {
    for body in [
        "<g id='a'><use href='#a'/></g>",
        "<g id='a'><use href='#b'/></g><g id='b'><use href='#a'/></g>",
    ] {
        let error = parts(body).unwrap_err().to_string();
        assert!(error.contains("nested more than 16 deep"), "{error}");
    }
    let group = |i: u32| {
        let inner = format!("<use href='#g{}'/>", i + 1).repeat(10);
        format!("<g id='g{i}'>{inner}</g>")
    };
    let many: String = (0..15).map(group).collect();
    let error = parts(&format!("{many}<g id='g15'/>"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("more than 16 MiB"), "{error}");
    let curves = format!("<path id='a' d='M0 0{}'/>", " 1 1".repeat(300));
    let error = parts(&(curves + &"<use href='#a'/>".repeat(3))).unwrap_err();
    assert!(
        error.to_string().contains("more than 1000 points"),
        "{error}"
    );
}

#[test]
fn sizes_of_drawings_are_said() {
    for (attributes, y, notice) in [
        (
            "width='100mm' viewBox='0 10 200 100'",
            119.0,
            Some("is 0.5 mm of"),
        ),
        ("width='100' height='50px'", 49.0, None),
        ("", -1.0, None),
        ("viewBox='0 0 x'", -1.0, None),
        ("width='1in' viewBox='0 0 0 100'", 99.0, None),
    ] {
        let text = format!(
            "<!DOCTYPE svg PUBLIC 'a' 'b' [<!ENTITY ns 'c'>]><s:svg xmlns:s='&ns;' {attributes}><s:path d='M0 1 5 1'/></s:svg>"
        );
        let part = read_parts(text.as_bytes(), &HINTS).unwrap().remove(0);
        assert_eq!(part.points.lane(1)[0], y, "{attributes}");
        let found = part.notices.get(1).map(String::as_str).unwrap_or_default();
        assert!(found.contains(notice.unwrap_or_default()), "{found}");
        assert_eq!(found.is_empty(), notice.is_none(), "{found}");
    }
}

#[test]
fn errors_name_their_lines() {
    for (body, detail) in [
        (
            "<path d='M0 0 L1 1 x'/>",
            "line 4: the data of this path is wrong from \"x\" on",
        ),
        (
            "\n<polyline points='0 0 1 1 2'/>",
            "line 5: these points are wrong from \"2\" on",
        ),
        (
            "<g transform='turn(1)'/>",
            "line 4: \"turn(1)\" is no transform",
        ),
        ("<g>", "line 5: this is no XML"),
        ("<text/>", "there are no points in the file"),
        ("<path d='M0 0'/>", "there are no points in the file"),
        (
            "<g transform='scale(1e300)'><path d='M0 0 1e300 0'/></g>",
            "line 4: the coordinates of a point are too large",
        ),
    ] {
        let error = parts(body).unwrap_err().to_string();
        assert!(error.starts_with(detail), "{error}");
    }
    let curves = "c1 1 1 1 1 2".repeat(100);
    let error = parts(&format!("<path d='M0 0{curves}'/>")).unwrap_err();
    assert!(
        error.to_string().contains("more than 1000 points"),
        "{error}"
    );
    let cut = b"<svg><path d='M0 0 1 1'/>";
    assert!(read_parts(cut, &HINTS).is_err());
    let deep = format!("{}{}", "<g>".repeat(100_000), "</g>".repeat(100_000));
    assert!(parts(&deep).is_err());
}

proptest! {
    #[test]
    fn no_path_panics(data in "M[MmLlHhVvCcSsQqTtAaZz0-9 .,eE-]{0,60}", rotation in "[a-z(),0-9 ]{0,20}") {
        let _ = parts(&format!("<path d='{data}'/>"));
        let _ = parts(&format!("<path transform='{rotation}' d='M0 0 1 1'/>"));
    }
}
