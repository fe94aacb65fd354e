//! Paths in SVG.

use super::*;

#[test]
fn paths_are_the_curves() {
    let text = text("paths", Format::Svg, &curves()[..2], Options::default());
    let paths: Vec<&str> = text
        .split("<path")
        .skip(1)
        .map(|it| it.split(" d=\"").nth(1).unwrap().split('"').next().unwrap())
        .collect();
    assert_eq!(paths.len(), 2);
    assert!(text.contains("exactly, in the units of the data"));
    assert!(text.contains("<title>Höhe 5/7</title></path>"));
    assert!(text.contains("fill=\"none\""));
    // Each span ends at its knot, with y negated.
    let numbers = |path: &str| -> Vec<f64> {
        let words = path.split(|c: char| c.is_whitespace() || "MCZ".contains(c));
        let words = words.filter(|word| !word.is_empty());
        words.map(|word| word.parse().unwrap()).collect()
    };
    let wave_numbers = numbers(paths[0]);
    assert_eq!(wave_numbers.len(), 2 + 2 * 6);
    for (index, t) in [(0, 0.0), (6, 0.4), (12, 1.0)] {
        let expected = point(&wave(), t);
        let found = [wave_numbers[index], -wave_numbers[index + 1], 0.0];
        assert!(is_near(found, expected, 1e-14), "{found:?} {expected:?}");
    }
    assert!(paths[1].ends_with('Z') && !paths[0].ends_with('Z'));
    assert_eq!(numbers(paths[1]).len(), 2 + 5 * 6);
}

/// The box is that of the curve, with the width of a line around.
#[test]
fn the_view_box_is_that_of_the_curve() {
    let text = text("box", Format::Svg, &[part("", arc())], Options::default());
    let view = text
        .split("viewBox=\"")
        .nth(1)
        .unwrap()
        .split('"')
        .next()
        .unwrap();
    let view: Vec<f64> = view.split(' ').map(|x| x.parse().unwrap()).collect();
    let line = 3e-3 * 5.0;
    let expected = [-line, -5.0 - line, 5.0 + 2.0 * line, 5.0 + 2.0 * line];
    for (found, expected) in view.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-3, "{view:?}");
    }
    assert!(text.contains("within 1e-4 of the size of each curve"));
    assert!(text.contains("seen from above") && !text.contains("<title>"));
}

#[test]
fn straight_lines_are_lines() {
    let knots = [0.0, 0.0, 1.0, 2.0, 2.0];
    let line = of_points(line_of(1, &knots), &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]);
    let text = text("line", Format::Svg, &[part("", line)], Options::default());
    assert!(text.contains("d=\"M0 0\nL1 0\nL2 0\""), "{text}");
    let view = text.split("viewBox=\"").nth(1).unwrap();
    assert!(view.starts_with("-0.006 -0.006 2.012 0.012\""), "{view}");
}
