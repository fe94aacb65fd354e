//! The method of a problem as it was asked for.

use serde_json::{Map, Value, json};

use super::kind::{start_name, sweeps_name};
use super::least_squares::variant_name;
use crate::api::json::view::error::PointIndex;
use crate::fit::method::{
    Adaptive, Convex, Ending, LeastSquares, Local, Method, Sweeps, Threshold, Variant, Weighted,
};
use crate::fit::problem::Problem;

/// One threshold, one for each point of a curve, or rows of them.
fn written_threshold(threshold: &Threshold, problem: &Problem) -> Value {
    match (threshold, problem.v()) {
        (Threshold::All(threshold), _) => json!(threshold),
        (Threshold::Each(each), None) => json!(&each[..]),
        (Threshold::Each(each), Some(_)) => {
            let rows = each.chunks(problem.grid().columns);
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
            match sweeps {
                Some(Sweeps::Columns) => set("sweeps", json!(sweeps_name(Sweeps::Columns))),
                _ => set("row_by_row", json!(sweeps.is_some())),
            }
        }
        Method::Adaptive(Adaptive {
            ref threshold,
            omega,
        }) => {
            set("threshold", written_threshold(threshold, problem));
            if omega != 1.0 {
                set("omega", json!(omega));
            }
        }
        Method::Extended(settings) => {
            set("start", json!(start_name(settings.start)));
            if settings.transformed_error {
                set("transformed_error", json!(true));
            }
        }
        Method::LeastSquares(LeastSquares {
            u,
            v,
            variant,
            ending,
            ..
        }) => {
            set(
                "control_points",
                match problem.v() {
                    None => json!(u),
                    Some(_) => json!({"u": u, "v": v}),
                },
            );
            set("variant", json!(variant_name(variant)));
            if let Variant::Lspia { mu: Some(mu) } = variant {
                set("mu", json!(mu));
            }
            if ending == Ending::SmallStep {
                set("ending", json!("small_step"));
            }
        }
        Method::Convex(convex) if convex != Convex::default() => {
            set("threshold", json!(convex.threshold));
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
