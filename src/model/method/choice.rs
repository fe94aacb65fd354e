//! What a method that is asked for is for a fit, and back.

use std::sync::Arc;

use super::{
    AdaptiveInput, ConvexInput, CustomInput, ExtendedInput, LeastSquaresInput, LocalInput,
    MethodInput, WeightedInput,
};
use crate::fit::invalid::{Place as P, Setting};
use crate::fit::method::{
    self as fit, Adaptive, Convex, Custom, Extended, Local, Method, Weighted,
};
use crate::fit::points::Grid;
use crate::fit::problem::Request;
use crate::model::either::AtMost;
use crate::model::mistakes::{Mistake, OrMistakes, SpecPart};
use crate::model::per_direction::PerDirection;
use crate::model::settings::{Index, Omega, Thresholds};

/// A method, and the points that it selects.
#[derive(Clone, Debug)]
pub(crate) struct MethodChoice {
    /// The method with its settings.
    pub method: Method,
    /// Local fits: the indices of the points that are adjusted, if not all.
    pub selected: Option<Arc<[usize]>>,
}

impl From<Method> for MethodChoice {
    fn from(method: Method) -> Self {
        let selected = None;
        Self { method, selected }
    }
}

impl MethodInput {
    /// The method for data points arranged in `grid`, and the points that it selects.
    pub(crate) fn choice(self, grid: Grid, surface: bool) -> OrMistakes<MethodChoice> {
        let method = match self {
            Self::Global => Method::Global,
            Self::Weighted(WeightedInput { omega }) => Method::Weighted(Weighted {
                omega: omega.and_then(|Omega(omega)| omega),
            }),
            Self::Local(local) => return local.choice(grid, surface),
            Self::Adaptive(adaptive) => Method::Adaptive(adaptive.settings(grid, surface)?),
            Self::Extended(extended) => Method::Extended(Extended {
                start: extended.start.unwrap_or_default(),
                transformed_error: extended.transformed_error.unwrap_or(false),
            }),
            Self::Transpose => Method::Transpose,
            Self::Convex(ConvexInput { step_tolerance }) => {
                let convex = step_tolerance.map(|step_tolerance| Convex { step_tolerance });
                Method::Convex(convex.unwrap_or_default())
            }
            Self::Chebyshev => Method::Chebyshev,
            Self::Direct => Method::Direct,
            Self::LeastSquares(it) => Method::LeastSquares(it.settings(grid, surface)?),
            Self::Custom(CustomInput { transform }) => Method::Custom(match transform {
                Some(PerDirection::Both(AtMost(u))) => Custom::new(u, None),
                Some(PerDirection::Each { u, v }) => Custom::new(u.0, Some(v.0)),
                None => {
                    return incomplete(
                        "custom needs a transform: the rows of a matrix, on surfaces also {\"u\": …, \"v\": …}",
                    );
                }
            }),
        };
        Ok(method.into())
    }

    /// The method of a problem as it would be asked for.
    pub(in crate::model) fn of(request: &Request) -> Self {
        let (grid, surface) = (request.grid, request.v.is_some());
        match &request.method {
            Method::Global => Self::Global,
            Method::Weighted(Weighted { omega }) => Self::Weighted(WeightedInput {
                omega: Some(Omega(*omega)),
            }),
            Method::Local(Local { omega, sweeps }) => {
                let columns = (surface && grid.is_rows()).then_some(grid.columns);
                let index = |&index: &usize| Index::new(index, columns);
                let selected = request.selected.as_deref();
                Self::Local(LocalInput {
                    indices: selected.map(|it| it.iter().map(index).collect()),
                    sweeps: *sweeps,
                    omega: omega.other_than_one().map(Omega::from),
                })
            }
            Method::Adaptive(Adaptive { threshold, omega }) => Self::Adaptive(AdaptiveInput {
                threshold: Some(Thresholds::of(threshold, grid, surface)),
                omega: (*omega != 1.0).then_some(Omega(Some(*omega))),
            }),
            Method::Extended(settings) => Self::Extended(ExtendedInput {
                start: Some(settings.start),
                transformed_error: settings.transformed_error.then_some(true),
            }),
            Method::Transpose => Self::Transpose,
            Method::Convex(convex) => Self::Convex(ConvexInput {
                step_tolerance: (*convex != Convex::default()).then_some(convex.step_tolerance),
            }),
            Method::Chebyshev => Self::Chebyshev,
            Method::Direct => Self::Direct,
            Method::LeastSquares(settings) => {
                Self::LeastSquares(LeastSquaresInput::of(settings, grid, surface).into())
            }
            Method::Custom(custom) => {
                let u = AtMost(custom.u().to_vec());
                let v = custom.v().map(|v| AtMost(v.to_vec()));
                Self::Custom(CustomInput {
                    transform: Some(match v {
                        None => PerDirection::Both(u),
                        Some(v) => PerDirection::Each { u, v },
                    }),
                })
            }
        }
    }
}

impl LocalInput {
    fn choice(self, grid: Grid, surface: bool) -> OrMistakes<MethodChoice> {
        let selected = self.indices.map(|mut given| {
            // Among more than there are points one is wrong, or given twice.
            given.truncate(grid.count().saturating_add(1));
            let of_point = |(k, index): (usize, Index)| {
                let wrong = |detail| Mistake::at(SpecPart::Fit(P::Index(k)), detail);
                index.of_point(grid, surface).map_err(wrong)
            };
            given.into_iter().enumerate().map(of_point).collect()
        });
        let selected: Option<Arc<[usize]>> = selected.transpose()?;
        if self.sweeps.is_some() && !surface {
            let place = P::Setting(Setting::Sweeps);
            let detail = "sweeps are for surfaces; a curve has no rows and no columns";
            return Err(Mistake::at(SpecPart::Fit(place), detail).into());
        }
        if selected.is_none() && self.sweeps.is_none() {
            return incomplete("local needs the indices of the points to adjust, or sweeps");
        }
        let method = Method::Local(Local {
            omega: match self.omega {
                None => fit::Omega::default(),
                Some(Omega(None)) => fit::Omega::Best,
                Some(Omega(Some(omega))) => fit::Omega::Given(omega),
            },
            sweeps: self.sweeps,
        });
        Ok(MethodChoice { method, selected })
    }
}

impl AdaptiveInput {
    fn settings(self, grid: Grid, surface: bool) -> OrMistakes<Adaptive> {
        let wrong = |setting, detail: &str| Mistake::at(SpecPart::Fit(P::Setting(setting)), detail);
        let omega = match self.omega {
            None => 1.0,
            Some(Omega(Some(omega))) => omega,
            Some(Omega(None)) => {
                let detail = "adaptive needs a number: the best omega is another one for each choice of points";
                return Err(wrong(Setting::Omega, detail).into());
            }
        };
        let Some(threshold) = self.threshold else {
            return incomplete("adaptive needs a threshold, in data units");
        };
        let threshold = threshold.of_points(grid, surface);
        let threshold = threshold.map_err(|detail| wrong(Setting::Threshold, &detail))?;
        Ok(Adaptive { threshold, omega })
    }
}

/// A setting is missing.
fn incomplete<T>(detail: &str) -> OrMistakes<T> {
    Err(Mistake::at(SpecPart::Fit(P::Method), detail).into())
}
