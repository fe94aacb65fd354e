//! The constants g of control points `c = E x + g`.
//!
//! Of a curve they are a vector for each copy. Of a surface they come from its boundaries: where the
//! derivatives across a boundary are given or estimated at its data points, the copies of the
//! control points there differ from them by a B-spline of the other direction that interpolates the
//! derivatives. With the constants φ_j along u of all columns of data, ψ_l along v of all rows, and
//! the constants τ_jl of φ_j along v (the twists),
//!
//! ```text
//! G = Σ_j  e_j (E_v B_v⁻¹ (φ_j − N_v τ_j) + τ_j)ᵀ  +  Σ_l  E_u B_u⁻¹ (ψ_l − N_u τ_l) e_lᵀ
//! ```
//!
//! so that the limit is the tensor product of the fits of curves. It takes O(n p²) for directions of
//! n points, and two B-splines for each copy.

use std::cell::OnceCell;

use super::line::{Along, Constants, Fitted, Line, values_of};
use crate::basis::direction::Direction;
use crate::basis::end_conditions::Ends;
use crate::basis::evaluated::Evaluated;
use crate::data::grid::Grid;
use crate::data::points::Points;
use crate::invalid::{Axis, Invalid, Place};

/// The constants of all copies.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Offsets {
    /// For functions of u: the constants of their row of the control net.
    rows: Vec<Strip>,
    /// For functions of v: the constants of their column.
    columns: Vec<Strip>,
}

/// The constants of a row or a column of the control net.
#[derive(Clone, Debug, PartialEq)]
struct Strip {
    /// The basis function.
    function: usize,
    /// One for each function of the other direction; a single one of a curve.
    values: Points,
}

impl Offsets {
    /// The constants of a fit; none if all copies are equal to their control points.
    ///
    /// # Errors
    ///
    /// Numbers leave their range.
    pub(crate) fn new(
        fitted: Fitted<'_>,
        u: (&Direction, Option<&Ends>),
        v: Option<(&Direction, Option<&Ends>)>,
    ) -> Result<Option<Self>, Invalid> {
        let along = Along::new(u.0, u.1);
        let across = v.map(|(direction, ends)| Along::new(direction, ends));
        let offsets = match &across {
            None => Self::of_curve(fitted, &along),
            Some(across) => Self::of_surface(fitted, &along, across),
        };
        for (axis, strips) in [(Axis::U, &offsets.rows), (Axis::V, &offsets.columns)] {
            let finite = |strip: &Strip| strip.values.extents().iter().all(|it| it.is_finite);
            if !strips.iter().all(finite) {
                return Err(Invalid::at(
                    Place::Ends(axis),
                    "the derivatives at the ends exceed the range of 64-bit numbers: scale the data down, or use repeated ends",
                ));
            }
        }
        let some = !offsets.rows.is_empty() || !offsets.columns.is_empty();
        Ok(some.then_some(offsets))
    }

    fn of_curve(fitted: Fitted<'_>, along: &Along<'_>) -> Self {
        let line = Line::of(fitted, 0, 1);
        let constants = along.constants(line, Some(0)).into_iter();
        let strip = |(function, vector): (usize, Vec<f64>)| Strip {
            function,
            values: Points::from_lanes(vector.into_iter().map(|x| vec![x])),
        };
        Self {
            rows: constants.map(strip).collect(),
            columns: Vec::new(),
        }
    }

    fn of_surface(fitted: Fitted<'_>, along: &Along<'_>, across: &Along<'_>) -> Self {
        let Grid { rows, columns } = fitted.grid;
        let of_columns =
            (0..columns).map(|j| along.constants(Line::of(fitted, j, columns), Some(j)));
        let fields_u = fields(of_columns);
        let row = |i| Line::of(fitted, i * columns, 1);
        let of_rows = (0..rows).map(|i| across.constants(row(i), Some(i)));
        let fields_v = fields(of_rows);
        let mut offsets = Self::default();
        let mut twists = Vec::new();
        for (function, field) in fields_u {
            let twist = across.constants(Line::whole(&field), None);
            offsets.rows.push(Strip {
                function,
                values: across.interpolate(field, &twist, true),
            });
            twists.push((function, twist));
        }
        for (function, field) in fields_v {
            let own = |(row, twist): &(usize, Constants)| {
                let here = twist.iter().find(|(column, _)| *column == function);
                here.map(|(_, vector)| (*row, vector.clone()))
            };
            let twist: Constants = twists.iter().filter_map(own).collect();
            offsets.columns.push(Strip {
                function,
                values: along.interpolate(field, &twist, false),
            });
        }
        offsets
    }

    /// The constant of one coordinate of the control point at a place of the net.
    pub(crate) fn at(&self, row: usize, column: usize, coordinate: usize) -> f64 {
        let of = |strips: &[Strip], function, place: usize| -> f64 {
            let own = strips.iter().filter(|strip| strip.function == function);
            own.map(|strip| strip.values.lane(coordinate)[place]).sum()
        };
        of(&self.rows, row, column) + of(&self.columns, column, row)
    }

    /// Adds `factor N g` to the points of a grid of parameters, row by row: `lanes` has those of each
    /// coordinate.
    pub(crate) fn add(
        &self,
        factor: f64,
        (u, at_u): (&Direction, &[f64]),
        v: Option<(&Direction, &[f64])>,
        lanes: &mut [impl AsMut<[f64]>],
    ) {
        let columns = v.map_or(1, |(_, at_v)| at_v.len());
        let along_u = OnceCell::new();
        let along_v = OnceCell::new();
        for strip in &self.rows {
            let rows = values_of(u, strip.function, at_u);
            for (c, lane) in lanes.iter_mut().enumerate().filter(|_| !rows.is_empty()) {
                let controls = strip.values.lane(c);
                let values = match v {
                    None => controls.to_vec(),
                    Some((v, at_v)) => {
                        spline(along_v.get_or_init(|| Evaluated::new(v, at_v)), controls)
                    }
                };
                for (i, value) in &rows {
                    let row = lane.as_mut()[i * columns..][..columns].iter_mut();
                    row.zip(&values).for_each(|(x, g)| *x += factor * value * g);
                }
            }
        }
        let Some((v, at_v)) = v else { return };
        for strip in &self.columns {
            let places = values_of(v, strip.function, at_v);
            for (c, lane) in lanes.iter_mut().enumerate().filter(|_| !places.is_empty()) {
                let along = along_u.get_or_init(|| Evaluated::new(u, at_u));
                let values = spline(along, strip.values.lane(c));
                for (j, value) in &places {
                    let column = lane.as_mut()[*j..].iter_mut().step_by(columns);
                    let column = column.zip(&values);
                    column.for_each(|(x, g)| *x += factor * value * g);
                }
            }
        }
    }

    /// How many numbers are kept.
    pub(crate) fn numbers(&self) -> usize {
        let strips = self.rows.iter().chain(&self.columns);
        strips
            .map(|strip| strip.values.len() * strip.values.dimension())
            .sum()
    }
}

/// The B-spline with these control points, one for each function, at the parameters of the functions.
fn spline(functions: &Evaluated, controls: &[f64]) -> Vec<f64> {
    let value = |i: usize| {
        let (first, values) = functions.at(i);
        let products = values.iter().zip(&controls[first..]);
        products.map(|(a, x)| a * x).sum()
    };
    (0..functions.firsts.len()).map(value).collect()
}

/// The constants of many lines, function by function: one point for each line.
fn fields(lines: impl Iterator<Item = Constants>) -> Vec<(usize, Points)> {
    let mut fields: Vec<(usize, Points)> = Vec::new();
    for (k, (function, vector)) in lines.flat_map(|line| line.into_iter().enumerate()) {
        if fields.len() <= k {
            fields.push((function, Points::new(vector.len())));
        }
        fields[k].1.push(&vector);
    }
    fields
}
