//! Wavefront OBJ with free-form geometry (Object Files, appendix B1 of the Advanced Visualizer
//! manual): the exact B-spline, not a mesh.

use super::document::{Document, Shape};
use super::fitted::GENERATOR;
use super::nurbs::{KnotVector, Nurbs};
use super::text::{Text, one_line};
use piad_fit::geometry::Outline;

/// Numbers in a line, before it is continued on the next.
const PER_LINE: usize = 12;

/// The curves and surfaces as an OBJ file.
pub(super) fn write(document: &Document<'_>) -> Vec<u8> {
    let mut text = Text::default();
    // A backslash at the end of a line would continue the comment.
    let title = one_line(&document.title);
    let description = &document.description;
    text.put(format_args!(
        "# {title} ({description}), written by {GENERATOR}\n"
    ));
    let (mut first, mut loops) = (1, 1);
    for shape in &document.shapes {
        if document.has_parts {
            // A backslash at the end would continue the line.
            let name = one_line(shape.title()).replace('\\', "_");
            text.put(format_args!("o {name}\n"));
        }
        if let Some(outline) = shape.outline {
            curves_in_plane(&mut text, outline);
        }
        element(&mut text, shape, (first, loops));
        first += shape.nurbs.points.len();
        loops += shape.outline.map_or(0, |it| it.loops.len());
    }
    text.into_bytes()
}

/// The loops of a trimmed surface as curves in its parameters ("curv2"), which are numbered, too; their points come before
/// each.
fn curves_in_plane(text: &mut Text, outline: &Outline) {
    for curve in &outline.loops {
        for index in 0..curve.points.len() {
            text.push("vp");
            curve.points.point(index).for_each(|x| number(text, x));
            text.push("\n");
        }
        text.put(format_args!(
            "cstype bspline\ndeg {}\ncurv2",
            curve.u.degree
        ));
        for index in 0..curve.points.len() {
            continue_line(text, index);
            // The last points, by relative indices.
            text.put(format_args!(" -{}", curve.points.len() - index));
        }
        text.push("\n");
        parm(text, 'u', &curve.u);
        text.push("end\n");
    }
}

/// The loops around a surface, and around holes: with the range of their parameter, and their numbers.
fn trims(text: &mut Text, outline: &Outline, first: usize) {
    for face in &outline.faces {
        for index in face.loops() {
            text.push(if index == face.outer { "trim" } else { "hole" });
            domain(text, &outline.loops[index].u);
            text.put(format_args!(" {}\n", first + index));
        }
    }
}

/// A curve or surface, whose first vertex and loop have these numbers.
fn element(text: &mut Text, shape: &Shape<'_>, (first, loops): (usize, usize)) {
    let nurbs = shape.nurbs;
    vertices(text, nurbs);
    let rational = if nurbs.weights.is_some() { "rat " } else { "" };
    text.put(format_args!("cstype {rational}bspline\n"));
    match &nurbs.v {
        None => curve(text, nurbs, first),
        Some(v) => surface(text, nurbs, v, first),
    }
    if let Some(outline) = shape.outline {
        trims(text, outline, loops);
    }
    text.push("end\n");
}

/// `v x y z w`, row by row: places, not multiplied by their weights.
fn vertices(text: &mut Text, nurbs: &Nurbs) {
    for index in 0..nurbs.points.len() {
        text.push("v");
        for x in nurbs.place(index) {
            number(text, x);
        }
        if nurbs.weights.is_some() {
            number(text, nurbs.weight(index));
        }
        text.push("\n");
    }
}

fn curve(text: &mut Text, nurbs: &Nurbs, first: usize) {
    text.put(format_args!("deg {}\ncurv", nurbs.u.degree));
    domain(text, &nurbs.u);
    indices(text, first..first + nurbs.rows());
    parm(text, 'u', &nurbs.u);
}

/// Control points run fastest in the u direction ("Surface vertex data", "Control points").
fn surface(text: &mut Text, nurbs: &Nurbs, v: &KnotVector, first: usize) {
    let (rows, columns) = (nurbs.rows(), nurbs.columns());
    text.put(format_args!("deg {} {}\nsurf", nurbs.u.degree, v.degree));
    domain(text, &nurbs.u);
    domain(text, v);
    let order =
        (0..columns).flat_map(|column| (0..rows).map(move |row| first + row * columns + column));
    indices(text, order);
    parm(text, 'u', &nurbs.u);
    parm(text, 'v', v);
}

fn domain(text: &mut Text, direction: &KnotVector) {
    let (low, high) = direction.domain();
    number(text, low);
    number(text, high);
}

/// The numbers of vertices, which are counted from 1 over the whole file.
fn indices(text: &mut Text, order: impl Iterator<Item = usize>) {
    for (i, index) in order.enumerate() {
        continue_line(text, i);
        text.put(format_args!(" {index}"));
    }
    text.push("\n");
}

/// The knot vector, complete.
fn parm(text: &mut Text, axis: char, direction: &KnotVector) {
    text.put(format_args!("parm {axis}"));
    for (i, &knot) in direction.knots.iter().enumerate() {
        continue_line(text, i);
        number(text, knot);
    }
    text.push("\n");
}

fn continue_line(text: &mut Text, written: usize) {
    if written > 0 && written.is_multiple_of(PER_LINE) {
        text.push(" \\\n");
    }
}

fn number(text: &mut Text, x: f64) {
    text.push(" ");
    text.put(format_args!("{x:?}"));
}
