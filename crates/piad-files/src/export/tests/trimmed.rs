//! Trimmed surfaces: edges on the surface, and meshes of the inside.

use piad_fit::data::Grid;
use piad_fit::engine::vectors::{cross, length, minus};
use piad_fit::geometry::{Face, Outline};

use super::*;
use crate::export::mesh::Mesh;
use crate::export::trim::edges;

/// A closed polygon as a cubic B-spline with corners.
fn polygon(corners: &[[f64; 2]]) -> Nurbs {
    let mut knots = vec![0.0; 4];
    let mut points = Points::new(2);
    for (k, from) in corners.iter().enumerate() {
        let to = corners[(k + 1) % corners.len()];
        for part in [0.0, 1.0 / 3.0, 2.0 / 3.0] {
            let at = [0, 1].map(|axis| (1.0 - part) * from[axis] + part * to[axis]);
            points.push(&at);
        }
        knots.extend([k as f64 + 1.0; 3]);
    }
    points.push(&corners[0]);
    knots.push(corners.len() as f64);
    Nurbs {
        u: KnotVector {
            degree: 3,
            knots,
            closed: true,
        },
        v: None,
        points,
        weights: None,
    }
}

/// Of the quarter of a cylinder, a part with a hole that reaches two of its sides, and a triangle.
fn outline() -> Outline {
    let outer = polygon(&[[0.0, 5.0], [0.7, 5.0], [0.6, 6.5], [0.0, 6.2]]);
    let hole = polygon(&[[0.2, 5.5], [0.2, 6.0], [0.4, 5.8]]);
    let island = polygon(&[[0.8, 6.0], [1.0, 6.5], [0.8, 7.0]]);
    Outline {
        loops: vec![outer, hole, island],
        faces: vec![
            Face {
                outer: 0,
                holes: 1..2,
            },
            Face {
                outer: 2,
                holes: 3..3,
            },
        ],
        distance: 0.1,
    }
}

fn trimmed() -> Part<'static> {
    Part {
        outline: Some(outline()),
        ..part("patch", cylinder())
    }
}

fn file(format: Format, parts: &[Part<'_>]) -> Vec<u8> {
    let header = Header::new(Timestamp::UNIX_EPOCH, Options::default());
    write_parts(format, parts, &header).unwrap()
}

fn count(text: &str, word: &str) -> usize {
    text.matches(word).count()
}

#[test]
fn edges_turn_at_corners_and_lie_on_the_surface() {
    let surface = cylinder();
    let loops = edges::of_loops(&surface, &outline());
    let counts: Vec<usize> = loops.iter().map(Vec::len).collect();
    assert_eq!(counts, [4, 3, 3]);
    let tolerance = edges::tolerance(&surface);
    for edge in loops.iter().flatten() {
        let [curve, plane] = [&edge.in_space, &edge.in_plane];
        assert_eq!(curve.u.domain(), plane.u.domain());
        assert_eq!(curve.u.knots.len(), curve.points.len() + 4);
        let (low, high) = plane.u.domain();
        for k in 0..=40 {
            let t = low + f64::from(k) / 40.0 * (high - low);
            let [u, v, _] = plane.evaluate(&[plane.u.site_at(t)], &[])[0].point;
            let across = surface.v.as_ref().unwrap().site_at(v);
            let exact = surface.evaluate(&[surface.u.site_at(u)], &[across])[0].point;
            let place = curve.evaluate(&[curve.u.site_at(t)], &[])[0].point;
            assert!(length(minus(place, exact)) <= 1.01 * tolerance);
        }
    }
    // Each begins where the one before ends.
    for edges in &loops {
        for (edge, next) in edges.iter().zip(edges.iter().cycle().skip(1)) {
            let last = edge.in_plane.points.len() - 1;
            let [end, start] = [edge.in_plane.place(last), next.in_plane.place(0)];
            assert_eq!(end, start);
        }
    }
}

#[test]
fn meshes_omit_the_outside() {
    let grid = |samples| Options {
        samples: Some(Grid {
            rows: samples,
            columns: samples,
        }),
        ..Options::default()
    };
    // Rectangles of parameters, of which a unit of v is 1.5 long; u goes around unevenly.
    let whole = Outline {
        loops: vec![polygon(&[[0.0, 5.0], [1.0, 5.0], [1.0, 6.0], [0.0, 6.0]])],
        faces: vec![Face {
            outer: 0,
            holes: 1..1,
        }],
        distance: 0.1,
    };
    let mesh = Mesh::new(&cylinder(), Some(&whole), &grid(80), Format::Stl).unwrap();
    let wide = |index: u32| mesh.positions[index as usize].map(f64::from);
    let area: f64 = mesh
        .triangles
        .iter()
        .map(|it| {
            let [a, b, c] = it.map(wide);
            0.5 * length(cross(minus(b, a), minus(c, a)))
        })
        .sum();
    assert!((area - 1.5 * std::f64::consts::PI).abs() < 1e-3, "{area}");
    let mesh = Mesh::new(&cylinder(), Some(&outline()), &grid(30), Format::Stl).unwrap();
    assert_eq!(mesh.positions.len(), mesh.normals.len());
    for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
        let [x, y, z] = position.map(f64::from);
        let [nx, ny, _] = normal.map(f64::from);
        assert!((x * nx + y * ny - 2.0).abs() < 1e-5);
        // In the hole there is no vertex: v = 5 + z / 1.5.
        let (around, v) = (y.atan2(x) / std::f64::consts::FRAC_PI_2, 5.0 + z / 1.5);
        let is_deep = (0.22..0.3).contains(&around) && (5.7..5.85).contains(&v);
        assert!(!is_deep, "{around} {v}");
    }
    // Coarse samples are sufficient.
    let coarse = Mesh::new(&cylinder(), Some(&outline()), &grid(2), Format::Stl).unwrap();
    assert!(coarse.triangles.len() > 4);
}

#[test]
fn files_mix_trimmed_and_untrimmed_faces() {
    let [curve, ..] = curves();
    let parts = [curve, trimmed(), part("tube", cylinder())];
    let step = String::from_utf8(file(Format::Step, &parts)).unwrap();
    assert_eq!(count(&step, "=ADVANCED_FACE("), 2);
    assert_eq!(count(&step, "=FACE_OUTER_BOUND("), 2);
    assert_eq!(count(&step, "=FACE_BOUND("), 1);
    assert_eq!(count(&step, "=EDGE_CURVE("), 10);
    assert_eq!(count(&step, "=VERTEX_POINT("), 10);
    assert_eq!(count(&step, "=OPEN_SHELL("), 2);
    assert_eq!(count(&step, "=SHAPE_DEFINITION_REPRESENTATION("), 2);
    // Numbers are those of one instance each.
    let mut numbers: Vec<&str> = step
        .lines()
        .filter(|line| line.starts_with('#'))
        .filter_map(|line| line.split('=').next())
        .collect();
    let all = numbers.len();
    numbers.sort_unstable();
    numbers.dedup();
    assert_eq!(numbers.len(), all);
    let iges = String::from_utf8(file(Format::Iges, &parts)).unwrap();
    assert!(iges.lines().all(|line| line.len() == 80));
    let entries = iges.lines().filter(|line| line[72..].starts_with('D'));
    let kinds: Vec<&str> = entries.step_by(2).map(|line| line[..8].trim()).collect();
    let of = |kind: &str| kinds.iter().filter(|it| **it == kind).count();
    assert_eq!(
        [of("128"), of("126"), of("102"), of("142"), of("144")],
        [2, 21, 6, 3, 2]
    );
    let obj = String::from_utf8(file(Format::Obj, &parts)).unwrap();
    assert_eq!(count(&obj, "\ncurv2 "), 3);
    assert!(
        obj.contains("\ntrim 0.0 4.0 1\nhole 0.0 3.0 2\ntrim 0.0 3.0 3\nend"),
        "{obj}"
    );
    let header = Header::new(Timestamp::UNIX_EPOCH, Options::default());
    let error = write_parts(Format::Dxf, &parts, &header).unwrap_err();
    assert!(error.to_string().contains("trimmed"), "{error}");
}

/// An edge along a side that is a point.
#[test]
fn edges_at_poles_are_left_out_or_refused() {
    let mut nurbs = cylinder();
    for lane in nurbs.points.lanes_mut() {
        let pole = lane[0];
        [0, 2, 4].into_iter().for_each(|k| lane[k] = pole);
    }
    let parts = [Part {
        outline: Some(outline()),
        ..part("ball", nurbs)
    }];
    let header = Header::new(Timestamp::UNIX_EPOCH, Options::default());
    let error = write_parts(Format::Iges, &parts, &header).unwrap_err();
    assert!(error.to_string().contains("pole"), "{error}");
    let step = String::from_utf8(file(Format::Step, &parts)).unwrap();
    assert_eq!(count(&step, "=EDGE_CURVE("), 9);
    assert!(write_parts(Format::Stl, &parts, &header).is_ok());
}
