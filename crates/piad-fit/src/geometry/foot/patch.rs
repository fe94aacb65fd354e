//! A Bézier patch, and its point that is nearest to another one.
//!
//! With r = S − P the function ‖r‖²/2 has the gradient (S_s·r, S_t·r) and the Hessian
//!
//! ```text
//! S_s·S_s + r·S_ss   S_s·S_t + r·S_st
//!                    S_t·S_t + r·S_tt
//! ```
//!
//! Newton steps stay within [0, 1]²; parameters at an end that want to leave it are fixed there. Where
//! the Hessian is not positive, the second derivatives are left out (Gauss–Newton).

use super::parts::{DEEPEST, Homogeneous, Part, Parts, dot};
use crate::basis::bernstein;

/// The most steps: two or three are usual.
const STEPS: usize = 40;

/// The least part of a step that is tried.
const SHORTEST: f64 = 1e-7;

/// Squared distances that differ by this part are equal but for rounding.
const ROUNDING: f64 = 1e-14;

/// Determinants below this part of the product of the diagonal are zero but for rounding.
const SINGULAR: f64 = 1e-13;

/// A foot point in a patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot {
    /// Its parameters in the patch, each in [0, 1].
    pub(super) at: [f64; 2],
    /// The squared distance.
    pub(super) square: f64,
}

/// The Bernstein polynomials of a degree with their first two derivatives.
#[derive(Clone, Debug)]
pub(super) struct Functions {
    degree: usize,
    lower: Vec<f64>,
    orders: [Vec<f64>; 3],
}

impl Functions {
    pub(super) fn new(degree: usize) -> Self {
        Self {
            degree,
            lower: vec![0.0; degree + 1],
            orders: [(); 3].map(|()| vec![0.0; degree + 1]),
        }
    }

    /// Evaluates them, derivatives as differences of polynomials of lower degrees (PT97 (1.9)).
    fn evaluate(&mut self, t: f64) {
        let degree = self.degree;
        for (order, values) in self.orders.iter_mut().enumerate() {
            values.fill(0.0);
            let Some(low) = degree.checked_sub(order) else {
                continue;
            };
            let lower = &mut self.lower[..=low];
            bernstein::evaluate(low, t, lower);
            values[..=low].copy_from_slice(lower);
            for q in low + 1..=degree {
                for k in (0..=q).rev() {
                    let before = if k > 0 { values[k - 1] } else { 0.0 };
                    let own = if k < q { values[k] } else { 0.0 };
                    values[k] = q as f64 * (before - own);
                }
            }
        }
    }
}

/// A point of a patch, r to it, and derivatives.
#[derive(Clone, Copy, Debug)]
struct Jet {
    /// From the given point to that of the patch.
    r: [f64; 3],
    square: f64,
    first: [[f64; 3]; 2],
    /// By s twice, by both, by t twice.
    second: [[f64; 3]; 3],
}

impl Jet {
    fn gradient(&self) -> [f64; 2] {
        self.first.map(|first| dot(first, self.r))
    }
}

/// A patch with room for its evaluation.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Bernstein polynomials in s and t.
    functions: [Functions; 2],
    /// The control net, row by row.
    pub(super) net: Vec<Homogeneous>,
    /// Sums along s, with derivatives of the orders 0, 1 and 2, for each column.
    sums: Vec<[Homogeneous; 3]>,
    /// The control nets of its parts.
    parts: Parts,
}

impl Patch {
    /// A patch of these degrees, all zeros.
    pub(super) fn new(degrees: [usize; 2]) -> Self {
        let columns = degrees[1] + 1;
        let net = vec![[0.0; 4]; (degrees[0] + 1) * columns];
        Self {
            functions: degrees.map(Functions::new),
            sums: vec![[[0.0; 4]; 3]; columns],
            parts: Parts::new(degrees),
            net,
        }
    }

    /// The nearest point, if it is not farther than a squared distance; see [`Self::search`].
    pub(super) fn nearest(&mut self, point: [f64; 3], square: f64) -> Option<Foot> {
        let mut best = Foot {
            at: [f64::NAN; 2],
            square,
        };
        let whole = self.parts.whole(&self.net);
        self.search(whole, point, &mut best);
        (!best.at[0].is_nan()).then_some(best)
    }

    /// Searches in a part of the patch: Newton's method starts from its middle, unless it has led into
    /// the part before, and then from those of its quarters that can have a point that is nearer.
    fn search(&mut self, part: Part, point: [f64; 3], best: &mut Foot) {
        if !part.has(best.at) {
            let foot = self.descend(part.middle(), point);
            let is_first = best.at[0].is_nan() && foot.square <= best.square * (1.0 + ROUNDING);
            if foot.square < best.square || is_first {
                *best = foot;
            }
        }
        if part.depth == DEEPEST {
            return;
        }
        for quarter in self.parts.quarters(&part, point) {
            if quarter.nearest < best.square * (1.0 - ROUNDING) {
                self.search(quarter, point, best);
            }
        }
    }

    /// Newton's method, from these parameters on.
    pub(super) fn descend(&mut self, mut at: [f64; 2], point: [f64; 3]) -> Foot {
        let mut jet = self.jet(at, point);
        for _ in 0..STEPS {
            let step = step(&jet, at);
            let Some((next, moved)) = self.shortened(&jet, at, step, point) else {
                break;
            };
            (at, jet) = (next, moved);
        }
        Foot {
            at,
            square: jet.square,
        }
    }

    /// The step, shortened until it leads nearer; `None` if no part of it does.
    fn shortened(
        &mut self,
        jet: &Jet,
        at: [f64; 2],
        step: [f64; 2],
        point: [f64; 3],
    ) -> Option<([f64; 2], Jet)> {
        let mut part = 1.0;
        while part > SHORTEST {
            let next = [0, 1].map(|k| (at[k] + part * step[k]).clamp(0.0, 1.0));
            if next == at {
                return None;
            }
            let moved = self.jet(next, point);
            if moved.square < jet.square * (1.0 - ROUNDING) || settles((jet, at), (&moved, next)) {
                return Some((next, moved));
            }
            part *= 0.3;
        }
        None
    }

    /// The point at parameters with its derivatives, seen from another one.
    fn jet(&mut self, at: [f64; 2], point: [f64; 3]) -> Jet {
        self.along(at[0]);
        self.across(at[1], point)
    }

    /// Sums along s.
    fn along(&mut self, s: f64) {
        let [functions, _] = &mut self.functions;
        functions.evaluate(s);
        let columns = self.sums.len();
        for (j, sums) in self.sums.iter_mut().enumerate() {
            *sums = [[0.0; 4]; 3];
            for (i, row) in self.net.chunks_exact(columns).enumerate() {
                for (sum, values) in sums.iter_mut().zip(&functions.orders) {
                    add(sum, values[i], &row[j]);
                }
            }
        }
    }

    /// The rest, along t.
    fn across(&mut self, t: f64, point: [f64; 3]) -> Jet {
        let [_, functions] = &mut self.functions;
        functions.evaluate(t);
        let sum = |order: usize, across: usize| {
            let mut sum = [0.0; 4];
            for (sums, value) in self.sums.iter().zip(&functions.orders[across]) {
                add(&mut sum, *value, &sums[order]);
            }
            sum
        };
        let value = sum(0, 0);
        let weight = value[3];
        let place = [0, 1, 2].map(|c| value[c] / weight);
        // S' = (A' − w' S) / w and so on (PT97 (4.20)).
        let rest = |a: Homogeneous, parts: &[(f64, [f64; 3])]| {
            let known = |c: usize| parts.iter().map(|(w, s)| w * s[c]).sum::<f64>();
            [0, 1, 2].map(|c| (a[c] - known(c)) / weight)
        };
        let (by_s, by_t) = (sum(1, 0), sum(0, 1));
        let first = [by_s, by_t].map(|a| rest(a, &[(a[3], place)]));
        let (ss, st, tt) = (sum(2, 0), sum(1, 1), sum(0, 2));
        let second = [
            rest(ss, &[(2.0 * by_s[3], first[0]), (ss[3], place)]),
            rest(
                st,
                &[(by_s[3], first[1]), (by_t[3], first[0]), (st[3], place)],
            ),
            rest(tt, &[(2.0 * by_t[3], first[1]), (tt[3], place)]),
        ];
        let r = [0, 1, 2].map(|c| place[c] - point[c]);
        Jet {
            r,
            square: dot(r, r),
            first,
            second,
        }
    }
}

/// Returns true if a step changes nothing of the distance but rounding, and halves the gradient of the parameters that
/// can move.
fn settles(before: (&Jet, [f64; 2]), after: (&Jet, [f64; 2])) -> bool {
    let steepness = |(jet, at): (&Jet, [f64; 2])| {
        let (gradient, free) = (jet.gradient(), free(jet, at));
        let part = |k: usize| if free[k] { gradient[k].abs() } else { 0.0 };
        part(0).max(part(1))
    };
    after.0.square <= before.0.square * (1.0 + ROUNDING)
        && steepness(after) < 0.5 * steepness(before)
}

/// Which parameters can move: those at an end of [0, 1] cannot if the distance grows inwards.
fn free(jet: &Jet, at: [f64; 2]) -> [bool; 2] {
    let gradient = jet.gradient();
    [0, 1].map(|k| {
        let outwards = at[k] <= 0.0 && gradient[k] > 0.0 || at[k] >= 1.0 && gradient[k] < 0.0;
        !outwards
    })
}

/// The Newton step of the parameters that can move.
fn step(jet: &Jet, at: [f64; 2]) -> [f64; 2] {
    let (gradient, mut free) = (jet.gradient(), free(jet, at));
    let [ss, st, tt] = jet.second.map(|second| dot(second, jet.r));
    let [s, t] = jet.first;
    let gauss = [dot(s, s), dot(s, t), dot(t, t)];
    let newton = [gauss[0] + ss, gauss[1] + st, gauss[2] + tt];
    if free == [true; 2] {
        let both = solve(newton, gradient).or_else(|| solve(gauss, gradient));
        if let Some(step) = both {
            let leaves = |k: usize| at[k] <= 0.0 && step[k] < 0.0 || at[k] >= 1.0 && step[k] > 0.0;
            match [leaves(0), leaves(1)] {
                [false, false] => return step,
                leaving => free = leaving.map(|leaves| !leaves),
            }
        }
    }
    // One after the other.
    [0, 1].map(|k| {
        let place = 2 * k;
        let curvature = match newton[place] > SINGULAR * gauss[place] {
            true => newton[place],
            false => gauss[place],
        };
        match free[k] && curvature > 0.0 {
            true => -gradient[k] / curvature,
            false => 0.0,
        }
    })
}

/// The step of a positive definite matrix with the entries (0, 0), (0, 1) and (1, 1).
fn solve([a, b, c]: [f64; 3], gradient: [f64; 2]) -> Option<[f64; 2]> {
    let determinant = a * c - b * b;
    let positive = a > 0.0 && c > 0.0 && determinant > SINGULAR * a * c;
    positive.then(|| {
        let [g, h] = gradient;
        [(b * h - c * g) / determinant, (b * g - a * h) / determinant]
    })
}

fn add(sum: &mut Homogeneous, factor: f64, point: &Homogeneous) {
    for (sum, x) in sum.iter_mut().zip(point) {
        *sum += factor * x;
    }
}
