//! The data of paths: commands and their numbers.

use super::pen::{ArcShape, Pen, Place};
use super::scan::Scanner;

/// The control point before the last place, which smooth curves reflect.
#[derive(Clone, Copy)]
enum Control {
    None,
    Cubic(Place),
    Quadratic(Place),
}

/// Draws the data of a path, until there are more points than a limit.
///
/// # Errors
///
/// The invalid text.
pub(super) fn draw<'a>(data: &'a str, pen: &mut Pen, most: usize) -> Result<(), &'a str> {
    let mut scanner = Scanner::new(data);
    let mut control = Control::None;
    let mut command = None;
    while !scanner.is_at_end() && pen.count() <= most {
        let before = scanner;
        // Numbers without a letter before them repeat the command; lines follow the first place of `M`.
        let next = scanner.letter().or(match command {
            Some('M') => Some('L'),
            Some('m') => Some('l'),
            Some('Z' | 'z') => None,
            command => command,
        });
        let is_begun = command.is_some() || matches!(next, Some('M' | 'm'));
        let drawn = next.filter(|_| is_begun).and_then(|letter| {
            let drawn = step(letter, &mut scanner, pen, control)?;
            Some((letter, drawn))
        });
        let Some((letter, drawn)) = drawn else {
            return Err(before.rest);
        };
        (command, control) = (Some(letter), drawn);
    }
    Ok(())
}

/// Draws what one command does once; `None` if its numbers are missing.
fn step(
    letter: char,
    scanner: &mut Scanner<'_>,
    pen: &mut Pen,
    control: Control,
) -> Option<Control> {
    let [x, y] = pen.place;
    let origin = match letter.is_ascii_lowercase() {
        true => pen.place,
        false => [0.0; 2],
    };
    let at = |dx: f64, dy: f64| [origin[0] + dx, origin[1] + dy];
    let mirrored = |[cx, cy]: Place| [2.0 * x - cx, 2.0 * y - cy];
    match letter.to_ascii_uppercase() {
        'M' => {
            let [x, y] = scanner.numbers()?;
            pen.move_to(at(x, y));
        }
        'L' => {
            let [x, y] = scanner.numbers()?;
            pen.line_to(at(x, y));
        }
        'H' => pen.line_to([origin[0] + scanner.number()?, y]),
        'V' => pen.line_to([x, origin[1] + scanner.number()?]),
        'C' => {
            let [a, b, c, d, x, y] = scanner.numbers()?;
            pen.cubic_to(at(a, b), at(c, d), at(x, y));
            return Some(Control::Cubic(at(c, d)));
        }
        'S' => {
            let [c, d, x, y] = scanner.numbers()?;
            let first = match control {
                Control::Cubic(before) => mirrored(before),
                _ => pen.place,
            };
            pen.cubic_to(first, at(c, d), at(x, y));
            return Some(Control::Cubic(at(c, d)));
        }
        'Q' => {
            let [a, b, x, y] = scanner.numbers()?;
            pen.quadratic_to(at(a, b), at(x, y));
            return Some(Control::Quadratic(at(a, b)));
        }
        'T' => {
            let [x, y] = scanner.numbers()?;
            let middle = match control {
                Control::Quadratic(before) => mirrored(before),
                _ => pen.place,
            };
            pen.quadratic_to(middle, at(x, y));
            return Some(Control::Quadratic(middle));
        }
        'A' => {
            let [rx, ry, rotation] = scanner.numbers()?;
            let (large, sweep) = (scanner.flag()?, scanner.flag()?);
            let [x, y] = scanner.numbers()?;
            let shape = ArcShape {
                radii: [rx, ry],
                rotation,
                large,
                sweep,
            };
            pen.arc_to(shape, at(x, y));
        }
        'Z' => pen.close(),
        _ => return None,
    }
    Some(Control::None)
}

#[cfg(test)]
mod tests {
    use super::super::scan::Transform;
    use super::*;
    use crate::import::curves::Curve;

    fn drawn(data: &str) -> Result<Vec<Curve>, &str> {
        let mut pen = Pen::new(Transform::IDENTITY, 7);
        draw(data, &mut pen, 1000)?;
        Ok(pen.curves())
    }

    fn places(curve: &Curve) -> Vec<Place> {
        curve.points.iter().map(|[x, y, _]| [*x, *y]).collect()
    }

    #[test]
    fn lines_keep_their_corners() {
        let found = drawn("m1 1 h2v2,1 1H0zl1-1M5,5L6 6 7,7m1 0 1 1").unwrap();
        let expected = [
            vec![[1.0, 1.0], [3.0, 1.0], [3.0, 3.0], [3.0, 4.0], [3.0, 5.0]],
            vec![[1.0, 1.0], [2.0, 0.0]],
            vec![[5.0, 5.0], [6.0, 6.0], [7.0, 7.0]],
            vec![[8.0, 7.0], [9.0, 8.0]],
        ];
        // "v2,1 1" are three steps down, and "H0" leads back to the axis.
        let mut first = expected[0].clone();
        first.push([0.0, 5.0]);
        assert_eq!(places(&found[0]), first);
        assert_eq!(found[0].lines, [7; 6]);
        let rest: Vec<_> = found[1..].iter().map(places).collect();
        assert_eq!(rest, expected[1..]);
        let closed: Vec<bool> = found.iter().map(|curve| curve.closed).collect();
        assert_eq!(closed, [true, false, false, false]);
    }

    #[test]
    fn curves_are_sampled() {
        for (data, end, middle) in [
            ("M0 0C0 1 1 1 1 0", [1.0, 0.0], [0.5, 0.75]),
            ("M0 0Q.5 1.5 1 0", [1.0, 0.0], [0.5, 0.75]),
            ("M0 0c0 1 1 1 1 0s1-1 1 0", [2.0, 0.0], [1.0, 0.0]),
            ("M0 0Q.5 1.5 1 0t1 0", [2.0, 0.0], [1.0, 0.0]),
            ("M0 0A1 1 0 012 0", [2.0, 0.0], [1.0, -1.0]),
        ] {
            let curve = drawn(data).unwrap().remove(0);
            let places = places(&curve);
            assert_eq!(places.last(), Some(&end), "{data}");
            let [x, y] = places[places.len() / 2];
            assert!(
                (x - middle[0]).hypot(y - middle[1]) < 1e-9,
                "{data} {x} {y}"
            );
            assert_eq!(curve.notices.len(), 1);
        }
    }

    #[test]
    fn unknown_commands_are_returned() {
        for (data, rest) in [
            ("L1 1", "L1 1"),
            ("1 1", "1 1"),
            ("M1 1 L2", "L2"),
            ("M1 1 X2", "X2"),
            ("M1 1 Z 3 3", "3 3"),
            ("M1 1 L2 2 3", "3"),
            ("M1 1 A1 1 0 2 0 3 3", "A1 1 0 2 0 3 3"),
            ("M1 é", "M1 é"),
        ] {
            assert_eq!(drawn(data).unwrap_err(), rest);
        }
        assert!(drawn("").unwrap().is_empty());
        assert!(drawn("M1 1").unwrap().is_empty());
        let mut pen = Pen::new(Transform::IDENTITY, 1);
        draw(&"M0 0c1 1 1 1 1 1".repeat(1000), &mut pen, 100).unwrap();
        assert!(pen.count() < 200);
    }
}
