//! A method as it is asked for.

use std::sync::Arc;

use super::mistakes::{Mistake, OrMistakes, SpecPart};
use crate::fit::invalid::{Place, Setting};
use crate::fit::method::{Local, Method};

/// A method as it is asked for.
#[derive(Clone, Debug)]
pub struct MethodSpec {
    /// The method with its settings.
    pub method: Method,
    /// Local fits: the indices of the points that are adjusted, if not all.
    pub selected: Option<Arc<[usize]>>,
}

impl From<Method> for MethodSpec {
    fn from(method: Method) -> Self {
        let selected = None;
        Self { method, selected }
    }
}

impl MethodSpec {
    /// Local PIA, which adjusts some points, or all of them row by row.
    pub fn local(selected: Option<Arc<[usize]>>, settings: Local) -> OrMistakes<Self> {
        if selected.is_none() && !settings.row_by_row {
            let detail = "local needs the indices of the points to adjust, or row_by_row";
            return Err(Mistake::at(SpecPart::Fit(Place::Method), detail).into());
        }
        let method = Method::Local(settings);
        Ok(Self { method, selected })
    }
}

/// A step μ is given with a variant of least squares that has none.
pub fn mu_without_lspia() -> Mistake {
    let detail = "mu is a setting of the variant \"lspia\"";
    Mistake::at(SpecPart::Fit(Place::Setting(Setting::Mu)), detail)
}
