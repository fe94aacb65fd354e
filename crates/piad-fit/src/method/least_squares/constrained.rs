//! Minima that obey and weigh more than distances, over knots that a schedule chooses: constraints,
//! fairness, weights of data, free ends.
//!
//! They are those of the direct variant, as far as [`AT_ONCE`] multiplications go. Where a surface
//! takes more, conjugate gradients lead from the surface before to near the minimum; they obey the
//! same conditions.

use std::sync::Arc;

use super::constraints::independent;
use super::settings::{LeastSquares, Variant};
use super::steps::Steps;
use super::{solver, start};
use crate::data::points::Points;
use crate::knot_selection::breaks::Breaks;
use crate::knot_selection::equations::Minimum;
use crate::knot_selection::knot_conversion::{in_directions, in_lines};
use crate::knot_selection::values::Values;
use crate::matrix::forecast::Forecast;
use crate::matrix::transform::Transform;
use crate::method::equations::Equations;
use crate::method::plain::Plain;
use crate::setup::Setup;

/// The most multiplications of the factorization of a surface over some of the many knots that are
/// tried.
const AT_ONCE: usize = 100_000_000;

/// The most steps of conjugate gradients.
const STEPS: usize = 200;

/// What is minimized, over any knots.
#[derive(Clone, Debug)]
pub(crate) struct Constrained {
    setup: Arc<Setup>,
    settings: LeastSquares,
}

impl Constrained {
    /// Of a curve or a surface.
    pub(crate) fn new(setup: &Arc<Setup>, settings: &LeastSquares) -> Self {
        Self {
            setup: Arc::clone(setup),
            settings: LeastSquares {
                variant: Variant::Direct,
                automatic: None,
                ..settings.clone()
            },
        }
    }

    /// The same weights of data, multiplied with others.
    fn weighted(&self, weights: Option<&[f64]>) -> LeastSquares {
        let Some(weights) = weights else {
            return self.settings.clone();
        };
        let own = self.settings.data_weights.as_deref();
        let own = |i: usize| own.map_or(1.0, |own| own[i]);
        let product = weights.iter().enumerate().map(|(i, w)| w * own(i));
        LeastSquares {
            data_weights: Some(product.collect()),
            ..self.settings.clone()
        }
    }

    /// The minimum over the knots of each direction, in control points of these lines. A surface
    /// that takes many steps goes on from control points near it.
    pub(crate) fn minimum(
        &self,
        lines: &[Breaks],
        near: Option<&Points>,
        weights: Option<&[f64]>,
    ) -> Option<Points> {
        let setup = over(&self.setup, lines)?;
        let mut settings = self.weighted(weights);
        independent(&setup, &settings).ok()?;
        // Scattered data alone can leave much of a surface open.
        let open = setup.is_scattered() && settings.fairness().is_none();
        if setup.v().is_some() && (open || solver::cost(&setup, &settings) > AT_ONCE) {
            settings.variant = Variant::ConjugateGradients;
        }
        let setup = Arc::new(setup);
        let equations = Equations {
            collocation: setup.collocation(),
            setup: Arc::clone(&setup),
            transform: Transform::Scale(1.0),
            forecast: Forecast::default(),
        };
        let first = match near {
            Some(near) => in_directions(near, lines),
            None if setup.is_scattered() => start::means(&equations),
            None => start::start(&setup),
        };
        let steps = match settings.variant {
            Variant::Direct => 1,
            _ => STEPS,
        };
        let update = Box::new(Steps::new(&equations, &settings));
        let (mut plain, mut error) = Plain::start(&equations, update, Arc::new(first), None);
        for _ in 0..steps {
            (_, error) = plain.step(&equations);
            if plain.update().outcome().is_some() || !error.is_finite() {
                break;
            }
        }
        let control_points = in_lines(plain.control_points(), lines);
        error.is_finite().then_some(control_points)
    }
}

/// The same over other knots of each direction.
pub(super) fn over(setup: &Setup, lines: &[Breaks]) -> Option<Setup> {
    let directions = lines.iter().zip(setup.directions());
    let mut directions = directions.map(|(line, old)| line.direction(Arc::clone(&old.parameters)));
    Some(Setup {
        u: directions.next()?,
        v: directions.next(),
        start: None,
        ..setup.clone()
    })
}

impl Minimum for Constrained {
    fn minimum(&self, values: &Values, weights: Option<&[f64]>) -> Option<Points> {
        self.minimum(std::slice::from_ref(values.line()), None, weights)
    }
}
