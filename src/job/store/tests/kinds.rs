//! Problems of every kind: with each basis, method and kind of weights, and everything else in turns.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::job::outline::{Label, Outline, Parent};
use crate::job::samples::queued;
use crate::job::store::Record;
use crate::model::stream::{
    Describe, Digits, Encoding, OnDisconnect, Pace, Samples, StreamSpec, View as StreamView,
};
use piad_fit::basis::{BasisChoice, Corners, End, Ends, Knots, Polynomial};
use piad_fit::data::{Grid, Points};
use piad_fit::engine::{DirectionChoice, Problem, Request, Tolerance, Trim, Weights, trimmed};
use piad_fit::method::{
    AS_MANY_AS_DATA, Adaptive, Convex, Custom, Extended, KnotSelection, LeastSquares, Local,
    Method, Omega, Start, Sweeps, Threshold, Variant, Weighted,
};
use piad_fit::parameters::{
    CoordinatePlane, Cylinder, Domain, Mesh, MeshUnfolding, Pairs, Parametrization, Scattered,
    Sections, Sphere,
};

const CURVE: Grid = Grid {
    rows: 12,
    columns: 1,
};
const SURFACE: Grid = Grid {
    rows: 7,
    columns: 6,
};

/// The number of data points.
pub(super) fn size(surface: bool) -> Grid {
    if surface { SURFACE } else { CURVE }
}

/// The problems that can be computed.
pub(super) fn problems() -> Vec<Problem> {
    let mut problems = Vec::new();
    let mut turn = 0;
    for surface in [false, true] {
        let methods = methods(surface);
        for method in super::constrained::methods(surface) {
            // With polynomials of all degrees in both directions, without weights.
            let mut request = request(surface, 4, 0, 7);
            request.method = method;
            problems.push(Problem::new(request).unwrap());
        }
        problems.extend(surface.then(scattered).into_iter().flatten());
        problems.extend(surface.then(trimmed_surfaces).into_iter().flatten());
        problems.extend(automatic(surface));
        problems.push(turning(surface));
        for (method, selected) in &methods {
            for basis in 0..7 {
                for weights in 0..4 {
                    turn += 1;
                    let mut request = request(surface, basis, weights, turn);
                    request.method = method.clone();
                    request.selected = selected.clone();
                    if matches!(method, Method::LeastSquares(_)) && surface && turn % 2 == 0 {
                        request.missing = vec![0, 8, 40];
                    }
                    problems.extend(Problem::new(request));
                }
            }
            let of_method = |it: &Problem| it.method() == method;
            assert!(problems.iter().any(of_method), "{surface}: {method:?}");
        }
    }
    let some = |wanted: fn(&Request) -> bool| {
        assert!(problems.iter().any(|problem| wanted(problem.request())));
    };
    some(|it| it.start.is_some() && it.lambda_min.is_some());
    some(|it| !it.missing.is_empty());
    some(|it| it.u.closed && it.v.is_none());
    some(|it| it.v.as_ref().is_some_and(|v| v.closed));
    some(|it| matches!(it.weights, Weights::FixedGrid(_)));
    some(|it| matches!(it.weights, Weights::Homogeneous(_)) && it.v.is_some());
    some(|it| it.u.weights.is_some() && it.v.is_none());
    some(|it| it.v.as_ref().is_some_and(|v| v.weights.is_some()));
    some(|it| {
        matches!(
            &it.u.basis,
            BasisChoice::BSpline {
                knots: Knots::Explicit(_),
                ..
            }
        )
    });
    problems
}

/// Open and cubic, without anything else that is unusual.
fn open_cubic(surface: bool) -> Request {
    let mut request = request(surface, 0, 0, 7);
    let bspline = BasisChoice::BSpline {
        degree: 3,
        knots: Knots::Usual,
    };
    for choice in std::iter::once(&mut request.u).chain(&mut request.v) {
        choice.basis = bspline.clone();
        choice.closed = false;
        choice.ends = None;
    }
    (request.start, request.start_breaks) = (None, None);
    request
}

/// Curves with corners, and surfaces with creases.
fn turning(surface: bool) -> Problem {
    let mut request = open_cubic(surface);
    request.u.corners = Some(Corners::At(Arc::new([3])));
    if let Some(v) = &mut request.v {
        v.corners = Some(Corners::At(Arc::new([2, 3])));
    }
    request.method = Method::Direct;
    Problem::new(request).unwrap()
}

/// Fits that choose their knots, from the beginning and from knots of another one.
fn automatic(surface: bool) -> impl Iterator<Item = Problem> {
    [false, true].into_iter().map(move |goes_on| {
        let mut request = open_cubic(surface);
        let mut settings = LeastSquares::automatic(AS_MANY_AS_DATA, AS_MANY_AS_DATA);
        settings.automatic = Some(KnotSelection {
            correct_parameters: goes_on && !surface,
        });
        request.method = Method::LeastSquares(settings);
        let problem = Problem::new(request.clone()).unwrap();
        if !goes_on {
            return problem;
        }
        let count = problem.control_grid().count();
        request.start = Some(Arc::new(Points::zeros(problem.dimension(), count)));
        request.start_breaks = problem.breaks();
        request.outliers = Some(Arc::new([]));
        Problem::new(request).unwrap()
    })
}

/// The points of the rows and columns as the vertices of a mesh.
fn mesh(unfolding: MeshUnfolding) -> Scattered {
    let Grid { rows, columns } = SURFACE;
    let corners = (0..rows - 1).flat_map(|i| (0..columns - 1).map(move |j| i * columns + j));
    let triangles = corners.flat_map(|k| {
        let triangles = [
            [k, k + columns, k + 1],
            [k + 1, k + columns, k + columns + 1],
        ];
        triangles.map(|it| it.map(|index| index as u32))
    });
    Scattered::Mesh(Mesh {
        triangles: Arc::new(triangles.collect()),
        unfolding,
    })
}

/// Scattered points, with all kinds of parameters.
fn scattered() -> impl Iterator<Item = Problem> {
    let pairs = (0..SURFACE.count()).map(|i| [0.1 * i as f64, 1e-300 * i as f64]);
    let pairs: Vec<f64> = pairs.flatten().collect();
    let values = Arc::new(Points::from_flat(2, &pairs));
    let between = Domain::Between {
        ends: [-1.0, 30.0],
        poles: [false; 2],
    };
    let axis = Some([0.1, 0.2, 1.0]);
    let kinds = [
        Scattered::Given(Pairs::open(Arc::clone(&values))),
        Scattered::Given(Pairs {
            values,
            domains: [Domain::Closed(30.0), between],
        }),
        Scattered::Auto,
        Scattered::Sections(Sections {
            closed: Some(false),
            ..Sections::new([SURFACE.columns; SURFACE.rows])
        }),
        Scattered::Plane,
        Scattered::Coordinates(CoordinatePlane::Xy),
        Scattered::Coordinates(CoordinatePlane::Yz),
        Scattered::Cylinder(Cylinder { axis, center: None }),
        Scattered::Sphere(Sphere {
            axis: None,
            center: axis,
        }),
        mesh(MeshUnfolding::Auto),
        mesh(MeshUnfolding::MeanValue),
    ];
    kinds.into_iter().map(|kind| {
        // Closed directions are B-splines.
        let mut request = open_cubic(true);
        request.grid = Grid {
            rows: SURFACE.count(),
            columns: 1,
        };
        request.method = Method::LeastSquares(LeastSquares::new(6, 5));
        request.scattered = Some(kind);
        // Scattered points have pairs of parameters, and directions have none of their own.
        request.u.parameters = Parametrization::ChordLength;
        if let Some(v) = &mut request.v {
            v.parameters = Parametrization::ChordLength;
        }
        Problem::new(request).unwrap()
    })
}

/// Scattered points of a surface that is trimmed.
fn trimmed_surfaces() -> impl Iterator<Item = Problem> {
    [None, Some(0.3)].into_iter().map(|distance| {
        let mut points = Points::new(3);
        for k in 0..400 {
            let [x, y] = [k % 20, k / 20].map(|i| f64::from(i) / 10.0);
            if x + y < 2.5 {
                points.push(&[x, y, x * y]);
            }
        }
        let mut request = open_cubic(true);
        let v = request.v.iter_mut();
        let choices = std::iter::once(&mut request.u).chain(v);
        choices.for_each(|it| it.parameters = Parametrization::ChordLength);
        let grid = Grid {
            rows: points.len(),
            columns: 1,
        };
        let request = Request {
            points: Arc::new(points),
            grid,
            method: Method::LeastSquares(LeastSquares::new(5, 5)),
            scattered: Some(Scattered::Plane),
            trim: Some(Trim { distance }),
            ..request
        };
        let problem = trimmed(Problem::new(request).unwrap()).unwrap();
        assert!(problem.outline().is_some_and(|it| it.loops.len() == 1));
        problem
    })
}

/// A job with such a problem, with all client data.
pub(super) fn record(problem: &Problem) -> Record {
    let other = queued();
    let surface = problem.v().is_some();
    let stream = StreamSpec {
        describe: Some(Describe::None),
        view: Some(StreamView::Samples),
        samples: Some(match surface {
            false => Samples::Count(300),
            true => Samples::Grid(30, 20),
        }),
        every: None,
        milestones: Some(vec![0.1, 1e-300]),
        pace: Some(Pace::All),
        changed: Some(false),
        encoding: Some(Encoding::Delta),
        digits: Some(Digits::Auto),
        on_disconnect: Some(OnDisconnect::Cancel),
    };
    let label = Label {
        name: Some("Flügel".to_owned()),
        parent: Some(Parent {
            id: other.outline.id,
            iteration: 7,
        }),
        stream: Some(Arc::new(stream)),
        notices: vec!["The last point is the first one again.".to_owned()],
    };
    Record {
        outline: Outline::new(label, problem, None),
        ..other
    }
}

/// Every method, with the points that it selects.
fn methods(surface: bool) -> Vec<(Method, Option<Arc<[usize]>>)> {
    let grid = size(surface);
    let adaptive = Adaptive {
        threshold: Threshold::All(1e-3),
        omega: 1.0,
    };
    let mut methods = vec![
        Method::Global,
        Method::Weighted(Weighted { omega: None }),
        Method::Weighted(Weighted { omega: Some(0.1) }),
        Method::Adaptive(adaptive.clone()),
        Method::Adaptive(Adaptive {
            omega: 1.5,
            ..adaptive
        }),
        Method::Adaptive(Adaptive {
            threshold: Threshold::Each((1..=grid.count()).map(|i| 1e-4 * i as f64).collect()),
            omega: 1.0,
        }),
        Method::Extended(Extended::default()),
        Method::Extended(Extended {
            start: Start::Data,
            transformed_error: true,
        }),
        Method::Transpose,
        Method::Chebyshev,
        Method::Direct,
    ];
    let v = if surface { 4 } else { 5 };
    methods.extend(
        [
            Variant::Diagonal,
            Variant::Lspia { mu: None },
            Variant::Lspia { mu: Some(0.01) },
            Variant::ConjugateGradients,
            Variant::Direct,
        ]
        .map(|variant| {
            Method::LeastSquares(LeastSquares {
                variant,
                ..LeastSquares::new(5, v)
            })
        }),
    );
    let custom = |v| Method::Custom(Custom::new(nearly_identity(grid.rows), v));
    if surface {
        methods.push(custom(Some(nearly_identity(grid.columns))));
    } else {
        let rough = Convex {
            step_tolerance: 0.1,
        };
        methods.extend([custom(None)]);
        methods.extend([Convex::default(), rough].map(Method::Convex));
    }
    let mut methods: Vec<_> = methods.into_iter().map(|method| (method, None)).collect();
    let local = |sweeps| {
        Method::Local(Local {
            sweeps,
            ..Local::default()
        })
    };
    methods.push((local(None), Some([5, 2, 3].into())));
    for omega in [Omega::Given(0.5), Omega::Best] {
        let relaxed = Local {
            omega,
            ..Local::default()
        };
        methods.push((Method::Local(relaxed), Some([1, 4].into())));
    }
    if surface {
        for sweeps in [Sweeps::Rows, Sweeps::Columns] {
            methods.push((local(Some(sweeps)), None));
            methods.push((local(Some(sweeps)), Some([30, 2].into())));
        }
    }
    methods
}

fn nearly_identity(count: usize) -> Vec<Vec<f64>> {
    let entry = |i, j| if i == j { 0.9 } else { -0.0 };
    let row = |i| (0..count).map(|j| entry(i, j)).collect();
    (0..count).map(row).collect()
}

fn request(surface: bool, basis: usize, weights: usize, turn: usize) -> Request {
    let grid = size(surface);
    let points = Arc::new(points(grid, 2 + turn % 2));
    let mut u = direction(grid.rows, basis, turn);
    // Both directions of a surface are chosen apart.
    let mut v = surface.then(|| direction(grid.columns, (basis + turn) % 7, turn / 3));
    let product = |i: usize| weight(i / grid.columns) * weight(i % grid.columns + 3);
    let mut of_points = Weights::None;
    match (weights, &mut v) {
        (0, _) => {}
        (1, _) => of_points = Weights::Homogeneous((0..grid.count()).map(weight).collect()),
        (2, Some(_)) => of_points = Weights::FixedGrid((0..grid.count()).map(product).collect()),
        (_, v) => {
            u.weights = Some((0..grid.rows).map(weight).collect());
            if let Some(v) = v {
                v.weights = Some((0..grid.columns).map(weight).collect());
            }
        }
    }
    let lines = [grid.columns, grid.rows];
    for (choice, boundary) in std::iter::once(&mut u).chain(&mut v).zip(lines) {
        set_ends(choice, turn, (boundary, 2 + turn % 2));
    }
    let edited = turn.is_multiple_of(2) && weights != 1;
    Request {
        start: edited.then(|| Arc::clone(&points)),
        lambda_min: edited.then_some(0.1),
        weights: of_points,
        tolerance: match turn % 4 {
            0 => Some(Tolerance::Absolute(0.0)),
            1 => Some(Tolerance::Absolute(0.1)),
            2 => Some(Tolerance::Relative(1e-7)),
            _ => None,
        },
        max_iterations: turn,
        ..Request::new(points, grid, u, v)
    }
}

/// Points of a wave over a circle, which closes.
pub(super) fn points(grid: Grid, dimension: usize) -> Points {
    let mut points = Points::new(dimension);
    for i in 0..grid.rows {
        for j in 0..grid.columns {
            let (s, t) = (2.0 * PI * i as f64 / grid.rows as f64, j as f64);
            let point = [
                s.cos() * (1.0 + t),
                s.sin() * (1.0 + t) - 0.1,
                (s + t).sin(),
            ];
            points.push(&point);
        }
    }
    points
}

/// Ends of many kinds, where there are some to choose.
fn set_ends(choice: &mut DirectionChoice, turn: usize, (boundary, dimension): (usize, usize)) {
    if choice.closed
        || choice.basis
            != (BasisChoice::BSpline {
                degree: 3,
                knots: Knots::Data,
            })
    {
        return;
    }
    let mut vectors = Points::new(dimension);
    (0..boundary).for_each(|i| vectors.push(&[0.3, i as f64, -1.5][..dimension]));
    let vectors = Arc::new(vectors);
    let end = |turn| match turn % 5 {
        0 => End::Estimated,
        1 => End::Repeated,
        2 => End::Natural,
        3 => End::Derivatives(vec![Arc::clone(&vectors)]),
        _ => End::Tangent(Arc::clone(&vectors)),
    };
    choice.ends = Some(Ends {
        start: end(turn),
        end: end(turn / 5),
    });
}

fn direction(count: usize, basis: usize, turn: usize) -> DirectionChoice {
    let values: Vec<f64> = (0..=count).map(|i| 0.1 * i as f64 + 0.7).collect();
    let closed = turn.is_multiple_of(5) && basis < 3;
    let given = if closed { count + 1 } else { count };
    let explicit = Parametrization::Explicit(Arc::new(values[..given].to_vec()));
    let spline = |degree, knots| BasisChoice::BSpline { degree, knots };
    DirectionChoice {
        closed,
        ..DirectionChoice::new(
            match basis {
                0 => spline(3, Knots::Usual),
                1 => spline(3, Knots::Data),
                2 => spline(2, Knots::Averaged),
                3 => spline(1, Knots::Explicit(Arc::new(knots(&values[..count])))),
                4 => BasisChoice::Polynomial(Polynomial::Bernstein),
                5 => BasisChoice::Polynomial(Polynomial::SaidBall),
                _ => BasisChoice::Polynomial(Polynomial::WangBall),
            },
            match (basis, turn % 4) {
                (3, _) | (_, 0) => explicit,
                (_, 1) => Parametrization::Centripetal,
                (_, 2) => Parametrization::Uniform,
                _ => Parametrization::ChordLength,
            },
        )
    }
}

/// Clamped knots of degree 1 at these parameters.
fn knots(parameters: &[f64]) -> Vec<f64> {
    let (first, last) = (parameters[0], parameters[parameters.len() - 1]);
    let mut knots = vec![first];
    knots.extend(parameters);
    knots.push(last);
    knots
}

fn weight(index: usize) -> f64 {
    1.0 + 0.3 * (index as f64).sin()
}
