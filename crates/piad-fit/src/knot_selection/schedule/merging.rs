//! After the removal of knots: one knot replaces a cluster, or two neighbours, and all move to better positions.

use std::sync::Arc;

use super::super::adaptive::FIRST_DAMPING;
use super::super::equations::Minimum;
use super::super::knot_step::can_move;
use super::super::merging::{merged, thinned};
use super::{Level, Schedule, values_of};
use crate::interrupt;

/// The number of pairs whose fits with one knot instead are compared.
const CANDIDATES: usize = 12;

/// The number of these fits, those nearest to the data, whose knots are moved; their largest distance must be at most
/// [`FAR`] tolerances.
const NEAREST: usize = 2;

/// See [`NEAREST`].
const FAR: f64 = 8.0;

/// The most steps of the knots.
const STEPS: usize = 12;

/// They end when the rms falls to no less than this part, and with more damping than [`MOST_DAMPING`].
const SLOW: f64 = 0.9;

/// See [`SLOW`].
const MOST_DAMPING: f64 = 0.1;

/// A step of cubic curves takes about as long as this number of fits.
const COST: usize = 8;

impl<M: Minimum> Schedule<M> {
    /// The best level with at least one knot fewer; returns true if there is such a level within the tolerance.
    pub(super) fn merge(&mut self) -> bool {
        let can_move = |it: &Arc<Level<1>>| can_move(&it.lines[0], self.points.len());
        let Some(best) = self.levels.best.clone().filter(can_move) else {
            return false;
        };
        if self.merges == 0 || !self.minimum.has_steps() {
            return false;
        }
        let found = self.without_crowds(&best);
        let found = found.or_else(|| self.without_a_pair(&best));
        self.levels.accept(found)
    }

    /// With one knot in place of each cluster.
    fn without_crowds(&mut self, best: &Level<1>) -> Option<Arc<Level<1>>> {
        let level = self.fit_over(thinned(&best.lines[0])?, best)?;
        self.moved(level, best)
    }

    /// With one knot in place of two.
    fn without_a_pair(&mut self, best: &Level<1>) -> Option<Arc<Level<1>>> {
        let far = FAR * self.options.tolerance;
        let candidates = merged(&best.lines[0], &best.control_points).take(CANDIDATES);
        let fits = candidates.filter_map(|line| self.fit_over(line, best));
        let mut near: Vec<Arc<Level<1>>> = fits.filter(|it| it.distances.max <= far).collect();
        near.sort_by(|a, b| a.distances.max.total_cmp(&b.distances.max));
        let mut nearest = near.into_iter().take(NEAREST);
        nearest.find_map(|level| self.moved(level, best))
    }

    /// A level within the tolerance with the same number of knots, moved to better positions.
    fn moved(&mut self, mut now: Arc<Level<1>>, best: &Level<1>) -> Option<Arc<Level<1>>> {
        let mut damping = FIRST_DAMPING;
        for _ in 0..STEPS {
            if self.levels.is_within(&now) {
                return Some(now);
            }
            self.merges = self.merges.saturating_sub(COST);
            interrupt::check();
            let minimum = &self.minimum;
            let line = minimum.moved_knots(&values_of(&now), &now.control_points, damping)?;
            let next = self.fit_over(line, best);
            match next.filter(|next| next.distances.rms < now.distances.rms) {
                Some(next) => {
                    let is_slow = next.distances.rms > SLOW * now.distances.rms;
                    (now, damping) = (next, damping / 10.0);
                    if is_slow {
                        break;
                    }
                }
                None if damping > MOST_DAMPING => break,
                None => damping *= 10.0,
            }
        }
        Some(now).filter(|it| self.levels.is_within(it))
    }
}
