//! Settings as JSON: their names, and round trips.

use std::fmt::Debug;
use std::sync::Arc;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::basis::{BasisChoice, End, Ends, Knots, Polynomial};
use super::data::Points;
use super::invalid::{Axis, Side};
use super::method::{
    Adaptive, At, Constraint, Convex, Custom, EndPoints, Extended, Fairness, LeastSquares, Local,
    Method, Omega, Start, Sweeps, Threshold, Variant, Wanted, Weighted,
};
use super::parameters::{CoordinatePlane, Parametrization, Scattered};
use super::problem::request::{Tolerance, Weights};

/// Checks the JSON of a setting and its round trip.
fn check<T: Serialize + DeserializeOwned + PartialEq + Debug>(setting: T, expected: Value) {
    let written = serde_json::to_value(&setting).unwrap();
    assert_eq!(written, expected);
    assert_eq!(serde_json::from_value::<T>(written).unwrap(), setting);
}

#[test]
fn methods_have_their_names() {
    check(Method::Global, json!({"kind": "global"}));
    check(
        Method::Weighted(Weighted { omega: None }),
        json!({"kind": "weighted", "omega": null}),
    );
    let local = Local {
        omega: Omega::Best,
        sweeps: Some(Sweeps::Rows),
    };
    check(
        Method::Local(local),
        json!({"kind": "local", "omega": "best", "sweeps": "rows"}),
    );
    let custom = Custom::new(vec![vec![1.0, 0.0], vec![0.0, 1.0]], None);
    check(
        Method::Custom(custom),
        json!({"kind": "custom", "u": [[1.0, 0.0], [0.0, 1.0]], "v": null}),
    );
    for method in [
        Method::Adaptive(Adaptive {
            threshold: Threshold::Each(Arc::new([0.5, 0.25])),
            omega: 1.5,
        }),
        Method::Extended(Extended {
            start: Start::Data,
            ..Extended::default()
        }),
        Method::Convex(Convex::default()),
        Method::Transpose,
        Method::Chebyshev,
        Method::Direct,
    ] {
        let name = method.name();
        let written = serde_json::to_value(&method).unwrap();
        assert_eq!(written["kind"], name);
        check(method, written);
    }
}

#[test]
fn least_squares_has_its_constraints() {
    let constraint = |at, wanted| Constraint { at, wanted };
    let settings = LeastSquares {
        variant: Variant::ConjugateGradients,
        ends: EndPoints::Free,
        constraints: Arc::new([
            constraint(At::Side(Side::Start), Wanted::Tangent(vec![1.0, 0.0])),
            constraint(At::Index(3), Wanted::DataPoint),
            constraint(
                At::Boundary(Axis::U, Side::End),
                Wanted::Across {
                    order: 1,
                    control_points: Points::from_lanes([vec![0.0, 1.0]]),
                },
            ),
        ]),
        fairness: Some(Fairness {
            value: 1e-6,
            order: 2,
            by_data: false,
        }),
        ..LeastSquares::new(7, 5)
    };
    let written = serde_json::to_value(&settings).unwrap();
    assert_eq!(
        (&written["variant"], &written["ends"]),
        (&json!("cg"), &json!("free"))
    );
    assert_eq!(
        written["constraints"][0],
        json!({"at": {"side": "start"}, "wanted": {"tangent": [1.0, 0.0]}})
    );
    assert_eq!(
        written["constraints"][1],
        json!({"at": {"index": 3}, "wanted": "data_point"})
    );
    check(Method::LeastSquares(settings), {
        let mut written = written;
        written["kind"] = json!("least_squares");
        written
    });
}

#[test]
fn directions_have_theirs() {
    let knots = Knots::Explicit(Arc::new(vec![0.0, 0.0, 1.0, 1.0]));
    check(
        BasisChoice::BSpline { degree: 1, knots },
        json!({"b_spline": {"degree": 1, "knots": {"explicit": [0.0, 0.0, 1.0, 1.0]}}}),
    );
    check(
        BasisChoice::Polynomial(Polynomial::SaidBall),
        json!({"polynomial": "said_ball"}),
    );
    check(
        Ends {
            start: End::Natural,
            end: End::Repeated,
        },
        json!({"start": "natural", "end": "repeated"}),
    );
    check(Parametrization::ChordLength, json!("chord_length"));
    check(
        Scattered::Coordinates(CoordinatePlane::Xz),
        json!({"coordinates": "xz"}),
    );
    check(Tolerance::Absolute(0.25), json!({"absolute": 0.25}));
    check(
        Weights::Homogeneous(vec![1.0, 2.0]),
        json!({"homogeneous": [1.0, 2.0]}),
    );
}
