//! Drawing a curve.

use super::heat;
use super::layout::{DrawnData, are_sparse, draw_polygon, shows_net};
use super::measured::Measured;
use super::scale::{Heat, hexadecimal};
use super::scene::{Cubic, Scene};
use super::view::{Canvas, Projected, Projection};
use crate::export::nurbs::{KnotVector, Nurbs};
use crate::export::text::Text;
use piad_fit::data::Grid;
use piad_fit::engine::Problem;
use piad_fit::engine::nurbs::steps_between;

/// The most pieces of which a curve is drawn.
const MOST_PIECES: usize = 4096;

/// The radius of control points.
const CONTROL_RADIUS: f64 = 2.5;

/// The curve as chords between the requested samples, or as cubic pieces with its end points and tangents: enough of
/// them that they look like the curve at any reasonable magnification.
pub(super) fn scene(
    problem: &Problem,
    nurbs: &Nurbs,
    view: &Projection,
    samples: Option<Grid>,
    measured: Option<&Measured>,
) -> Scene {
    let spans = nurbs.u.spans();
    let steps = nurbs.u.steps(MOST_PIECES);
    let pieces = match (samples, steps / spans.len()) {
        (Some(grid), _) => chords(nurbs, view, steps_between(grid.rows)),
        (None, 0) => chords(nurbs, view, steps),
        (None, parts) => tangent_pieces(nurbs, view, &nurbs.u, &spans, parts),
    };
    let heat = measured.map(|it| {
        let sites = nurbs.u.sites(pieces.len());
        heat::of_pieces(problem, it, &sites)
    });
    Scene::Curve(pieces, heat.unwrap_or_default())
}

/// Straight pieces: between samples, or where there are more spans than can be drawn.
fn chords(nurbs: &Nurbs, view: &Projection, steps: usize) -> Vec<Cubic> {
    let jets = nurbs.evaluate(&nurbs.u.sites(steps), &[]);
    let places: Vec<Projected> = jets.iter().map(|jet| view.project(jet.point)).collect();
    let pieces = places
        .windows(2)
        .map(|ends| [ends[0], ends[0], ends[1], ends[1]]);
    pieces.collect()
}

/// `parts` pieces in each span: inside a span the curve is smooth.
fn tangent_pieces(
    nurbs: &Nurbs,
    view: &Projection,
    knots: &KnotVector,
    spans: &[usize],
    parts: usize,
) -> Vec<Cubic> {
    // Neighbouring pieces of a span share a site; spans do not, as tangents can differ on both sides of a knot.
    let sites = spans.iter().flat_map(|&span| {
        (0..=parts).map(move |part| knots.site(span, part as f64 / parts as f64))
    });
    let sites: Vec<_> = sites.collect();
    let jets = nurbs.evaluate(&sites, &[]);
    let spans = sites
        .chunks_exact(parts + 1)
        .zip(jets.chunks_exact(parts + 1));
    let pieces = spans.flat_map(|(sites, jets)| sites.windows(2).zip(jets.windows(2)));
    let pieces = pieces.map(|(sites, jets)| {
        let third = knots.width(sites[0]) / parts as f64 / 3.0;
        let along = |end: usize, h: f64| {
            let (point, tangent) = (jets[end].point, jets[end].du);
            view.project([0, 1, 2].map(|c| point[c] + h * tangent[c]))
        };
        [
            along(0, 0.0),
            along(0, third),
            along(1, -third),
            along(1, 0.0),
        ]
    });
    pieces.collect()
}

/// The control polygon, on it the curve in the colours of its distance from the data, on it control points
/// and data points.
pub(super) fn draw(
    text: &mut Text,
    (pieces, heat): (&[Cubic], &[Heat]),
    nurbs: &Nurbs,
    data: &DrawnData,
    view: &Projection,
    canvas: &Canvas,
) {
    let pixel = |place| canvas.pixel(view.project(place));
    let mut polygon: Vec<(f64, f64)> = Vec::new();
    if shows_net(nurbs) {
        polygon.extend((0..nurbs.points.len()).map(|index| pixel(nurbs.place(index))));
    }
    draw_heat(text, pieces, heat, canvas);
    draw_polygon(text, "net", polygon.iter().copied());
    draw_pieces(text, pieces, canvas);
    if are_sparse(&polygon, CONTROL_RADIUS, true) {
        draw_circles(text, "control", &polygon, CONTROL_RADIUS);
    }
    if data.dots {
        let dots: Vec<(f64, f64)> = data.places.iter().map(|&it| canvas.pixel(it)).collect();
        draw_circles(text, "data", &dots, data.radius());
    }
}

/// A broad band along the curve; pieces of the same colour are one path.
fn draw_heat(text: &mut Text, pieces: &[Cubic], heat: &[Heat], canvas: &Canvas) {
    let mut rest = pieces;
    for run in heat.chunk_by(|a, b| a == b) {
        let (some, others) = rest.split_at(run.len().min(rest.len()));
        rest = others;
        let colour = hexadecimal(run[0].colour());
        text.put(format_args!(
            "<path class=\"heat\" stroke=\"{colour}\" d=\""
        ));
        put_pieces(text, some, canvas);
    }
}

fn draw_pieces(text: &mut Text, pieces: &[Cubic], canvas: &Canvas) {
    text.push("<path class=\"curve\" d=\"");
    put_pieces(text, pieces, canvas);
}

fn put_pieces(text: &mut Text, pieces: &[Cubic], canvas: &Canvas) {
    for (i, piece) in pieces.iter().enumerate() {
        let [start, one, two, end] = piece.map(|place| canvas.pixel(place));
        if i == 0 {
            text.put(format_args!("M{:.2} {:.2}", start.0, start.1));
        }
        text.put(format_args!(
            "C{:.2} {:.2} {:.2} {:.2} {:.2} {:.2}\n",
            one.0, one.1, two.0, two.1, end.0, end.1
        ));
    }
    text.push("\"/>\n");
}

fn draw_circles(text: &mut Text, class: &str, places: &[(f64, f64)], radius: f64) {
    text.put(format_args!("<g class=\"{class}\">\n"));
    for (x, y) in places {
        text.put(format_args!(
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\"/>\n"
        ));
    }
    text.push("</g>\n");
}
