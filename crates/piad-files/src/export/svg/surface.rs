//! Drawing a surface: its faces, its control net and the data, the far ones first.

use super::heat;
use super::layout::{DrawnData, shows_net};
use super::measured::Measured;
use super::scale::{Heat, hexadecimal};
use super::scene::{Scene, SurfacePart};
use super::view::{Canvas, Projected, Projection};
use crate::export::nurbs::{KnotVector, Nurbs};
use crate::export::text::Text;
use crate::export::trim::triangles::{self, Triangles};
use piad_fit::data::Grid;
use piad_fit::engine::Problem;
use piad_fit::engine::nurbs::{SpanParameter, steps_between};
use piad_fit::engine::vectors::{cross, minus, unit};
use piad_fit::geometry::Outline;

/// The most faces in each direction, unless a number of samples is requested.
const MOST_FACES: usize = 64;

/// Faces whose diagonal is shorter than this many pixels have no outlines, which would cover them.
const LEAST_LINED: f64 = 5.0;

/// The colour of a face in full light where the data are on the surface.
const COLOUR: [f64; 3] = [140.0, 186.0, 230.0];

/// Draws the parts, each over those before it.
pub(super) fn draw(text: &mut Text, parts: &[SurfacePart], data: &DrawnData, canvas: &Canvas) {
    let radius = data.radius();
    let lined = mean_size(parts, canvas) >= LEAST_LINED;
    for part in parts {
        part.draw(text, canvas, lined, radius);
    }
}

/// The average number of pixels between opposite corners of a face.
fn mean_size(parts: &[SurfacePart], canvas: &Canvas) -> f64 {
    let diagonals = parts.iter().filter_map(|part| match part {
        SurfacePart::Face([a, _, c, _], ..) => {
            let (a, c) = (canvas.pixel(*a), canvas.pixel(*c));
            Some((a.0 - c.0).hypot(a.1 - c.1))
        }
        _ => None,
    });
    let (count, sum) = diagonals.fold((0, 0.0), |(count, sum), x| (count + 1, sum + x));
    sum / f64::from(count)
}

/// The faces, and the edges of the control net.
pub(super) fn scene(
    problem: &Problem,
    (nurbs, v): (&Nurbs, &KnotVector),
    samples: Option<Grid>,
    view: &Projection,
    measured: Option<&Measured>,
) -> Scene {
    let along = |knots: &KnotVector, requested: Option<usize>| {
        let suits = || knots.steps(MOST_FACES).max(MOST_FACES / 2);
        knots.sites(requested.map_or_else(suits, steps_between))
    };
    let rows = along(&nurbs.u, samples.map(|grid| grid.rows));
    let columns = along(v, samples.map(|grid| grid.columns));
    let heat = measured.map(|it| heat::of_faces(problem, it, (&rows, &columns)));
    let heat = heat.unwrap_or_default();
    let outline = problem.outline().filter(|it| !it.is_whole());
    let mut parts = match outline {
        None => faces(nurbs, (&rows, &columns), view, &heat),
        Some(outline) => trimmed(nurbs, outline, [&rows, &columns], (view, &heat)),
    };
    if shows_net(nurbs) {
        parts.extend(edges(nurbs, view));
    }
    Scene::Surface(parts)
}

/// The faces between these sites, row by row.
fn faces(
    nurbs: &Nurbs,
    (rows, columns): (&[SpanParameter], &[SpanParameter]),
    view: &Projection,
    heat: &[Heat],
) -> Vec<SurfacePart> {
    let jets = nurbs.evaluate(rows, columns);
    let mut faces = Vec::with_capacity(jets.len());
    for i in 1..rows.len() {
        for j in 1..columns.len() {
            let corner = |i: usize, j: usize| jets[i * columns.len() + j].point;
            let corners = [
                corner(i - 1, j - 1),
                corner(i, j - 1),
                corner(i, j),
                corner(i - 1, j),
            ];
            let normal = cross(minus(corners[2], corners[0]), minus(corners[3], corners[1]));
            let light = unit(normal).map_or(1.0, |normal| view.light(normal));
            let heat = heat.get(faces.len()).copied();
            faces.push(SurfacePart::Face(
                corners.map(|it| view.project(it)),
                light,
                heat,
            ));
        }
    }
    faces
}

/// The triangles of a trimmed surface, each with the heat of the face in whose place it is, and its outline.
fn trimmed(
    nurbs: &Nurbs,
    outline: &Outline,
    sites: [&[SpanParameter]; 2],
    (view, heat): (&Projection, &[Heat]),
) -> Vec<SurfacePart> {
    let Triangles { places, triangles } =
        triangles::triangles(nurbs, outline, sites).unwrap_or_default();
    let jets = |places: &[[f64; 2]]| {
        let site =
            |[u, v]: [f64; 2]| (nurbs.u.site_at(u), nurbs.v.as_ref().map(|it| it.site_at(v)));
        let sites: Vec<_> = places.iter().map(|it| site(*it)).collect();
        triangles::evaluate(nurbs, &sites)
    };
    let points = jets(&places);
    let mut parts = Vec::with_capacity(triangles.len());
    for triangle in triangles {
        let [a, b, c] = triangle.map(|index| points[index as usize].point);
        let light = unit(cross(minus(b, a), minus(c, a)));
        let light = light.map_or(1.0, |normal| view.light(normal));
        let middle = [0, 1].map(|axis| {
            let sum: f64 = triangle.iter().map(|&it| places[it as usize][axis]).sum();
            let after = sites[axis].partition_point(|site| site.t <= sum / 3.0);
            after.saturating_sub(1).min(sites[axis].len() - 2)
        });
        let heat = heat
            .get(middle[0] * (sites[1].len() - 1) + middle[1])
            .copied();
        let corners = [a, b, c, c].map(|it| view.project(it));
        parts.push(SurfacePart::Face(corners, light, heat));
    }
    for polygon in outline.polygons(nurbs, 1.0 / RIM_STEPS) {
        let along = jets(&polygon);
        let ends = along.windows(2).map(|pair| [pair[0].point, pair[1].point]);
        parts.extend(ends.map(|ends| SurfacePart::Rim(ends.map(|it| view.project(it)))));
    }
    parts
}

/// The steps along an outline that is as long as the surface.
const RIM_STEPS: f64 = 128.0;

/// The edges of the control net in both directions.
fn edges(nurbs: &Nurbs, view: &Projection) -> Vec<SurfacePart> {
    let (rows, columns) = (nurbs.rows(), nurbs.columns());
    let place = |i: usize, j: usize| view.project(nurbs.place(i * columns + j));
    let mut edges = Vec::with_capacity(2 * rows * columns);
    for i in 0..rows {
        for j in 0..columns {
            if i > 0 {
                edges.push(SurfacePart::Edge([place(i - 1, j), place(i, j)]));
            }
            if j > 0 {
                edges.push(SurfacePart::Edge([place(i, j - 1), place(i, j)]));
            }
        }
    }
    edges
}

impl SurfacePart {
    /// The depth of a part for the order of drawing.
    pub(super) fn depth(&self, lift: f64) -> f64 {
        match self {
            Self::Face(corners, ..) => mean(corners),
            Self::Edge(ends) | Self::Rim(ends) => mean(ends) + lift,
            Self::Dot(place) => place.depth + 2.0 * lift,
        }
    }

    fn draw(&self, text: &mut Text, canvas: &Canvas, lined: bool, radius: f64) {
        match self {
            Self::Face(corners, light, heat) => {
                let [a, b, c, d] = corners.map(|corner| canvas.pixel(corner));
                let colour = heat.map_or(COLOUR, Heat::colour);
                // Where colours show distances, there are no shades.
                let dark = if heat.is_some() { 0.6 } else { 0.42 };
                let shade = |most: f64| {
                    let light = most * (dark + (1.0 - dark) * light);
                    hexadecimal(colour.map(|x| x * light))
                };
                let fill = shade(1.0);
                // A line of its own colour covers the gaps that renderers leave between faces.
                let stroke = if lined { shade(0.8) } else { fill.clone() };
                text.put(format_args!(
                    "<path d=\"M{:.1} {:.1}L{:.1} {:.1} {:.1} {:.1} {:.1} {:.1}Z\" \
                     fill=\"{fill}\" stroke=\"{stroke}\" stroke-width=\".5\"/>\n",
                    a.0, a.1, b.0, b.1, c.0, c.1, d.0, d.1
                ));
            }
            Self::Rim(ends) => {
                let [a, b] = ends.map(|end| canvas.pixel(end));
                text.put(format_args!(
                    "<path class=\"curve\" d=\"M{:.1} {:.1}L{:.1} {:.1}\"/>\n",
                    a.0, a.1, b.0, b.1
                ));
            }
            Self::Edge(ends) => {
                let [a, b] = ends.map(|end| canvas.pixel(end));
                text.put(format_args!(
                    "<path class=\"net\" d=\"M{:.1} {:.1}L{:.1} {:.1}\"/>\n",
                    a.0, a.1, b.0, b.1
                ));
            }
            Self::Dot(place) => {
                let (x, y) = canvas.pixel(*place);
                text.put(format_args!(
                    "<circle class=\"data\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\"/>\n"
                ));
            }
        }
    }
}

fn mean(places: &[Projected]) -> f64 {
    places.iter().map(|place| place.depth).sum::<f64>() / places.len() as f64
}
