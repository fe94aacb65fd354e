//! Distances of which a stream shows the first iteration that is within each.

/// Milestones, of which some are reached.
#[derive(Clone, Debug)]
pub(super) struct Milestones {
    /// Decreasing.
    distances: Vec<f64>,
    reached: usize,
}

impl Milestones {
    /// None is reached yet.
    pub(super) fn new(distances: Vec<f64>) -> Self {
        Self {
            distances,
            reached: 0,
        }
    }

    /// The smallest of those that an iteration is the first to reach, if there is one.
    pub(super) fn reach(&mut self, distance: f64) -> Option<f64> {
        let within = |milestone: &&f64| distance <= **milestone;
        let new = self.distances[self.reached..].iter().take_while(within);
        let count = new.count();
        self.reached += count;
        (count > 0).then(|| self.distances[self.reached - 1])
    }

    /// Whether there is nothing left to reach.
    pub fn all_reached(&self) -> bool {
        self.reached == self.distances.len()
    }
}
