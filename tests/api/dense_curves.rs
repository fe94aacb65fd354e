//! Constrained curves with fewer, as many and more conditions than control points: a thousand generated ones.
//!
//! A job is refused if and only if a condition contradicts others. Those that are accepted obey all of them, and are at
//! their minimum: the gradient is a sum of the conditions, `Aᵀ(P − A X) = Cᵀ Λ`. For a tangent with the vector v and a
//! derivative s v, `Λ v = 0` where s > 0, and `Λ v ≤ 0` where s = 0.

use nalgebra::{DMatrix, DVector};
use serde_json::{Value, json};

use crate::dense::Line;
use crate::numbers::numbers;
use crate::random::Random;
use crate::support::{Server, base};

/// How many curves are generated.
const ROUNDS: u64 = 1000;

/// A row of C depends on others if it is nearer to their span than this, and does not if it is further away
/// than the second number; what is between is left out.
const DEPENDENT: [f64; 2] = [1e-9, 1e-5];

/// A condition: its row of C, its value, and whether that is the vector of a tangent.
struct Condition {
    row: DVector<f64>,
    value: Vec<f64>,
    is_tangent: bool,
}

/// A constraint: at a data point or a parameter, with one thing that holds there.
struct Asked {
    at: f64,
    index: Option<usize>,
    what: &'static str,
    vector: Vec<f64>,
}

impl Asked {
    fn generate(random: &mut Random, (t, degree): (&[f64], usize)) -> Self {
        let index = random.below(t.len());
        let all = [
            "index",
            "point",
            "derivative",
            "tangent",
            "second_derivative",
        ];
        // Derivatives are continuous.
        let what = all[random.below(if degree > 2 {
            5
        } else if degree > 1 {
            4
        } else {
            2
        })];
        let is_at_point = what == "index" || random.chance(0.5);
        Self {
            at: if is_at_point { t[index] } else { random.part() },
            index: is_at_point.then_some(index),
            what,
            vector: random.vector()[..2].to_vec(),
        }
    }

    fn written(&self) -> Value {
        match (self.what, self.index) {
            ("index", index) => json!({"index": index}),
            (what, Some(index)) => json!({"at": {"index": index}, what: self.vector}),
            (what, None) => json!({"at": {"parameter": self.at}, what: self.vector}),
        }
    }

    fn condition(&self, line: &Line, points: &[Vec<f64>]) -> Condition {
        let order = match self.what {
            "index" | "point" => 0,
            "second_derivative" => 2,
            _ => 1,
        };
        let value = match self.index {
            Some(index) if self.what == "index" => points[index].clone(),
            _ => self.vector.clone(),
        };
        let is_tangent = self.what == "tangent";
        Condition {
            row: line.values(self.at, order),
            value,
            is_tangent,
        }
    }
}

/// Which conditions do not depend on those before them: `Err` if one contradicts others, `None` if that is not
/// clear. Tangents come last.
fn independent(conditions: &[Condition]) -> Option<Result<Vec<&Condition>, ()>> {
    let mut kept: Vec<&Condition> = Vec::new();
    for condition in conditions {
        let row = condition.row.normalize();
        let columns: Vec<DVector<f64>> = kept.iter().map(|it| it.row.clone()).collect();
        let Some(first) = columns.first() else {
            kept.push(condition);
            continue;
        };
        let matrix = DMatrix::from_columns(&columns);
        let factors = matrix.clone().svd(true, true).solve(&row, 1e-14).unwrap();
        let distance = (&row - &matrix * &factors).norm();
        if distance > DEPENDENT[1] && first.len() > kept.len() {
            kept.push(condition);
            continue;
        }
        if distance > DEPENDENT[0] {
            return None;
        }
        // Random vectors do not agree; what is said twice does.
        let of_same = |other: &&&Condition| (other.row.normalize() - &row).norm() < 1e-12;
        let same = kept.iter().find(of_same);
        if !same.is_some_and(|same| {
            same.is_tangent == condition.is_tangent && same.value == condition.value
        }) {
            return Some(Err(()));
        }
    }
    Some(Ok(kept))
}

/// The square of the condition of the conditions, with rows of length one.
fn squared_condition(kept: &[&Condition]) -> f64 {
    let columns: Vec<DVector<f64>> = kept.iter().map(|it| it.row.normalize()).collect();
    if columns.is_empty() {
        return 1.0;
    }
    let singular = DMatrix::from_columns(&columns).singular_values();
    (singular.max() / singular.min()).powi(2)
}

/// How far the control points are from obeying, and from the minimum, as parts of the data.
fn faults(line: &Line, points: &[Vec<f64>], kept: &[&Condition], x: &DMatrix<f64>) -> [f64; 2] {
    let count = points.len();
    let rows: Vec<_> = line
        .parameters
        .iter()
        .map(|t| line.values(*t, 0).transpose())
        .collect();
    let a = DMatrix::from_rows(&rows);
    let data = DMatrix::from_fn(count, 2, |i, c| points[i][c]);
    let gradient = a.transpose() * (&data - &a * x);
    let size = x.amax().max(data.amax());
    let mut off: f64 = 0.0;
    let mut minimum: f64 = 0.0;
    let multipliers = (!kept.is_empty()).then(|| {
        let columns: Vec<DVector<f64>> = kept.iter().map(|it| it.row.clone()).collect();
        let c = DMatrix::from_columns(&columns);
        let multipliers = c.clone().svd(true, true).solve(&gradient, 1e-14).unwrap();
        (c, multipliers)
    });
    let left = match &multipliers {
        Some((c, multipliers)) => &gradient - c * multipliers,
        None => gradient,
    };
    minimum = minimum.max(left.amax() / size / count as f64);
    for (k, condition) in kept.iter().enumerate() {
        let norm = condition.row.norm();
        let found = x.transpose() * &condition.row;
        let value = DVector::from_column_slice(&condition.value);
        if !condition.is_tangent {
            off = off.max((found - value).amax() / norm / size);
            continue;
        }
        let unit = value.normalize();
        let along = found.dot(&unit);
        off = off.max((&found - &unit * along.max(0.0)).amax() / norm / size);
        let Some((_, multipliers)) = &multipliers else {
            continue;
        };
        let pull = multipliers.row(k).transpose().dot(&unit) * norm;
        let is_zero = along.abs() <= 1e-12 * size * norm;
        let fault = if is_zero { pull.max(0.0) } else { pull.abs() };
        minimum = minimum.max(fault / size / count as f64);
    }
    [off, minimum]
}

#[tokio::test]
async fn constrained_curves_obey_and_are_at_their_minimum() {
    let server = Server::start().await;
    let mut random = Random(11);
    let [mut solved, mut refused, mut unclear] = [0; 3];
    for round in 0..ROUNDS {
        let degree = random.from(1, 5);
        let control_points = random.from(degree + 1, degree + 8);
        let count = control_points + random.from(1, 40);
        let t: Vec<f64> = (0..count).map(|i| i as f64 / (count - 1) as f64).collect();
        let points: Vec<Vec<f64>> = t
            .iter()
            .map(|t| {
                vec![
                    3.0 * t + 0.2 * random.part(),
                    (5.0 * t).sin() + 0.2 * random.part(),
                ]
            })
            .collect();
        let asked: Vec<Asked> = (0..random.from(0, control_points + 2))
            .map(|_| Asked::generate(&mut random, (&t, degree)))
            .collect();
        let free = random.chance(0.4);
        let job = json!({
            "curve": {"points": points, "parameters": t, "degree": degree},
            "method": {
                "kind": "least_squares", "control_points": control_points, "variant": "direct",
                "end_points": if free { "free" } else { "interpolated" },
                "constraints": asked.iter().map(Asked::written).collect::<Value>(),
            },
            "stop": {"tolerance": 0, "max_iterations": 1},
        });
        let mut plain = job.clone();
        plain["method"]["constraints"] = json!([]);
        let plain = server.fit(&plain).await;
        let plain = server.json(&format!("{}/result", base(&plain))).await;
        let line = Line {
            degree,
            knots: numbers(&plain["knots"]),
            free: control_points,
            parameters: t,
        };
        let end = |i: usize| Condition {
            row: line.values(line.parameters[i], 0),
            value: points[i].clone(),
            is_tangent: false,
        };
        let mut conditions = if free {
            vec![]
        } else {
            vec![end(0), end(count - 1)]
        };
        conditions.extend(asked.iter().map(|it| it.condition(&line, &points)));
        conditions.sort_by_key(|it| it.is_tangent);
        let Some(kept) = independent(&conditions) else {
            unclear += 1;
            continue;
        };
        let request = server.post("/v1/jobs").header("prefer", "wait=60");
        let answer = request.json(&job).send().await.unwrap();
        let status = answer.status().as_u16();
        assert_eq!(
            status,
            if kept.is_err() { 422 } else { 201 },
            "{round}: {job}"
        );
        let answer: Value = answer.json().await.unwrap();
        let Ok(kept) = kept else {
            let pointer = answer["errors"][0]["pointer"].as_str().unwrap();
            assert!(
                pointer.starts_with("/method/constraints/"),
                "{round}: {answer}"
            );
            refused += 1;
            continue;
        };
        let result = server.json(&format!("{}/result", base(&answer))).await;
        let net = &result["control_points"];
        let x = DMatrix::from_fn(control_points, 2, |k, c| net[k][c].as_f64().unwrap());
        let [off, minimum] = faults(&line, &points, &kept, &x);
        assert!(off < 1e-10, "{round}: {off:e}: {job}");
        // Steps are solved for with `C N⁻¹ Cᵀ`, where rounding is multiplied with the square of the condition of C.
        let rounding = f64::EPSILON * squared_condition(&kept);
        assert!(minimum < rounding.max(1e-9), "{round}: {minimum:e}: {job}");
        solved += 1;
    }
    assert!(
        solved > 300 && refused > 300 && unclear < 30,
        "{solved} {refused} {unclear}"
    );
}
