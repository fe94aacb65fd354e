//! A job as it is asked for, and its way to a fitting problem.
//!
//! What a language cannot read of a part of a job stands in its place, so that one answer tells all
//! that is wrong, in the order of the fields here.

use std::sync::Arc;

use super::method::MethodSpec;
use super::mistakes::{Mistake, Mistakes, OrMistakes, SpecPart};
use super::scattered::{BaseSpec, ScatteredSpec, no_base};
use super::shape::ShapeSpec;
use super::stop::StopSpec;
use super::stream::StreamSpec;
use super::weights::Rational;
use crate::fit::admission::Admission;
use crate::fit::invalid as fit;
use crate::fit::nurbs::Nurbs;
use crate::fit::problem::{Problem, Request};

/// The most characters of a name.
pub const LONGEST_NAME: usize = 200;

/// A job as it is asked for.
#[derive(Clone, Debug)]
pub struct JobSpec {
    /// The client's name for it.
    pub name: Option<String>,
    /// Whether a surface is fitted.
    pub surface: bool,
    /// What is fitted.
    pub shape: OrMistakes<ShapeSpec>,
    /// How weights are used.
    pub rational: OrMistakes<Option<Rational>>,
    /// The method.
    pub method: OrMistakes<MethodSpec>,
    /// When the iteration ends.
    pub stop: StopSpec,
    /// What its streams are like if they do not say it themselves.
    pub stream: OrMistakes<Option<StreamSpec>>,
}

/// A job that can be computed.
#[derive(Debug)]
pub struct ValidJob {
    /// The client's name for it.
    pub name: Option<String>,
    /// What its streams are like if they do not say it themselves.
    pub stream: Option<Arc<StreamSpec>>,
    /// The problem.
    pub problem: Problem,
}

/// What a server accepts.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The most data points.
    pub points: usize,
    /// The most iterations.
    pub iterations: usize,
    /// What a fit may take.
    pub admission: Admission,
}

impl JobSpec {
    /// The job on whose surface scattered points have their foot points.
    pub fn base(&self) -> Option<&BaseSpec> {
        match self.shape.as_ref().ok()?.scattered.as_ref()? {
            ScatteredSpec::Own(_) => None,
            ScatteredSpec::FootPoints(base) => Some(base),
        }
    }

    /// Checks the job against the limits and the mathematics. `base` is the surface of
    /// [`Self::base`], or why there is none.
    pub fn validate(self, limits: Limits, base: Result<&Nurbs, Mistake>) -> OrMistakes<ValidJob> {
        let mut mistakes = Mistakes::default();
        mistakes.keep(check_name(self.name.as_deref()));
        let rational = self.rational.clone().ok().flatten();
        let shape = mistakes.keep(self.shape);
        let shape = shape.and_then(|shape| shape.shape(rational, &mut mistakes));
        let shape = shape.filter(|shape| {
            let count = check_count(shape.grid.count(), limits.points);
            mistakes.keep(count).is_some()
        });
        let rules = self.stop.rules(limits.iterations, &mut mistakes);
        let stream = mistakes.keep(self.stream).flatten();
        let fits = stream.as_ref().map(|stream| stream.check(self.surface));
        mistakes.keep(fits.transpose());
        mistakes.keep(self.rational);
        let method = mistakes.keep(self.method);
        let Some((shape, method)) = shape.zip(method) else {
            return Err(mistakes);
        };
        // The points and the basis may be wrong beside what was found so far.
        let request = mistakes.keep(shape.request(base, method, rules));
        let problem =
            request.and_then(|request| mistakes.fit(request, &limits.admission, SpecPart::Fit));
        ValidJob::new(self.name, stream, problem, mistakes)
    }

    /// The problem of a job that was accepted before: no limit is looked at.
    pub fn request(self) -> OrMistakes<Request> {
        let mut mistakes = Mistakes::default();
        let rational = mistakes.keep(self.rational).flatten();
        let shape = mistakes.keep(self.shape);
        let shape = shape.and_then(|shape| shape.shape(rational, &mut mistakes));
        let method = mistakes.keep(self.method);
        let rules = self.stop.rules(usize::MAX, &mut mistakes);
        match shape.zip(method) {
            Some((shape, method)) => {
                let request = shape.request(Err(no_base()), method, rules)?;
                mistakes.or(request)
            }
            None => Err(mistakes),
        }
    }
}

impl ValidJob {
    /// The job, if nothing is wrong with it.
    pub(super) fn new(
        name: Option<String>,
        stream: Option<StreamSpec>,
        problem: Option<Problem>,
        mut mistakes: Mistakes,
    ) -> OrMistakes<Self> {
        let Some(problem) = problem.filter(|_| mistakes.none()) else {
            return Err(mistakes);
        };
        let fits = stream.as_ref().map(|stream| stream.check_range(&problem));
        mistakes.keep(fits.transpose());
        mistakes.or(Self {
            name,
            stream: stream.map(Arc::new),
            problem,
        })
    }
}

pub(super) fn check_name(name: Option<&str>) -> OrMistakes<()> {
    match name {
        Some(name) if name.chars().count() > LONGEST_NAME => {
            let detail = format!("the name is longer than {LONGEST_NAME} characters");
            Err(Mistake::at(SpecPart::Name, detail).into())
        }
        _ => Ok(()),
    }
}

fn check_count(count: usize, limit: usize) -> OrMistakes<()> {
    if count > limit {
        let detail = format!("{count} points are more than {limit}, the limit of this server");
        return Err(Mistake::at(SpecPart::Fit(fit::Place::Points), detail).into());
    }
    Ok(())
}
