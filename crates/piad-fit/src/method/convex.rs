//! Planar curves whose control polygons keep the turns of the data.
//!
//! ```text
//! X⁰ = P,   X ← X + ε_k (P − B X),   U = ε_k I,   0 < ε_k ≤ 1
//! ```
//!
//! (LWD04, Algorithm 1). A plain step, ε = 1, is taken if the turning angles of the control polygon
//! keep their signs; else bisection finds the longest step that keeps them, but for a tolerance: the
//! search ends where the step that keeps them and the one that does not differ by no more than this
//! part of the plain step.
//! The signs of data that are no convex polygon are kept as they are. Where the control polygon of
//! the interpolant turns otherwise, steps become shorter and shorter, and the fit stalls with a
//! positive error. A level costs one application of B, and O(n) for each bisection.

use super::algorithm::{Algorithm, Demand, Scope};
use super::equations::Equations;
use super::update::{Change, State, Update};
use crate::data::points::{Points, normalizing_scale};
use crate::invalid::{Invalid, Place, Setting, Side};
use crate::kind_info::KindInfo;
use crate::setup::Setup;
use crate::termination::Reason;

/// The entry in the table of methods.
pub(super) const INFO: KindInfo = KindInfo {
    name: "convex",
    title: "Convexity-preserving PIA",
    summary: "Steps are as long as the control polygon of a planar curve keeps the turns of the data.",
    source: "LWD04, Algorithm 1",
};

/// Most halvings of each search; taken literally, both could run forever in floating point.
const HALVINGS: usize = 60;

/// A step that moves the polygon by less than this part of the plain step is no progress.
const PROGRESS: f64 = 1e-9;

/// Steps without progress after which the fit has stalled.
const PATIENCE: usize = 3;

/// Convexity-preserving PIA with its tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Convex {
    /// How near to the turning point the bisection goes, as a part of the plain step, between 0 and
    /// 1 (LWD04, Algorithm 1).
    pub step_tolerance: f64,
}

impl Default for Convex {
    /// A millionth of the step.
    fn default() -> Self {
        Self {
            step_tolerance: 1e-6,
        }
    }
}

impl Algorithm for Convex {
    fn info(&self) -> &'static KindInfo {
        &INFO
    }

    /// Turning angles are those of planar polygons. A tolerance of 0 would take bisection to its
    /// limit at every level, and with 1 it would not begin.
    fn check(&self, scope: &Scope<'_>) -> Result<(), Invalid> {
        let value = self.step_tolerance;
        if !(value > 0.0 && value < 1.0) {
            return Err(Invalid::at(
                Place::Setting(Setting::StepTolerance),
                format!(
                    "step_tolerance is {value}; it is a part of a step, greater than 0 and less than 1"
                ),
            ));
        }
        let found = if scope.is_surface {
            "this is a surface"
        } else if scope.dimension != 2 {
            "the points do not have two coordinates"
        } else if scope.is_homogeneous {
            "the weights are homogeneous"
        } else {
            return Ok(());
        };
        Err(Invalid::at(
            Place::Method,
            format!(
                "{method} fits only planar curves (two coordinates, not homogeneous): {found}",
                method = INFO.name
            ),
        ))
    }

    /// The polygon before the step and the step; nothing is factorized.
    fn demand(&self) -> Demand {
        Demand {
            vectors: 1,
            matrices: 1,
            bytes: 0,
        }
    }

    fn update(&self, equations: &Equations) -> Box<dyn Update> {
        Box::new(Steps::new(&equations.setup, self.step_tolerance))
    }

    /// When no step keeps the turns any more.
    fn ends_by_itself(&self) -> bool {
        true
    }
}

/// Plain steps where they keep the turns, else the largest fraction of a step that does.
#[derive(Clone, Debug)]
struct Steps {
    /// How near to the turning point the search goes, in steps.
    step_tolerance: f64,
    /// True if the polygon turns at its ends, too.
    closed: bool,
    /// The constants of control points beside the first and the last one, by which they differ from
    /// these, in the order of the polygon.
    beside: [Vec<[f64; 2]>; 2],
    /// A power of two that keeps products of lengths within the range of numbers.
    scale: f64,
    /// The polygon before the step.
    before: Points,
    /// The whole step Δ.
    step: Points,
    /// The signs of the turns of that polygon.
    turns: Vec<i8>,
    /// The number of steps in a row that were no progress.
    idle: usize,
}

impl Steps {
    /// Before the first update.
    fn new(setup: &Setup, step_tolerance: f64) -> Self {
        let data = setup.data();
        Self {
            step_tolerance,
            closed: setup.u().is_closed(),
            beside: [Side::Start, Side::End].map(|side| beside(setup, side)),
            scale: normalizing_scale(setup.diagonal()),
            before: Points::zeros(data.dimension(), data.len()),
            step: Points::zeros(data.dimension(), data.len()),
            turns: Vec::with_capacity(data.len()),
            idle: 0,
        }
    }

    /// Moves the polygon to `X + ε Δ` and returns true if its turns are those of `X`.
    fn keeps_turns(&self, epsilon: f64, control_points: &mut Points) -> bool {
        for ((x, before), step) in control_points
            .lanes_mut()
            .iter_mut()
            .zip(self.before.lanes())
            .zip(self.step.lanes())
        {
            for ((x, before), step) in x.iter_mut().zip(before).zip(step) {
                *x = if epsilon == 1.0 {
                    before + step
                } else {
                    before + epsilon * step
                };
            }
        }
        self.turns_of(control_points).eq(self.turns.iter().copied())
    }

    /// The largest ε in (0, 1], but for the tolerance, that keeps the turns; 0 if there is none.
    fn admissible_part(&self, control_points: &mut Points) -> f64 {
        if self.keeps_turns(1.0, control_points) {
            return 1.0;
        }
        let mut kept = 0.5;
        let mut halvings = 1;
        while !self.keeps_turns(kept, control_points) {
            kept /= 2.0;
            halvings += 1;
            if halvings > HALVINGS {
                return 0.0;
            }
        }
        // Back towards the whole step, as far as the turns allow.
        let mut lost = 1.0;
        for _ in 0..HALVINGS {
            if lost - kept <= self.step_tolerance {
                break;
            }
            let middle = f64::midpoint(kept, lost);
            if self.keeps_turns(middle, control_points) {
                kept = middle;
            } else {
                lost = middle;
            }
        }
        kept
    }
}

impl Update for Steps {
    fn copy(&self) -> Box<dyn Update> {
        Box::new(self.clone())
    }

    /// A whole step, or the longest part of it that keeps the turns.
    fn update(&mut self, _equations: &Equations, state: &mut State) -> Change {
        let State {
            control_points,
            residual,
            ..
        } = state;
        self.turns.clear();
        let signs = self.turns_of(control_points);
        self.turns.extend(signs);
        copy(control_points, &mut self.before);
        copy(residual, &mut self.step);
        let epsilon = self.admissible_part(control_points);
        // The search has tried other places since.
        self.keeps_turns(epsilon, control_points);
        self.idle = if epsilon < PROGRESS { self.idle + 1 } else { 0 };
        Change::All {
            moved: if epsilon > 0.0 {
                control_points.len()
            } else {
                0
            },
        }
    }

    /// After a few steps without progress, as the polygon of the limit turns otherwise.
    fn stalled(&self) -> Option<Reason> {
        (self.idle >= PATIENCE).then_some(Reason::Convexity)
    }
}

/// Copies points to others of the same number.
fn copy(from: &Points, to: &mut Points) {
    for (to, from) in to.lanes_mut().iter_mut().zip(from.lanes()) {
        to.copy_from_slice(from);
    }
}

/// The constants of the control points beside an end, in the order of the polygon; none where these
/// are copies, or lie on the polygon of the free ones.
fn beside(setup: &Setup, side: Side) -> Vec<[f64; 2]> {
    let direction = setup.u();
    let Some(offsets) = setup
        .offsets()
        .filter(|_| direction.natural(side).is_none())
    else {
        return Vec::new();
    };
    let last = direction.basis.functions() - 1;
    let copies = 1..=direction.copies(side);
    let constants = copies.map(|j| {
        let row = match side {
            Side::Start => j,
            Side::End => last - j,
        };
        [0, 1].map(|coordinate| offsets.at(row, 0, coordinate))
    });
    let mut constants: Vec<[f64; 2]> = constants.collect();
    // Copies that are equal to the end do not turn.
    constants.retain(|constant| *constant != [0.0; 2]);
    if side == Side::End {
        constants.reverse();
    }
    constants
}

impl Steps {
    /// The signs of the turning angles of the control polygon of these free control points.
    fn turns_of(&self, free: &Points) -> impl Iterator<Item = i8> + use<> {
        let [front, back] = &self.beside;
        let last = free.len() - 1;
        let point = |i: usize| [free.lane(0)[i], free.lane(1)[i]];
        let moved = |i: usize, by: &[f64; 2]| [point(i)[0] + by[0], point(i)[1] + by[1]];
        let mut polygon = Vec::with_capacity(free.len() + front.len() + back.len());
        polygon.push(point(0));
        polygon.extend(front.iter().map(|by| moved(0, by)));
        polygon.extend((1..last).map(point));
        polygon.extend(back.iter().map(|by| moved(last, by)));
        polygon.push(point(last));
        turns(polygon, self.closed, self.scale)
    }
}

/// The signs of the turning angles of a polygon at its inner points and, if it is closed, at its
/// ends: 1 to the left, −1 to the right, 0 straight on. `scale` keeps products of lengths within
/// the range of numbers.
fn turns(polygon: Vec<[f64; 2]>, closed: bool, scale: f64) -> impl Iterator<Item = i8> {
    let n = polygon.len();
    let angles = if closed { n } else { n.saturating_sub(2) };
    (0..angles).map(move |i| {
        let [a, b, c] = [0, 1, 2].map(|k| polygon[(i + k) % n]);
        let edge = |a: [f64; 2], b: [f64; 2]| [(b[0] - a[0]) * scale, (b[1] - a[1]) * scale];
        let ([ax, ay], [bx, by]) = (edge(a, b), edge(b, c));
        let cross = ax * by - ay * bx;
        if cross > 0.0 {
            1
        } else if cross < 0.0 {
            -1
        } else {
            0
        }
    })
}
