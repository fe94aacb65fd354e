//! Bases: the functions that are blended with the control points.

pub mod bernstein;
pub mod bspline;
pub mod knots;

/// The highest degree that is accepted: up to here the evaluation is checked to full accuracy.
pub const MAX_DEGREE: usize = 1000;

/// A normalized basis (its functions sum to one) of one direction.
#[derive(Clone, Debug, PartialEq)]
pub enum Basis {
    /// Bernstein polynomials on [0, 1]: `degree + 1` functions.
    Bernstein {
        /// The degree m.
        degree: usize,
    },
    /// B-splines on a clamped knot vector: `knots.len() − degree − 1` functions.
    BSpline {
        /// The degree p ≥ 1.
        degree: usize,
        /// Non-decreasing knots; the first and the last p + 1 are equal.
        knots: Vec<f64>,
    },
}

impl Basis {
    /// The name of the kind of basis.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Bernstein { .. } => "bernstein",
            Self::BSpline { .. } => "bspline",
        }
    }

    /// The polynomial degree.
    pub fn degree(&self) -> usize {
        match self {
            Self::Bernstein { degree } | Self::BSpline { degree, .. } => *degree,
        }
    }

    /// The number of basis functions, one for each control point.
    pub fn functions(&self) -> usize {
        match self {
            Self::Bernstein { degree } => degree + 1,
            Self::BSpline { degree, knots } => knots.len() - degree - 1,
        }
    }

    /// The interval on which the basis is defined.
    pub fn domain(&self) -> (f64, f64) {
        match self {
            Self::Bernstein { .. } => (0.0, 1.0),
            Self::BSpline { degree, knots } => (knots[*degree], knots[knots.len() - degree - 1]),
        }
    }

    /// How many consecutive functions can differ from zero at one parameter: `degree + 1`.
    pub fn support_width(&self) -> usize {
        self.degree() + 1
    }

    /// Writes the values at `t` of the functions that can differ from zero there into `values`
    /// (`support_width` numbers) and returns the index of the first of them.
    ///
    /// `t` lies in the [domain](Self::domain); at its right end the basis is continuous from the left.
    pub fn evaluate(&self, t: f64, values: &mut [f64]) -> usize {
        match self {
            Self::Bernstein { degree } => {
                bernstein::evaluate(*degree, t, values);
                0
            }
            Self::BSpline { degree, knots } => {
                let span = bspline::find_span(*degree, knots, t);
                bspline::evaluate(*degree, knots, span, t, values);
                span - degree
            }
        }
    }

    /// The knot vector of the same space as a CAD kernel stores it: Bernstein polynomials are the
    /// B-splines without interior knots.
    pub fn clamped_knots(&self) -> Vec<f64> {
        match self {
            Self::Bernstein { degree } => {
                let mut knots = vec![0.0; degree + 1];
                knots.resize(2 * (degree + 1), 1.0);
                knots
            }
            Self::BSpline { knots, .. } => knots.clone(),
        }
    }
}
