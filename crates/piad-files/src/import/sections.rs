//! Parts of a file that are sections of one surface: curves across it, with different numbers of points.

use super::error::FileError;
use super::grid_detection;
use super::imported::{Hints, Kind};
use super::part::{Order, Part, Parts};
use piad_fit::engine::is_stack;

/// The hint for sections.
const SECTIONS: &str = "surface.sections";

/// The fewest points of a section that is recognised as one.
const FEWEST: usize = 4;

/// The parts as one of sections, where the hints ask for that or the file shows it: as several parts of a table of a
/// surface, or as closed curves of a table that lie one behind the other.
///
/// # Errors
///
/// If sections are requested and there is one part, or they have different numbers of coordinates.
pub(super) fn joined(mut parts: Parts, is_table: bool, hints: &Hints) -> Result<Parts, FileError> {
    if let [part] = &mut parts.parts[..] {
        let is_requested = hints.sections == Some(true);
        let is_surface = hints.kind == Some(Kind::Surface) && hints.sections.is_none();
        let are_rows = is_table && is_surface && grid_detection::are_uneven_rows(part, hints);
        if is_requested && part.breaks.is_empty() && !matches!(part.order, Order::Rows(_)) {
            let detail =
                "the file has one part, and sections are several: blank lines are between them";
            return Err(FileError::of_hint(SECTIONS, detail));
        }
        if is_requested || are_rows {
            make_sections(part);
        }
        return Ok(parts);
    }
    if !(hints.sections == Some(true) || is_table && are_shown(&parts.parts, hints)) {
        return Ok(parts);
    }
    let mut all = parts.parts.into_iter();
    let Some(mut whole) = all.next() else {
        return Ok(Parts::default());
    };
    whole.breaks.clear();
    whole.missing.clear();
    (whole.times, whole.name) = (None, None);
    for part in all {
        if part.points.dimension() != whole.points.dimension() {
            let detail = "the parts of the file have different numbers of coordinates: they are no sections of one surface";
            return Err(FileError::of_hint(SECTIONS, detail));
        }
        whole.breaks.push(whole.points.len());
        for index in 0..part.points.len() {
            whole
                .points
                .push(&part.points.point(index).collect::<Vec<_>>());
        }
        whole.lines.extend(part.lines);
        whole.notices.extend(part.notices);
    }
    make_sections(&mut whole);
    Ok(Parts {
        parts: vec![whole],
        notices: parts.notices,
    })
}

/// Returns true if nothing is requested, and the parts are closed curves one behind the other.
fn are_shown(parts: &[Part], hints: &Hints) -> bool {
    let is_open = hints.kind.is_none() && hints.sections.is_none() && hints.part.is_none();
    let in_space = |part: &Part| part.points.dimension() == 3 && part.points.len() >= FEWEST;
    is_open && parts.iter().all(in_space) && {
        let points: Vec<_> = parts.iter().map(|part| &part.points).collect();
        is_stack(&points)
    }
}

/// Makes a part one of sections.
fn make_sections(part: &mut Part) {
    if let Order::Rows(grid) = part.order {
        part.breaks = (1..grid.rows).map(|row| row * grid.columns).collect();
    }
    part.order = Order::Sections;
    let counts = part.counts();
    let (least, most) = counts.iter().fold((usize::MAX, 0), |(least, most), count| {
        (least.min(*count), most.max(*count))
    });
    let points = match least == most {
        true => most.to_string(),
        false => format!("{least} to {most}"),
    };
    part.notices.push(format!(
        "The file has {} sections of {points} points, of one surface.",
        counts.len()
    ));
}

#[cfg(test)]
mod tests {
    use crate::import::tests::HINTS;
    use crate::import::{Hints, Kind, read, read_parts};

    /// Rings around the z axis, or beside each other, with 8, 9, 10 … points.
    fn rings(step: [f64; 3]) -> String {
        let ring = |k: usize| {
            let count = 8 + k;
            let point = |i: usize| {
                let angle = std::f64::consts::TAU * i as f64 / count as f64;
                let [x, y, z] = step.map(|step| step * k as f64);
                format!("{},{},{z}\n", angle.cos() + x, angle.sin() + y)
            };
            (0..count).map(point).collect::<String>()
        };
        format!("x,y,z\n{}", [0, 1, 2].map(ring).join("\n"))
    }

    #[test]
    fn rings_of_a_tube_are_sections() {
        let text = rings([0.0, 0.0, 1.5]);
        let file = read(text.as_bytes(), &HINTS).unwrap();
        assert_eq!(file.sections, [8, 9, 10]);
        assert_eq!((file.points.len(), file.lines.len()), (27, 27));
        assert!(file.grid.is_none() && !file.unordered);
        let notice = &file.notices[0];
        assert_eq!(
            notice,
            "The file has 3 sections of 8 to 10 points, of one surface."
        );
        // They are curves if the hints say so.
        for hints in [
            Hints {
                kind: Some(Kind::Curve),
                ..HINTS
            },
            Hints {
                sections: Some(false),
                ..HINTS
            },
        ] {
            assert_eq!(read_parts(text.as_bytes(), &hints).unwrap().len(), 3);
        }
    }

    #[test]
    fn other_curves_are_sections_if_that_is_said() {
        let beside = rings([3.0, 0.0, 0.0]);
        assert_eq!(read_parts(beside.as_bytes(), &HINTS).unwrap().len(), 3);
        let lines = "0 0 0\n1 0 1\n2 0 0\n\n0 1 0\n1 1 2\n2 1 1\n3 1 0\n";
        assert_eq!(read_parts(lines.as_bytes(), &HINTS).unwrap().len(), 2);
        for hints in [
            Hints {
                sections: Some(true),
                ..HINTS
            },
            Hints {
                kind: Some(Kind::Surface),
                ..HINTS
            },
        ] {
            let file = read(beside.as_bytes(), &hints).unwrap();
            assert_eq!(file.sections, [8, 9, 10]);
            assert_eq!(read(lines.as_bytes(), &hints).unwrap().sections, [3, 4]);
        }
        // Rows of the same length are a grid, unless sections are requested.
        let rows = "0 0 0\n1 0 1\n\n0 1 0\n1 1 2\n";
        let sections = Hints {
            sections: Some(true),
            ..HINTS
        };
        assert!(read(rows.as_bytes(), &HINTS).unwrap().sections.is_empty());
        assert_eq!(read(rows.as_bytes(), &sections).unwrap().sections, [2, 2]);
        let one = read(b"0 0 0\n1 0 1\n2 0 0\n", &sections).unwrap_err();
        assert!(one.to_string().contains("sections are several"), "{one}");
    }
}
