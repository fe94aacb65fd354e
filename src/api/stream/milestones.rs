//! Milestones of a stream: for each of these distances it shows the first iteration within it.

/// The milestones of a stream, and the number of those reached.
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

    /// Marks the milestones that an iteration with this largest distance reaches; returns the smallest
    /// one that it is the first to reach.
    pub(super) fn reach(&mut self, distance: f64) -> Option<f64> {
        let within = |milestone: &&f64| distance <= **milestone;
        let new = self.distances[self.reached..].iter().take_while(within);
        let count = new.count();
        self.reached += count;
        (count > 0).then(|| self.distances[self.reached - 1])
    }

    /// Returns true if all are reached.
    pub(super) fn all_reached(&self) -> bool {
        self.reached == self.distances.len()
    }
}
