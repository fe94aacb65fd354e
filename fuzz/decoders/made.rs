//! Jobs and edits that are made up of bytes: each byte chooses something. Most of them are fits that can
//! be computed, which bytes read as JSON rarely are.

mod constrained;

use arbitrary::{Arbitrary, Unstructured};
use serde_json::{Map, Value, json};

/// Numbers at the edges of what is computed.
const EDGES: [f64; 10] = [
    0.0,
    -0.0,
    -1.0,
    1e-9,
    1e16,
    1e-300,
    1e300,
    5e-324,
    1e-160,
    f64::MAX,
];

/// Choices that have not been made yet. Behind the last byte everything is the first choice.
pub(super) struct Choices<'a>(Unstructured<'a>);

/// What is made so far.
struct Shape {
    rows: usize,
    /// Of a surface.
    columns: Option<usize>,
    dimension: usize,
}

impl<'a> Choices<'a> {
    pub(super) fn of(bytes: &'a [u8]) -> Self {
        Self(Unstructured::new(bytes))
    }

    fn any<T: Arbitrary<'a> + Default>(&mut self) -> T {
        self.0.arbitrary().unwrap_or_default()
    }

    fn below(&mut self, count: usize) -> usize {
        let last = count.saturating_sub(1);
        self.0.int_in_range(0..=last).unwrap_or(0)
    }

    /// Seldom, as a error ends most jobs.
    fn rarely(&mut self) -> bool {
        self.below(16) == 15
    }

    fn often(&mut self) -> bool {
        self.any()
    }

    fn one_of<T: Clone>(&mut self, values: &[T]) -> Option<T> {
        self.0.choose(values).ok().cloned()
    }

    fn number(&mut self) -> f64 {
        match self.below(32) {
            0 => self.one_of(&EDGES).unwrap_or(0.0),
            1 => Some(self.any())
                .filter(|it: &f64| it.is_finite())
                .unwrap_or(0.5),
            _ => f64::from(self.any::<i16>()) / 256.0,
        }
    }

    fn positive(&mut self) -> f64 {
        if self.rarely() {
            return self.number();
        }
        (f64::from(self.any::<u8>()) + 1.0) / 64.0
    }

    fn numbers(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| self.number()).collect()
    }

    fn positives(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| self.positive()).collect()
    }

    /// Numbers that increase.
    fn ascending(&mut self, count: usize) -> Vec<f64> {
        let steps = self.positives(count);
        let sum = |sum: &mut f64, step: f64| {
            *sum += step;
            Some(*sum)
        };
        steps.into_iter().scan(0.0, sum).collect()
    }

    /// A job.
    pub(super) fn job(&mut self) -> Value {
        let surface = self.below(3) == 2;
        let shape = Shape {
            rows: 2 + self.below(if surface { 6 } else { 15 }),
            columns: surface.then(|| 2 + self.below(6)),
            dimension: 1 + self.below(3),
        };
        let method = self.method(&shape);
        let automatic = method["control_points"] == "auto";
        let holes = surface && method["kind"] == "least_squares" && !automatic && self.often();
        let mut geometry = Map::new();
        geometry.insert("points".to_owned(), self.points(&shape, holes));
        let mut job = Map::new();
        if !automatic && self.often() {
            let (weights, fixed) = self.weights(&shape);
            geometry.insert("weights".to_owned(), weights);
            let rational = if fixed { "fixed" } else { "homogeneous" };
            job.insert("rational".to_owned(), rational.into());
        }
        for (name, value) in self.directions(&shape) {
            // They choose their knots, and have ends of their own.
            if !automatic || ["parameters", "closed"].contains(&name) {
                geometry.insert(name.to_owned(), value);
            }
        }
        let kind = if surface { "surface" } else { "curve" };
        job.insert(kind.to_owned(), geometry.into());
        job.insert("method".to_owned(), method);
        if self.often() {
            job.insert("stop".to_owned(), self.stop());
        }
        job.into()
    }

    /// An edit of the job.
    pub(super) fn edit(&mut self, job: &Value) -> Value {
        let points = &job["curve"]["points"];
        let points = if points.is_null() {
            &job["surface"]["points"]
        } else {
            points
        };
        let rows = points.as_array().map_or(2, Vec::len);
        let first = &points[0];
        let shape = Shape {
            rows,
            columns: job["surface"]
                .is_object()
                .then(|| first.as_array().map_or(2, Vec::len)),
            dimension: first.as_array().map_or(1, Vec::len).min(3),
        };
        let mut edit = Map::new();
        let count = self.below(4);
        let moves: Vec<Value> = (0..count).map(|_| self.change(&shape, points)).collect();
        if count > 0 {
            edit.insert("points".to_owned(), moves.into());
        }
        if self.below(4) == 3 {
            edit.insert("weights".to_owned(), self.weights(&shape).0);
        }
        if self.below(3) == 2 {
            edit.insert("method".to_owned(), self.method(&shape));
        }
        if self.below(3) == 2 || edit.is_empty() {
            edit.insert("stop".to_owned(), self.stop());
        }
        edit.into()
    }

    fn change(&mut self, shape: &Shape, points: &Value) -> Value {
        let (index, place) = self.index(shape, points);
        let dimension = place.as_array().map_or(shape.dimension, Vec::len);
        let mut change = json!({"index": index, "point": self.numbers(dimension)});
        if self.below(4) == 3 {
            change["weight"] = json!(self.positive());
        }
        change
    }

    /// An index, and the point there.
    fn index(&mut self, shape: &Shape, points: &Value) -> (Value, Value) {
        let row = self.below(shape.rows);
        match shape.columns {
            None => (json!(row), points[row].clone()),
            Some(columns) => {
                let column = self.below(columns);
                (json!([row, column]), points[row][column].clone())
            }
        }
    }

    fn points(&mut self, shape: &Shape, holes: bool) -> Value {
        let mut point = || {
            if holes && self.below(6) == 5 {
                return Value::Null;
            }
            json!(self.numbers(shape.dimension))
        };
        match shape.columns {
            None => (0..shape.rows).map(|_| point()).collect(),
            Some(columns) => {
                let mut row = || (0..columns).map(|_| point()).collect::<Value>();
                (0..shape.rows).map(|_| row()).collect()
            }
        }
    }

    /// Weights, and whether they are fixed.
    fn weights(&mut self, shape: &Shape) -> (Value, bool) {
        let fixed = self.often();
        let Some(columns) = shape.columns else {
            // Fixed weights may be those of the control points with their end copies.
            let more = if fixed { 2 * self.below(2) } else { 0 };
            return (json!(self.positives(shape.rows + more)), fixed);
        };
        let (u, v) = (self.positives(shape.rows), self.positives(columns));
        if self.often() {
            return (json!({"u": u, "v": v}), fixed);
        }
        let product = |u: &f64| v.iter().map(|v| u * v).collect::<Value>();
        (u.iter().map(product).collect(), fixed)
    }

    /// Bases, parameters and whether they are closed: of one direction, or of two.
    fn directions(&mut self, shape: &Shape) -> Vec<(&'static str, Value)> {
        let boundary = |count: Option<usize>| (count, shape.dimension);
        let u = self.direction(shape.rows, boundary(shape.columns));
        let Some(columns) = shape.columns else {
            return u;
        };
        let v = self.direction(columns, boundary(Some(shape.rows)));
        let pairs = u.into_iter().zip(v);
        pairs
            .map(|((name, u), (_, v))| (name, json!({"u": u, "v": v})))
            .collect()
    }

    fn direction(
        &mut self,
        count: usize,
        boundary: (Option<usize>, usize),
    ) -> Vec<(&'static str, Value)> {
        let closed = self.below(4) == 3;
        let basis = match self.below(6) {
            0..=3 => {
                let degree = 1 + self.below(4);
                let mut basis = json!({"kind": "bspline", "degree": degree});
                match self.below(4) {
                    1 => basis["knots"] = json!("data"),
                    2 if !closed => basis["knots"] = json!("averaged"),
                    3 if !closed => basis["knots"] = json!(self.knots(count, degree)),
                    _ => {}
                }
                basis
            }
            4 => json!("bernstein"),
            _ => json!(self.one_of(&["said_ball", "wang_ball"])),
        };
        let parameters = match self.below(5) {
            0 => json!("uniform"),
            1 => json!("centripetal"),
            2 => json!("chord_length"),
            _ => json!(self.ascending(count + usize::from(closed))),
        };
        vec![
            ("basis", basis),
            ("parameters", parameters),
            ("closed", json!(closed)),
            ("ends", self.ends(boundary)),
        ]
    }

    /// How a direction ends; of a surface with a vector for each data point of the boundary.
    fn ends(&mut self, boundary: (Option<usize>, usize)) -> Value {
        match self.below(32) {
            0 => json!("repeated"),
            1 => json!("natural"),
            2 => json!("estimated"),
            3 => json!({"start": self.end(boundary)}),
            4 => json!({"start": self.end(boundary), "end": self.end(boundary)}),
            _ => Value::Null,
        }
    }

    fn end(&mut self, (boundary, dimension): (Option<usize>, usize)) -> Value {
        let mut one = || match boundary {
            None => json!(self.numbers(dimension)),
            Some(count) => (0..count).map(|_| json!(self.numbers(dimension))).collect(),
        };
        let vectors = [one(), one()];
        match self.below(5) {
            0 => json!("natural"),
            1 => json!({"derivative": vectors[0]}),
            2 => json!({"derivatives": vectors}),
            3 => json!({"tangent": vectors[0]}),
            _ => json!("repeated"),
        }
    }

    /// Clamped knots.
    fn knots(&mut self, count: usize, degree: usize) -> Vec<f64> {
        let inner = count.saturating_sub(degree + 1);
        let mut knots = vec![0.0; degree + 1];
        knots.extend(self.ascending(inner));
        let last = knots.last().copied().unwrap_or(0.0) + self.positive();
        knots.extend(vec![last; degree + 1]);
        knots
    }

    fn method(&mut self, shape: &Shape) -> Value {
        const PLAIN: [&str; 6] = [
            "global",
            "transpose",
            "convex",
            "chebyshev",
            "direct",
            "extended",
        ];
        match self.below(13) {
            0..=5 => json!({"kind": self.one_of(&PLAIN)}),
            6 if self.often() => json!({"kind": "convex", "step_tolerance": 0.5}),
            6 => json!({"kind": "extended", "start": "data", "transformed_error": self.often()}),
            7 if self.often() => json!({"kind": "weighted", "omega": "auto"}),
            7 => json!({"kind": "weighted", "omega": self.positive()}),
            8 => {
                let mut indices = vec![self.index(shape, &Value::Null).0];
                let other = self.index(shape, &Value::Null).0;
                if !indices.contains(&other) {
                    indices.push(other);
                }
                let surface = shape.columns.is_some();
                let mut method = json!({"kind": "local", "indices": indices});
                if surface && self.often() {
                    method["sweeps"] = json!(self.one_of(&["rows", "columns"]));
                }
                match self.below(3) {
                    0 => {}
                    1 => method["omega"] = json!("auto"),
                    _ => method["omega"] = json!(self.positive()),
                }
                method
            }
            9 if self.often() => json!({"kind": "adaptive", "threshold": self.positive()}),
            9 if self.often() => {
                json!({"kind": "adaptive", "threshold": self.positive(), "omega": self.positive()})
            }
            9 => {
                let mut line = |count| (0..count).map(|_| self.positive()).collect::<Vec<_>>();
                let each = match shape.columns {
                    None => json!(line(shape.rows)),
                    Some(columns) => (0..shape.rows).map(|_| json!(line(columns))).collect(),
                };
                json!({"kind": "adaptive", "threshold": each})
            }
            10 => {
                let u = self.matrix(shape.rows);
                match shape.columns {
                    None => json!({"kind": "custom", "transform": u}),
                    Some(columns) => {
                        let v = self.matrix(columns);
                        json!({"kind": "custom", "transform": {"u": u, "v": v}})
                    }
                }
            }
            _ => self.least_squares(shape),
        }
    }

    /// A matrix near that which changes nothing.
    fn matrix(&mut self, count: usize) -> Vec<Vec<f64>> {
        let mut rows = vec![vec![0.0; count]; count];
        for (k, row) in rows.iter_mut().enumerate() {
            row[k] = 1.0;
            if self.below(4) == 3 {
                row[self.below(count)] = self.number();
            }
        }
        rows
    }

    fn stop(&mut self) -> Value {
        let name = if self.often() {
            "tolerance"
        } else {
            "relative_tolerance"
        };
        json!({name: self.number().abs(), "max_iterations": self.below(8)})
    }
}
