//! Methods written back as they were asked for.

use serde_json::{Map, Value, json};

use super::constraint;
use super::kinds::variant_name;
use crate::api::json::view::error::PointIndex;
use crate::fit::method::{
    AS_MANY_AS_DATA, Adaptive, Convex, EndPoints, LeastSquares, Local, Method, Threshold, Variant,
    Weighted,
};
use crate::fit::problem::Problem;

/// One threshold, or one for each point.
fn threshold_of(threshold: &Threshold, problem: &Problem) -> Value {
    match threshold {
        Threshold::All(threshold) => json!(threshold),
        Threshold::Each(each) => of_points(each, problem),
    }
}

/// A number for each point of a curve, or rows of them.
fn of_points(values: &[f64], problem: &Problem) -> Value {
    match problem.v().filter(|_| !problem.is_scattered()) {
        None => json!(values),
        Some(_) => {
            let rows = values.chunks(problem.grid().columns);
            rows.map(|row| json!(row)).collect()
        }
    }
}

/// The method of a problem as it was asked for.
pub(in crate::api) fn written(problem: &Problem) -> Value {
    let mut value = Map::new();
    let method = problem.method();
    value.insert("kind".to_owned(), json!(method.name()));
    let mut set = |name: &str, setting: Value| {
        value.insert(name.to_owned(), setting);
    };
    match *method {
        Method::Weighted(Weighted { omega }) => {
            set("omega", omega.map_or(json!("auto"), Value::from))
        }
        Method::Local(Local { omega, sweeps }) => {
            if let Some(omega) = omega.other_than_one() {
                set("omega", omega.given().map_or(json!("auto"), Value::from));
            }
            if let Some(selected) = problem.selected() {
                let indices = selected
                    .iter()
                    .map(|&index| json!(PointIndex::new(index, problem)));
                set("indices", indices.collect());
            }
            if let Some(sweeps) = sweeps {
                set("sweeps", json!(sweeps));
            }
        }
        Method::Adaptive(Adaptive {
            ref threshold,
            omega,
        }) => {
            set("threshold", threshold_of(threshold, problem));
            if omega != 1.0 {
                set("omega", json!(omega));
            }
        }
        Method::Extended(settings) => {
            set("start", json!(settings.start));
            if settings.transformed_error {
                set("transformed_error", json!(true));
            }
        }
        Method::LeastSquares(ref settings) => least_squares(settings, problem, set),
        Method::Convex(convex) if convex != Convex::default() => {
            set("step_tolerance", json!(convex.step_tolerance));
        }
        Method::Custom(ref custom) => {
            let transform = match custom.v() {
                None => json!(custom.u()),
                Some(v) => json!({"u": custom.u(), "v": v}),
            };
            set("transform", transform);
        }
        Method::Global
        | Method::Transpose
        | Method::Convex(_)
        | Method::Chebyshev
        | Method::Direct => {}
    }
    Value::Object(value)
}

/// The settings of least squares that are not the usual ones.
fn least_squares(settings: &LeastSquares, problem: &Problem, mut set: impl FnMut(&str, Value)) {
    let LeastSquares { u, v, .. } = settings;
    let is_surface = problem.v().is_some();
    let counts = || match is_surface {
        true => json!({"u": u, "v": v}),
        false => json!(u),
    };
    match &settings.automatic {
        None => {
            set("control_points", counts());
            set("variant", json!(variant_name(settings.variant)));
        }
        Some(automatic) => {
            set("control_points", json!("auto"));
            if *u != AS_MANY_AS_DATA {
                set("max_control_points", counts());
            }
            if automatic.correct_parameters {
                set("correct_parameters", json!(true));
            }
        }
    }
    if let Variant::Lspia { mu: Some(mu) } = settings.variant {
        set("mu", json!(mu));
    }
    if settings.ends != EndPoints::Usual {
        set("end_points", json!(settings.ends));
    }
    if let Some(weights) = &settings.data_weights {
        set("data_weights", of_points(weights, problem));
    }
    if let Some(fairness) = settings.fairness {
        set("fairness", json!(fairness.value));
        set("fairness_order", json!(fairness.order));
    }
    if !settings.constraints.is_empty() {
        let constraints = settings.constraints.iter();
        let constraints = constraints.map(|it| constraint::written(it, problem));
        set("constraints", constraints.collect());
    }
}
