//! The functions of a direction at parameters.

use super::direction::Direction;
use crate::interrupt::Meter;

/// At each parameter the functions that can differ from zero.
#[derive(Clone, Debug)]
pub(crate) struct Evaluated {
    /// How many there are at a parameter.
    pub width: usize,
    /// The first of them.
    pub firsts: Vec<u32>,
    /// Their values, parameter by parameter: products read them one after the other.
    pub values: Vec<f64>,
}

impl Evaluated {
    /// Evaluates the functions at some parameters.
    pub(crate) fn new(direction: &Direction, parameters: &[f64]) -> Self {
        let width = direction.basis.support_width();
        let mut values = vec![0.0; width * parameters.len()];
        let mut meter = Meter::default();
        let places = values.chunks_exact_mut(width).zip(parameters);
        let firsts = places.map(|(values, &t)| {
            meter.add(direction.basis.multiplications());
            direction.evaluate(t, values) as u32
        });
        Self {
            firsts: firsts.collect(),
            width,
            values,
        }
    }

    /// The first function and the values at parameter `i`.
    #[inline]
    pub(crate) fn at(&self, i: usize) -> (usize, &[f64]) {
        let values = &self.values[i * self.width..][..self.width];
        (self.firsts[i] as usize, values)
    }
}
