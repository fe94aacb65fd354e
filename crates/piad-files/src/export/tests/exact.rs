//! STEP, IGES, OBJ, and splines in DXF.

use super::*;
use crate::export::Version;

#[test]
fn step_has_all_in_one_set_with_their_names() {
    let text = text("mixed", Format::Step, &mixed(), Options::default());
    assert_eq!(text.matches("=PRODUCT(").count(), 1);
    assert!(text.contains("=PRODUCT('all of it'"));
    let splines: Vec<&str> = text
        .split(";\n")
        .filter(|it| it.contains("B_SPLINE_CURVE") || it.contains("B_SPLINE_SURFACE"))
        .collect();
    assert_eq!(splines.len(), 4);
    let name = "'H\\X2\\00F6\\X0\\he 5/7'";
    assert!(splines[0].contains(name) && splines[1].contains(name));
    assert!(splines[2].contains("REPRESENTATION_ITEM('curve')"));
    assert!(splines[3].contains("REPRESENTATION_ITEM('tube')"));
    let numbers = splines.iter().map(|it| it.split_once('=').unwrap().0);
    let members = numbers.collect::<Vec<_>>().join(",");
    assert!(text.contains(&format!("=GEOMETRIC_SET('',({members}));")));
    assert!(text.contains("GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION"));
    let curves = self::text("curves", Format::Step, &curves(), Options::default());
    assert!(curves.contains("=GEOMETRIC_CURVE_SET('',(#"));
    assert!(curves.contains("FILE_DESCRIPTION(('3 curves'),"));
    // Instances are numbered without gaps.
    for (number, statement) in (1..).zip(curves.split(";\n").filter(|it| it.starts_with('#'))) {
        assert!(statement.starts_with(&format!("#{number}=")), "{statement}");
    }
}

#[test]
fn iges_has_an_entity_for_each() {
    let text = text("mixed", Format::Iges, &mixed(), Options::default());
    let of = |section: char| -> Vec<&str> {
        let lines = text.lines().filter(|line| line[72..].starts_with(section));
        lines.collect()
    };
    let (directory, data) = (of('D'), of('P'));
    assert_eq!(directory.len(), 8);
    for (entry, lines) in directory.chunks(2).enumerate() {
        let field = |line: usize, i: usize| lines[line][8 * i..8 * i + 8].trim();
        let (first, count): (usize, usize) =
            (field(0, 1).parse().unwrap(), field(1, 3).parse().unwrap());
        let own = &data[first - 1..first - 1 + count];
        assert!(own[0].starts_with(&format!("{},", field(0, 0))));
        assert!(own[count - 1][..64].trim_end().ends_with(';'));
        let back = (2 * entry + 1).to_string();
        assert!(own.iter().all(|line| line[64..72].trim() == back));
        assert_eq!(field(1, 8), (entry + 1).to_string());
    }
    assert!(directory[1].contains("H?he 5/7") && directory[7].contains("    tube"));
    for (number, line) in (1..).zip(&data) {
        assert_eq!(line[73..].trim(), number.to_string());
    }
    let last = text.lines().last().unwrap();
    let counts = format!("D{:7}P{:7}", directory.len(), data.len());
    assert!(last.contains(&counts), "{last}");
}

#[test]
fn obj_numbers_vertices_over_all_parts() {
    let text = text("mixed", Format::Obj, &mixed(), Options::default());
    let joined = text.replace("\\\n", "");
    let numbers = |prefix: &str| -> Vec<Vec<f64>> {
        let lines = joined.lines().filter_map(|line| line.strip_prefix(prefix));
        let words = lines.map(|line| line.split_whitespace().map(|it| it.parse().unwrap()));
        words.map(Iterator::collect).collect()
    };
    assert_eq!(joined.matches("\no ").count(), 4);
    assert!(joined.contains("\no Höhe 5/7\nv 0.0"));
    assert_eq!(numbers("v ").len(), 5 + 8 + 3 + 6);
    let curves = numbers("curv ");
    assert_eq!(
        curves[1],
        [0.0, 1.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0]
    );
    assert_eq!(curves[2][2..], [14.0, 15.0, 16.0]);
    let surface = &numbers("surf ")[0];
    assert_eq!(surface[4..], [17.0, 19.0, 21.0, 18.0, 20.0, 22.0]);
}

/// The groups of a file.
pub(super) fn groups(text: &str) -> Vec<(u32, &str)> {
    let lines: Vec<&str> = text.lines().collect();
    lines
        .chunks_exact(2)
        .map(|pair| (pair[0].trim().parse().unwrap(), pair[1]))
        .collect()
}

#[test]
fn splines_of_dxf_have_all_numbers() {
    let options = Options {
        version: Version::R2000,
        ..Options::default()
    };
    let text = text("splines", Format::Dxf, &mixed(), options);
    assert!(text.is_ascii());
    let groups = groups(&text);
    let starts: Vec<usize> = (0..groups.len())
        .filter(|&i| groups[i] == (0, "SPLINE"))
        .collect();
    assert_eq!(starts.len(), 3);
    for (start, (part, layer)) in
        starts.into_iter().zip(
            curves()
                .iter()
                .zip(["H\\U+00F6he 5_7", "H\\U+00F6he 5_7_2", "0"]),
        )
    {
        let end = start + 1 + groups[start + 1..].iter().position(|it| it.0 == 0).unwrap();
        let own = &groups[start..end];
        let all = |code: u32| -> Vec<f64> {
            let found = own.iter().filter(|it| it.0 == code);
            found.map(|it| it.1.parse().unwrap()).collect()
        };
        let nurbs = &part.nurbs;
        assert!(own.contains(&(8, layer)), "{own:?}");
        assert_eq!(all(40), nurbs.u.knots);
        assert_eq!(all(41), nurbs.weights.clone().unwrap_or_default());
        let places: Vec<[f64; 3]> = (0..nurbs.rows()).map(|i| nurbs.place(i)).collect();
        for (c, code) in [10, 20, 30].into_iter().enumerate() {
            assert_eq!(all(code), places.iter().map(|it| it[c]).collect::<Vec<_>>());
        }
        assert_eq!(all(71), [nurbs.u.degree as f64]);
        assert_eq!(all(72), [nurbs.u.knots.len() as f64]);
        assert_eq!(all(73), [nurbs.rows() as f64]);
        let flags = all(70)[0] as u32;
        assert_eq!(flags & 3, if nurbs.u.closed { 3 } else { 0 });
        assert_eq!(flags & 4 > 0, nurbs.weights.is_some());
        assert_eq!(flags & 8, 8);
    }
}

/// Handles are there once, and owners and other references are handles.
#[test]
fn handles_of_dxf_are_unique() {
    let options = Options {
        version: Version::R2000,
        ..Options::default()
    };
    let text = text("handles", Format::Dxf, &mixed(), options);
    let groups = groups(&text);
    let number = |text: &str| u64::from_str_radix(text, 16).unwrap();
    let seed = groups.iter().position(|it| it.1 == "$HANDSEED").unwrap() + 1;
    let body = || groups[seed + 1..].iter();
    let handles: Vec<u64> = body()
        .filter(|it| matches!(it.0, 5 | 105))
        .map(|it| number(it.1))
        .collect();
    let mut sorted = handles.clone();
    sorted.sort_unstable();
    sorted.dedup();
    assert_eq!(sorted.len(), handles.len());
    assert_eq!(
        sorted.last().map(|last| last + 1),
        Some(number(groups[seed].1))
    );
    let references = body().filter(|it| matches!(it.0, 330 | 340 | 350 | 390));
    for (code, reference) in references {
        let reference = number(reference);
        let is_known = reference == 0 || sorted.binary_search(&reference).is_ok();
        assert!(is_known, "{code} {reference:X}");
    }
}
