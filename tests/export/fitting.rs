//! From a job to its last level.

use std::sync::Arc;

use jiff::Timestamp;
use piad::config::Config;
use piad::model::job::JobRequest;
use piad::model::scattered::no_base;
use piad_files::export::nurbs::KnotVector;
use piad_files::export::{Fitted, Nurbs};
use piad_fit::data::Points;
use piad_fit::engine::samples::Uniform;
use piad_fit::engine::{Direction, Geometry, Iteration, Problem, System, bspline};
use serde_json::{Value, json};

/// The end of a fit.
pub struct Fit {
    pub name: Option<String>,
    pub problem: Arc<Problem>,
    pub control_points: Arc<Points>,
    pub errors: Vec<f64>,
}

impl Fit {
    pub fn new(job: &Value) -> Self {
        let config = Config::standard();
        let request: JobRequest = serde_json::from_value(job.clone()).unwrap();
        let valid = request.validate(config.limits(), Err(no_base()));
        let job = valid.unwrap_or_else(|errors| panic!("{job}: {errors:?}"));
        let mut iteration = Iteration::start(Arc::new(System::new(Arc::new(job.problem))));
        let mut errors = vec![iteration.level().error.max];
        while iteration.outcome().is_none() {
            errors.push(iteration.step().error.max);
        }
        Self {
            name: job.name,
            // A fit that chooses its knots has others at each level.
            problem: Arc::clone(iteration.problem()),
            control_points: iteration.shared_control_points(),
            errors,
        }
    }

    pub fn fitted(&self) -> Fitted<'_> {
        let created = Timestamp::from_second(1_800_000_000).unwrap();
        Fitted {
            name: self.name.as_deref(),
            errors: &self.errors,
            ..Fitted::new(&self.problem, &self.control_points, created)
        }
    }

    /// The result in the form of `GET /v1/jobs/{id}/result`.
    pub fn result(&self) -> Value {
        let problem = &self.problem;
        let geometry = Geometry::new(problem, &self.control_points);
        let place = |row, column| json!(geometry.place(row, column).collect::<Vec<f64>>());
        let mut result = json!({
            "name": self.name,
            "kind": if problem.v().is_some() { "surface" } else { "curve" },
            "error": {"max": self.errors.last()},
            "basis": each(problem, |it| json!(it.basis.name())),
            "degree": each(problem, |it| json!(it.basis.degree())),
            "closed": each(problem, |it| json!(it.is_closed())),
            "knots": each(problem, |it| json!(it.basis.knots())),
            "rational": null,
            "control_points": net(geometry, place),
        });
        if problem.is_homogeneous() {
            result["rational"] = json!("homogeneous");
            result["weights"] = net(geometry, |row, column| json!(geometry.weight(row, column)));
        } else if problem.directions().any(Direction::is_rational) {
            result["rational"] = json!("fixed");
            result["weights"] = each(problem, |it| json!(it.weights()));
        }
        result
    }

    /// The largest distance between the fit and the spline that is exported, over the size of the
    /// data.
    pub fn largest_difference(&self, nurbs: &Nurbs) -> f64 {
        let along = |direction: &Direction| {
            let line = Uniform::new(&direction.basis, 53);
            (0..53).map(|i| line.at(i)).collect::<Vec<f64>>()
        };
        let u = along(self.problem.u());
        let v = self.problem.v().map(along).unwrap_or_default();
        let expected = Geometry::new(&self.problem, &self.control_points).evaluate(&u, &v);
        let found = evaluate(nurbs, &u, &v);
        let mut worst = 0.0_f64;
        for (index, place) in found.iter().enumerate() {
            for (x, expected) in place.iter().zip(expected.point(index)) {
                worst = worst.max((x - expected).abs());
            }
        }
        worst / expected.magnitude()
    }
}

/// Points of the spline by its definition (PT97 (4.1), (4.15)).
fn evaluate(nurbs: &Nurbs, u: &[f64], v: &[f64]) -> Vec<[f64; 3]> {
    let functions = |knots: &KnotVector, t: f64| {
        let span = bspline::find_span(knots.degree, &knots.knots, t);
        let mut values = vec![0.0; knots.degree + 1];
        bspline::evaluate(knots.degree, &knots.knots, span, t, &mut values);
        (span - knots.degree, values)
    };
    let across: Vec<(usize, Vec<f64>)> = match &nurbs.v {
        None => vec![(0, vec![1.0])],
        Some(knots) => v.iter().map(|&t| functions(knots, t)).collect(),
    };
    let mut points = Vec::new();
    for &t in u {
        let (row, along) = functions(&nurbs.u, t);
        for (column, across) in &across {
            let (mut sum, mut weight) = ([0.0; 3], 0.0);
            for (i, a) in along.iter().enumerate() {
                for (j, b) in across.iter().enumerate() {
                    let index = (row + i) * nurbs.columns() + column + j;
                    let factor = a * b * nurbs.weight(index);
                    weight += factor;
                    let place = nurbs.place(index);
                    (0..3).for_each(|c| sum[c] += factor * place[c]);
                }
            }
            points.push(sum.map(|x| x / weight));
        }
    }
    points
}

fn each(problem: &Problem, of: impl Fn(&Direction) -> Value) -> Value {
    match problem.v() {
        None => of(problem.u()),
        Some(v) => json!({"u": of(problem.u()), "v": of(v)}),
    }
}

fn net(geometry: Geometry<'_>, of: impl Fn(usize, usize) -> Value) -> Value {
    let rows = 0..geometry.rows();
    match geometry.columns() {
        None => rows.map(|row| of(row, 0)).collect(),
        Some(columns) => rows
            .map(|row| {
                (0..columns)
                    .map(|column| of(row, column))
                    .collect::<Value>()
            })
            .collect(),
    }
}
