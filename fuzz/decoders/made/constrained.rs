//! Least squares, with what it obeys and weighs.

use serde_json::{Value, json};

use super::{Choices, Shape};

impl Choices<'_> {
    pub(super) fn least_squares(&mut self, shape: &Shape) -> Value {
        let u = 2 + self.below(shape.rows - 1);
        let v = shape.columns.map(|columns| 2 + self.below(columns - 1));
        let counts = v.map_or(json!(u), |v| json!({"u": u, "v": v}));
        let mut method = json!({"kind": "least_squares", "control_points": counts.clone()});
        let variant = if self.below(6) == 0 {
            method["control_points"] = json!("auto");
            if self.below(2) == 0 {
                method["max_control_points"] = counts;
            }
            if self.below(3) == 0 {
                method["correct_parameters"] = json!(true);
            }
            0
        } else {
            self.below(5)
        };
        match variant {
            0 => {}
            1 => method["variant"] = json!("cg"),
            2 => method["variant"] = json!("lspia"),
            3 => method["variant"] = json!("direct"),
            _ => {
                method["variant"] = json!("lspia");
                method["mu"] = json!(self.positive());
            }
        }
        match self.below(4) {
            0 => method["end_points"] = json!("free"),
            1 => method["end_points"] = json!("interpolated"),
            _ => {}
        }
        if self.below(4) == 3 {
            method["data_weights"] = match shape.columns {
                None => json!(self.positives(shape.rows)),
                Some(columns) => (0..shape.rows)
                    .map(|_| json!(self.positives(columns)))
                    .collect(),
            };
        }
        if self.below(4) == 3 {
            method["fairness"] = json!(self.positive());
            method["fairness_order"] = json!(2 + self.below(2));
        }
        let count = self.below(6).saturating_sub(2);
        if count > 0 {
            let constraints = (0..count).map(|_| self.constraint(shape, (u, v)));
            method["constraints"] = constraints.collect();
        }
        method
    }

    fn constraint(&mut self, shape: &Shape, (u, v): (usize, Option<usize>)) -> Value {
        const OF_CURVES: [&str; 4] = ["point", "derivative", "second_derivative", "tangent"];
        const OF_SURFACES: [&str; 6] = [
            "point",
            "derivative_u",
            "derivative_v",
            "derivative_uu",
            "derivative_uv",
            "derivative_vv",
        ];
        let index = self.index(shape, &Value::Null).0;
        let names: &[&str] = match v {
            None => &OF_CURVES,
            Some(_) => &OF_SURFACES,
        };
        let name = self.one_of(names).unwrap_or("point");
        let at = match (self.below(5), v) {
            (0, _) => return json!({"index": index}),
            (1, None) => json!(self.one_of(&["start", "end"])),
            (1, Some(v)) => return self.across(shape, (u, v)),
            (2, None) => json!({"parameter": self.positive()}),
            (2, Some(_)) => json!({"parameter": [self.positive(), self.positive()]}),
            _ => json!({"index": index}),
        };
        json!({"at": at, name: self.numbers(shape.dimension)})
    }

    /// Along a boundary, with the number of control points that it has.
    fn across(&mut self, shape: &Shape, (u, v): (usize, usize)) -> Value {
        let sides = [("u_start", v), ("u_end", v), ("v_start", u), ("v_end", u)];
        let (side, count) = self.one_of(&sides).unwrap_or(("u_start", v));
        let names = ["control_points", "cross_derivatives"];
        let name = self.one_of(&names).unwrap_or("control_points");
        let vectors = (0..count).map(|_| json!(self.numbers(shape.dimension)));
        let vectors: Value = vectors.collect();
        json!({"at": {"boundary": side}, name: vectors})
    }
}
