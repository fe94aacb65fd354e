//! Constrained surfaces against dense solutions of their KKT systems, a thousand generated ones.
//!
//! ```text
//! N = AᵀΩA + w H,   [N Cᵀ; C 0] [X; Λ] = [AᵀΩP; R]
//! ```
//!
//! Bases, energies and constraints are evaluated here by their definitions, and the system is solved
//! densely. A job is refused if and only if a constraint contradicts corners or constraints before it.

use nalgebra::{DMatrix, DVector};
use serde_json::{Value, json};

use crate::numbers::numbers;
use crate::random::Random;
use crate::support::{Server, base};

/// How many surfaces are generated.
const ROUNDS: u64 = 1000;

/// A row of C depends on others if it is nearer to their span than this, and does not if it is further away
/// than the second number; what is between is left out.
const DEPENDENT: [f64; 2] = [1e-7, 1e-5];

/// A generated job, and what the dense solution needs of it.
struct Case {
    job: Value,
    rows: usize,
    columns: usize,
    /// The numbers of free control points.
    counts: [usize; 2],
    degrees: [usize; 2],
    closed: bool,
    points: Vec<Vec<f64>>,
    weights: Vec<f64>,
    fairness: f64,
    free_ends: bool,
    constraints: Vec<Asked>,
}

/// A constraint.
enum Asked {
    /// A derivative at a data point or at parameters.
    At(At, [usize; 2], Vec<f64>),
    /// Along a boundary: of v or of u, at its end or start, of this order.
    Along {
        of_v: bool,
        at_end: bool,
        order: usize,
        net: Vec<Vec<f64>>,
        /// How many of the first ones are repeated at the end, along a closed direction.
        copies: usize,
    },
}

#[derive(Clone, Copy)]
enum At {
    Index(usize, usize),
    Parameters(f64, f64),
}

fn generate(random: &mut Random) -> Case {
    let degrees = [random.from(1, 4), random.from(1, 4)];
    let closed = random.chance(0.2);
    let counts = degrees.map(|degree| random.from(degree + 1, degree + 5));
    let size = |random: &mut Random, count: usize| random.from(count + 1, 2 * count + 4);
    let (rows, columns) = (size(random, counts[0]), size(random, counts[1]));
    let points = (0..rows * columns).map(|k| {
        let (i, j) = ((k / columns) as f64, (k % columns) as f64);
        let around = std::f64::consts::TAU * i / rows as f64;
        let base = match closed {
            true => [2.0 * around.cos(), 2.0 * around.sin(), j],
            false => [i, j, (0.5 * i + 0.3 * j).sin()],
        };
        base.map(|x| x + 0.3 * (random.part() - 0.5)).to_vec()
    });
    let points: Vec<Vec<f64>> = points.collect();
    let weighted = random.chance(0.3);
    let weights = points.iter().map(|_| match weighted {
        true => 10f64.powf(2.0 * random.part() - 1.0),
        false => 1.0,
    });
    let weights: Vec<f64> = weights.collect();
    let fair = degrees.iter().all(|&degree| degree > 1) && random.chance(0.3);
    let fairness = if fair {
        10f64.powf(-4.0 - 4.0 * random.part())
    } else {
        0.0
    };
    let free_ends = random.chance(0.3);
    let uniform = random.chance(0.6);
    let constraints: Vec<Asked> = (0..random.from(0, 5))
        .map(|_| constraint(random, (rows, columns), counts, degrees, (closed, uniform)))
        .collect();
    let variant = if random.chance(0.6) { "direct" } else { "cg" };
    let mut method = json!({
        "kind": "least_squares", "variant": variant, "control_points": {"u": counts[0], "v": counts[1]},
        "constraints": constraints.iter().map(written).collect::<Value>(),
    });
    let grid = |list: &[Value]| -> Value { list.chunks(columns).map(|row| json!(row)).collect() };
    if weighted {
        method["data_weights"] = grid(&weights.iter().map(|x| json!(x)).collect::<Vec<_>>());
    }
    if fair {
        method["fairness"] = json!(fairness);
    }
    if free_ends {
        method["end_points"] = json!("free");
    }
    let basis = degrees.map(|degree| json!({"kind": "bspline", "degree": degree}));
    let job = json!({
        "surface": {
            "points": grid(&points.iter().map(|point| json!(point)).collect::<Vec<_>>()),
            "basis": {"u": basis[0], "v": basis[1]}, "closed": {"u": closed, "v": false},
            "parameters": if uniform { "uniform" } else { "chord_length" },
        },
        "method": method, "stop": {"max_iterations": 20_000},
    });
    Case {
        job,
        rows,
        columns,
        counts,
        degrees,
        closed,
        points,
        weights,
        fairness,
        free_ends,
        constraints,
    }
}

fn constraint(
    random: &mut Random,
    (rows, columns): (usize, usize),
    counts: [usize; 2],
    degrees: [usize; 2],
    (closed, uniform): (bool, bool),
) -> Asked {
    if random.chance(0.15) {
        let of_v = closed || random.chance(0.5);
        let along = counts[usize::from(!of_v)];
        return Asked::Along {
            of_v,
            at_end: random.chance(0.5),
            order: random.from(0, 1),
            net: (0..along).map(|_| random.vector()).collect(),
            copies: if closed && random.chance(0.5) {
                degrees[0]
            } else {
                0
            },
        };
    }
    // Where the parameters are known; the range of closed directions of even degree begins before the data.
    let at = match uniform && random.chance(0.5) {
        true => At::Parameters(
            if closed { 0.8 } else { 1.0 } * random.part(),
            random.part(),
        ),
        false => At::Index(random.from(0, rows - 1), random.from(0, columns - 1)),
    };
    // Derivatives are continuous.
    let orders = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]][random.from(0, 5)];
    let smooth = (0..2).all(|axis| orders[axis] == 0 || orders[axis] < degrees[axis]);
    let orders = if smooth { orders } else { [0, 0] };
    Asked::At(at, orders, random.vector())
}

/// A constraint as JSON.
fn written(asked: &Asked) -> Value {
    match asked {
        Asked::At(at, orders, vector) => {
            let at = match at {
                At::Index(i, j) => json!({"index": [i, j]}),
                At::Parameters(u, v) => json!({"parameter": [u, v]}),
            };
            let name = match orders {
                [0, 0] => "point",
                [1, 0] => "derivative_u",
                [0, 1] => "derivative_v",
                [2, 0] => "derivative_uu",
                [1, 1] => "derivative_uv",
                _ => "derivative_vv",
            };
            json!({"at": at, name: vector})
        }
        Asked::Along {
            of_v,
            at_end,
            order,
            net,
            copies,
        } => {
            let side = format!(
                "{}_{}",
                if *of_v { "v" } else { "u" },
                if *at_end { "end" } else { "start" }
            );
            let name = ["control_points", "cross_derivatives"][*order];
            let net: Vec<_> = net.iter().chain(&net[..*copies]).collect();
            json!({"at": {"boundary": side}, name: net})
        }
    }
}

/// A direction: its knots, and the parameters of the data.
pub struct Line {
    pub degree: usize,
    pub knots: Vec<f64>,
    pub free: usize,
    pub parameters: Vec<f64>,
}

impl Line {
    fn domain(&self) -> (f64, f64) {
        let functions = self.knots.len() - self.degree - 1;
        (self.knots[self.degree], self.knots[functions])
    }

    /// A derivative of all functions at a parameter, added up for those that share a control point.
    pub fn values(&self, t: f64, order: usize) -> DVector<f64> {
        let functions = self.knots.len() - self.degree - 1;
        let spans = (self.degree..functions).rev();
        let mut spans = spans.filter(|&k| self.knots[k] < self.knots[k + 1]);
        let span = spans.find(|&k| self.knots[k] <= t).unwrap_or(self.degree);
        let mut values = DVector::zeros(self.free);
        for i in 0..functions {
            values[i % self.free] += self.value(i, self.degree, (t, span), order);
        }
        values
    }

    /// Cox and de Boor.
    fn value(&self, i: usize, degree: usize, (t, span): (f64, usize), order: usize) -> f64 {
        let k = &self.knots;
        if degree == 0 {
            return f64::from(u8::from(i == span && order == 0));
        }
        let part = |i: usize, numerator: f64, order: usize| {
            let length = k[i + degree] - k[i];
            if length > 0.0 {
                numerator / length * self.value(i, degree - 1, (t, span), order)
            } else {
                0.0
            }
        };
        match order {
            0 => part(i, t - k[i], 0) + part(i + 1, k[i + degree + 1] - t, 0),
            _ => {
                let degree = degree as f64;
                part(i, degree, order - 1) - part(i + 1, degree, order - 1)
            }
        }
    }

    /// The integrals of products of derivatives, by Gauss quadrature with five nodes.
    fn energy(&self, order: usize) -> DMatrix<f64> {
        let nodes = [
            (0.0, 0.568_888_888_888_888_9),
            (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (0.906_179_845_938_664, 0.236_926_885_056_189_08),
            (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
        ];
        let mut energy = DMatrix::zeros(self.free, self.free);
        let functions = self.knots.len() - self.degree - 1;
        for k in self.degree..functions {
            let (low, high) = (self.knots[k], self.knots[k + 1]);
            for (node, weight) in nodes {
                let t = 0.5 * (low + high) + 0.5 * (high - low) * node;
                let values = self.values(t, order);
                energy += 0.5 * (high - low) * weight * &values * values.transpose();
            }
        }
        energy
    }
}

/// The matrices of a case.
struct Dense {
    a: DMatrix<f64>,
    n: DMatrix<f64>,
    data: DMatrix<f64>,
    /// The rows of C and of R, those of corners first.
    rows: Vec<(DVector<f64>, Vec<f64>)>,
}

fn kron(u: &DVector<f64>, v: &DVector<f64>) -> DVector<f64> {
    u.kronecker(v)
}

fn dense(case: &Case, [u, v]: &[Line; 2]) -> Dense {
    let count = case.points.len();
    let [nu, nv] = case.counts;
    let place = |k: usize| {
        [
            u.parameters[k / case.columns],
            v.parameters[k % case.columns],
        ]
    };
    let row = |[s, t]: [f64; 2], orders: [usize; 2]| {
        kron(&u.values(s, orders[0]), &v.values(t, orders[1]))
    };
    let mut a = DMatrix::zeros(count, nu * nv);
    for k in 0..count {
        a.set_row(k, &row(place(k), [0, 0]).transpose());
    }
    let data = DMatrix::from_fn(count, 3, |k, c| case.points[k][c]);
    let omega = DMatrix::from_diagonal(&DVector::from_column_slice(&case.weights));
    let mut n = a.transpose() * omega * &a;
    if case.fairness > 0.0 {
        let length = |line: &Line| line.domain().1 - line.domain().0;
        let weight =
            case.fairness * case.weights.iter().sum::<f64>() * length(u).max(length(v)).powi(2);
        for (k, times) in [(0, 1.0), (1, 2.0), (2, 1.0)] {
            n += weight * times * u.energy(2 - k).kronecker(&v.energy(k));
        }
    }
    let corners = || {
        [0, case.rows - 1]
            .into_iter()
            .flat_map(|i| [(i, 0), (i, case.columns - 1)])
    };
    let mut rows = Vec::new();
    for (i, j) in corners().filter(|_| !case.free_ends && !case.closed) {
        let k = i * case.columns + j;
        if !case
            .constraints
            .iter()
            .any(|asked| replaces(asked, case, (i, j), place(k)))
        {
            rows.push((row(place(k), [0, 0]), case.points[k].clone()));
        }
    }
    for asked in &case.constraints {
        match asked {
            Asked::At(at, orders, vector) => {
                let at = match at {
                    At::Index(i, j) => [u.parameters[*i], v.parameters[*j]],
                    At::Parameters(s, t) => [*s, *t],
                };
                rows.push((row(at, *orders), vector.clone()));
            }
            Asked::Along {
                of_v,
                at_end,
                order,
                net,
                ..
            } => {
                let across = if *of_v { v } else { u };
                let (low, high) = across.domain();
                let across = across.values(if *at_end { high } else { low }, *order);
                for (k, point) in net.iter().enumerate() {
                    let mut along = DVector::zeros(net.len());
                    along[k] = 1.0;
                    let row = if *of_v {
                        kron(&along, &across)
                    } else {
                        kron(&across, &along)
                    };
                    rows.push((row, point.clone()));
                }
            }
        }
    }
    Dense { a, n, data, rows }
}

/// Returns true if a constraint gives the point at a corner, which has these parameters.
fn replaces(asked: &Asked, case: &Case, (i, j): (usize, usize), [s, t]: [f64; 2]) -> bool {
    match asked {
        Asked::At(At::Index(row, column), [0, 0], _) => (*row, *column) == (i, j),
        Asked::At(At::Parameters(u, v), [0, 0], _) => (*u, *v) == (s, t),
        Asked::At(..) => false,
        Asked::Along { order: 1.., .. } => false,
        Asked::Along { of_v, at_end, .. } => {
            let (place, last) = match of_v {
                true => (j, case.columns - 1),
                false => (i, case.rows - 1),
            };
            place == if *at_end { last } else { 0 }
        }
    }
}

/// What a row is beside those before it.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Independent,
    Follows,
    Contradicts,
}

/// Compares the value of a row with the same sum of those before it; `None` if that is not clear.
fn kind(row: &DVector<f64>, value: &[f64], kept: &[&(DVector<f64>, Vec<f64>)]) -> Option<Kind> {
    if kept.is_empty() {
        return Some(Kind::Contradicts);
    }
    let columns: Vec<DVector<f64>> = kept.iter().map(|(row, _)| row.clone()).collect();
    let factors = DMatrix::from_columns(&columns)
        .svd(true, true)
        .solve(row, 0.0)
        .unwrap();
    let off = value.iter().enumerate().map(|(c, value)| {
        let sum: f64 = kept
            .iter()
            .zip(factors.iter())
            .map(|((_, x), f)| f * x[c])
            .sum();
        (value - sum).abs()
    });
    match off.fold(0.0, f64::max) {
        off if off < 1e-12 => Some(Kind::Follows),
        off if off > 1e-6 => Some(Kind::Contradicts),
        _ => None,
    }
}

/// What each row is beside those before it; `None` if that is not clear.
fn kinds(rows: &[(DVector<f64>, Vec<f64>)]) -> Option<Vec<Kind>> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut kept = Vec::new();
    let mut all = Vec::new();
    for whole in rows {
        let (row, value) = whole;
        let length = row.norm();
        let mut left = if length > 0.0 {
            row / length
        } else {
            row.clone()
        };
        for _ in 0..2 {
            for other in &basis {
                let part = left.dot(other);
                left.axpy(-part, other, 1.0);
            }
        }
        let distance = left.norm();
        match distance {
            distance if distance < DEPENDENT[0] => all.push(kind(row, value, &kept)?),
            distance if distance > DEPENDENT[1] => {
                basis.push(left / distance);
                kept.push(whole);
                all.push(Kind::Independent);
            }
            _ => return None,
        }
    }
    Some(all)
}

/// The solution of the KKT system with these rows of C.
fn solution(
    case: &Case,
    dense: &Dense,
    kept: &[&(DVector<f64>, Vec<f64>)],
) -> Option<DMatrix<f64>> {
    let (n, c) = (dense.n.nrows(), kept.len());
    let mut system = DMatrix::zeros(n + c, n + c);
    system.view_mut((0, 0), (n, n)).copy_from(&dense.n);
    let weights = DMatrix::from_diagonal(&DVector::from_column_slice(&case.weights));
    let mut right = DMatrix::zeros(n + c, 3);
    right
        .view_mut((0, 0), (n, 3))
        .copy_from(&(dense.a.transpose() * weights * &dense.data));
    for (k, (row, value)) in kept.iter().enumerate() {
        system
            .view_mut((n + k, 0), (1, n))
            .copy_from(&row.transpose());
        system.view_mut((0, n + k), (n, 1)).copy_from(row);
        (0..3).for_each(|c| right[(n + k, c)] = value[c]);
    }
    let lu = system.clone().full_piv_lu();
    let mut x = lu.solve(&right)?;
    // What rounding has left.
    let left = &right - &system * &x;
    x += lu.solve(&left)?;
    Some(x.rows(0, n).into_owned())
}

/// `Σ ω ‖P − A X‖² + w XᵀHX` with N and the data.
fn objective(case: &Case, dense: &Dense, x: &DMatrix<f64>) -> f64 {
    let residual = &dense.data - &dense.a * x;
    let squares = residual.row_iter().zip(&case.weights);
    let squares: f64 = squares
        .map(|(row, weight)| weight * row.norm_squared())
        .sum();
    let weights = DMatrix::from_diagonal(&DVector::from_column_slice(&case.weights));
    let energy = &dense.n - dense.a.transpose() * weights * &dense.a;
    let bending = (x.transpose() * energy * x).trace();
    squares + if case.fairness > 0.0 { bending } else { 0.0 }
}

/// The directions of a result or a description of the job.
fn lines(case: &Case, from: &Value) -> [Line; 2] {
    let line = |axis: usize, name: &str| Line {
        degree: case.degrees[axis],
        knots: numbers(&from["knots"][name]),
        free: case.counts[axis],
        parameters: numbers(&from["parameters"][name]),
    };
    [line(0, "u"), line(1, "v")]
}

/// The free control points of a result.
fn control_points(case: &Case, result: &Value) -> DMatrix<f64> {
    let [nu, nv] = case.counts;
    let net = &result["control_points"];
    DMatrix::from_fn(nu * nv, 3, |k, c| net[k / nv][k % nv][c].as_f64().unwrap())
}

/// The knots and the parameters, of the same job without constraints.
async fn directions(server: &Server, case: &Case) -> [Line; 2] {
    let mut plain = case.job.clone();
    plain["method"]["constraints"] = json!([]);
    plain["stop"] = json!({"max_iterations": 0});
    let plain = server.fit(&plain).await;
    lines(
        case,
        &server.json(&format!("{}/result", base(&plain))).await,
    )
}

#[derive(Default, Debug)]
struct Counts {
    solved: usize,
    refused: usize,
    unclear: usize,
    largest: f64,
}

#[tokio::test]
async fn constrained_surfaces_are_solutions_of_dense_systems() {
    let server = Server::start().await;
    let (mut random, mut counts) = (Random(7), Counts::default());
    for round in 0..ROUNDS {
        let case = generate(&mut random);
        let lines = directions(&server, &case).await;
        let dense = dense(&case, &lines);
        let Some(kinds) = kinds(&dense.rows) else {
            counts.unclear += 1;
            continue;
        };
        let request = server.post("/v1/jobs").header("prefer", "wait=60");
        let answer = request.json(&case.job).send().await.unwrap();
        let refused = kinds.contains(&Kind::Contradicts);
        assert_eq!(
            answer.status().as_u16(),
            if refused { 422 } else { 201 },
            "{round}: {}",
            case.job
        );
        let answer: Value = answer.json().await.unwrap();
        if refused {
            let pointer = answer["errors"][0]["pointer"].as_str().unwrap();
            assert!(
                pointer.starts_with("/method/constraints/"),
                "{round}: {answer}"
            );
            counts.refused += 1;
            continue;
        }
        let rows = dense.rows.iter().zip(&kinds);
        let rows = rows.filter(|(_, kind)| **kind == Kind::Independent);
        let rows: Vec<_> = rows.map(|(row, _)| row).collect();
        let Some(expected) = solution(&case, &dense, &rows) else {
            counts.unclear += 1;
            continue;
        };
        let result = server.json(&format!("{}/result", base(&answer))).await;
        let found = control_points(&case, &result);
        let size = found.amax().max(expected.amax());
        for (row, value) in &rows {
            for (c, value) in value.iter().enumerate() {
                let left = (row.dot(&found.column(c)) - value).abs();
                assert!(
                    left <= 1e-9 * size * row.norm(),
                    "{round}: {left} of {size}: {}",
                    case.job
                );
            }
        }
        let [least, reached] = [&expected, &found].map(|x| objective(&case, &dense, x));
        let above = reached / least - 1.0;
        let direct = case.job["method"]["variant"] == "direct";
        let most = if direct { 1e-8 } else { 2e-6 };
        assert!(
            above < most && above > -1e-8,
            "{round}: {above} {answer:#}: {}",
            case.job
        );
        if direct {
            let apart = (&dense.a * (&found - &expected)).amax() / size;
            assert!(apart < 1e-6, "{round}: {apart}: {}", case.job);
            counts.largest = counts.largest.max(apart);
        }
        counts.solved += 1;
    }
    // 930, 70, none, and 1e-13 of their size.
    assert!(
        counts.solved > 900 && counts.refused > 60 && counts.unclear < 10,
        "{counts:?}"
    );
    assert!(counts.largest < 1e-10, "{counts:?}");
}
