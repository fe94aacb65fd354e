//! Common parts of all instances: numbers of fixed instances, knots and real numbers.

use crate::export::nurbs::KnotVector;
use crate::export::text::Text;

/// The number of the context of the representation.
pub(super) const CONTEXT: usize = 14;
/// The number of the product's shape.
pub(super) const SHAPE: usize = 9;
/// The number of the coordinate system.
pub(super) const ORIGIN: usize = 15;

/// Multiplicities of all directions, then their knots, then the kind of knots.
pub(super) fn knots(text: &mut Text, directions: &[&KnotVector]) {
    let distinct: Vec<_> = directions.iter().map(|it| it.multiplicities()).collect();
    for knots in &distinct {
        text.list(knots, |text, (_, times)| text.put(format_args!("{times}")));
        text.push(",");
    }
    for knots in &distinct {
        text.list(knots, |text, (knot, _)| real(text, *knot));
        text.push(",");
    }
    text.push(".UNSPECIFIED.");
}

pub(super) fn real(text: &mut Text, x: f64) {
    text.real(x, 'E');
}
