//! A method as it is asked for.

use std::sync::Arc;

use super::mistakes::{Mistake, OrMistakes, SpecPart};
use crate::fit::invalid::{Place, Setting};
use crate::fit::method::{Local, Method, Sweeps};

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
    /// Local PIA, which adjusts some points, or all of them in sweeps.
    pub fn local(selected: Option<Arc<[usize]>>, settings: Local) -> OrMistakes<Self> {
        if selected.is_none() && settings.sweeps.is_none() {
            let detail = "local needs the indices of the points to adjust, or sweeps";
            return Err(Mistake::at(SpecPart::Fit(Place::Method), detail).into());
        }
        let method = Method::Local(settings);
        Ok(Self { method, selected })
    }
}

/// The sweeps of local PIA, which are for surfaces.
pub fn sweeps(sweeps: Option<Sweeps>, surface: bool) -> Result<Option<Sweeps>, Mistake> {
    let place = SpecPart::Fit(Place::Setting(Setting::Sweeps));
    let detail = "sweeps are for surfaces; a curve has no rows and no columns";
    match sweeps.is_some() && !surface {
        true => Err(Mistake::at(place, detail)),
        false => Ok(sweeps),
    }
}

/// A step μ is given with a variant of least squares that has none.
pub fn mu_without_lspia() -> Mistake {
    let detail = "mu is a setting of the variant \"lspia\"";
    Mistake::at(SpecPart::Fit(Place::Setting(Setting::Mu)), detail)
}
