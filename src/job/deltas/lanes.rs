//! An array of numbers that follows another one in whole steps.

use bytes::Bytes;
use pulp::{Arch, NullaryFnOnce};

use super::packed::{BLOCK, Malformed, pack, unpack, unsigned};

/// The number of steps of an error.
const FINENESS: f64 = 64.0;

/// The most steps that a number is moved at once.
const MAX_STEPS: f64 = i32::MAX as f64;

/// A number of this size has no bits behind the point: adding it to a number below 2⁵¹ rounds that to a whole number,
/// which is in the lowest bits of the sum.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Copies the numbers of an array from one on, point by point.
pub(crate) type Fill = Box<dyn Fn(usize, &mut [f64])>;

/// An array of an iteration: points, or weights.
pub(crate) struct Target {
    /// The number of points.
    pub places: usize,
    /// The number of coordinates.
    pub dimension: usize,
    /// The number of points copied at a time.
    pub at_once: usize,
    /// Copies them.
    pub fill: Fill,
}

/// The change of an array.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Change {
    /// The size of a step, a power of two.
    pub step: f64,
    /// The number of steps of each number, packed.
    pub numbers: Bytes,
}

/// The numbers of a reader's array, coordinate by coordinate.
#[derive(Clone, Debug)]
pub(super) struct Lanes {
    places: usize,
    values: Vec<f64>,
    /// The largest absolute value, with its first digits.
    largest: f64,
}

/// The largest power of two that is not above a positive number; 0 for numbers near 0.
fn power_of_two(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & f64::INFINITY.to_bits())
}

/// The size of steps that is fine enough for an error, and not finer than the rounding of the largest number.
pub(super) fn step(error: f64, largest: f64) -> f64 {
    let rounding = power_of_two(largest) * f64::EPSILON;
    let fine = power_of_two((error / FINENESS).min(f64::MAX / FINENESS));
    fine.max(rounding).max(f64::MIN_POSITIVE)
}

impl Target {
    /// Calls `visit` for each block of each coordinate, with the number of the first place.
    fn each(&self, mut visit: impl FnMut(usize, usize, &[f64])) {
        let Self {
            places, dimension, ..
        } = *self;
        let mut points = vec![0.0; self.at_once * dimension];
        let mut lanes = vec![0.0; BLOCK * dimension];
        let (mut first, mut count) = (0, 0);
        for start in (0..places).step_by(self.at_once) {
            let copied = self.at_once.min(places - start);
            let points = &mut points[..copied * dimension];
            (self.fill)(start * dimension, points);
            let mut rest = &*points;
            while !rest.is_empty() {
                let room = (BLOCK - count).min(rest.len() / dimension);
                let (these, others) = rest.split_at(room * dimension);
                for (coordinate, lane) in lanes.chunks_exact_mut(BLOCK).enumerate() {
                    copy(these, dimension, coordinate, &mut lane[count..count + room]);
                }
                (rest, count) = (others, count + room);
                if count == BLOCK || first + count == places {
                    for (coordinate, lane) in lanes.chunks_exact(BLOCK).enumerate() {
                        visit(coordinate, first, &lane[..count]);
                    }
                    (first, count) = (first + count, 0);
                }
            }
        }
    }
}

/// Copies a coordinate of points.
fn copy(points: &[f64], dimension: usize, coordinate: usize, lane: &mut [f64]) {
    match dimension {
        1 => lane.copy_from_slice(points),
        2 => copy_one_of::<2>(points, coordinate, lane),
        3 => copy_one_of::<3>(points, coordinate, lane),
        _ => {
            let from = points[coordinate..].iter().step_by(dimension);
            lane.iter_mut().zip(from).for_each(|(to, x)| *to = *x);
        }
    }
}

/// Copies one of D coordinates.
fn copy_one_of<const D: usize>(points: &[f64], coordinate: usize, lane: &mut [f64]) {
    let (points, _) = points.as_chunks::<D>();
    let places = lane.iter_mut().zip(points);
    places.for_each(|(to, point)| *to = point[coordinate]);
}

/// The upper half of a number without its sign: larger numbers have a larger one.
#[inline(always)]
fn upper_half(x: f64) -> i32 {
    (x.to_bits() >> 32) as i32 & i32::MAX
}

/// A number by its upper half, up to the digits of the lower one.
fn of_upper_half(half: i32) -> f64 {
    f64::from_bits(u64::from(half.unsigned_abs()) << 32)
}

impl Lanes {
    /// All numbers of an array, if they are finite.
    pub(super) fn of(target: &Target) -> Option<Self> {
        let places = target.places;
        let mut values = vec![0.0; places * target.dimension];
        target.each(|coordinate, start, lane| {
            values[coordinate * places + start..][..lane.len()].copy_from_slice(lane);
        });
        let largest = of_upper_half(most(&values));
        largest.is_finite().then_some(Self {
            places,
            values,
            largest,
        })
    }

    /// The number of numbers.
    pub(super) fn count(&self) -> usize {
        self.values.len()
    }

    /// The largest absolute value.
    pub(super) fn largest(&self) -> f64 {
        self.largest
    }

    /// True if numbers of 32 bits are within half a step.
    pub(super) fn has_room_in_32_bits(&self, step: f64) -> bool {
        let smallest = f64::from(f32::from_bits(1));
        let rounding = power_of_two(self.largest) * f64::from(f32::EPSILON);
        self.largest < f64::from(f32::MAX) / 2.0 && rounding.max(smallest) <= step
    }

    /// Rounds all numbers to 32 bits.
    pub(super) fn round_to_32_bits(&mut self) {
        let rounded = self.values.iter_mut();
        rounded.for_each(|x| *x = f64::from(*x as f32));
    }

    /// Moves as near to an array as whole steps allow; `None` if that takes too many of them, after which the numbers
    /// are invalid.
    pub(super) fn follow(&mut self, target: &Target, step: f64) -> Option<Change> {
        let places = self.places;
        if target.places != places || target.dimension * places != self.values.len() {
            return None;
        }
        let mut packed = vec![Vec::new(); target.dimension];
        let (mut reaches, mut half) = (true, 0);
        let arch = Arch::new();
        target.each(|coordinate, start, lane| {
            let has = &mut self.values[coordinate * places + start..][..lane.len()];
            let moving = Moving {
                has,
                to: lane,
                step,
                packed: &mut packed[coordinate],
            };
            let (is_reached, most) = arch.dispatch(moving);
            reaches &= is_reached;
            half = half.max(most);
        });
        self.largest = of_upper_half(half);
        reaches.then(|| Change {
            step,
            numbers: packed.concat().into(),
        })
    }

    /// Applies the steps of another array with the same numbers.
    pub(super) fn apply(&mut self, change: &Change) -> Result<(), Malformed> {
        let mut bytes = &change.numbers[..];
        let mut block = [0; BLOCK];
        for lane in self.values.chunks_mut(self.places.max(1)) {
            for has in lane.chunks_mut(BLOCK) {
                let block = &mut block[..has.len()];
                unpack(&mut bytes, block)?;
                let moved = has.iter_mut().zip(&*block);
                moved.for_each(|(has, d)| *has += change.step * f64::from(*d));
            }
        }
        self.largest = of_upper_half(most(&self.values));
        match bytes {
            [] => Ok(()),
            _ => Err(Malformed::TooLong),
        }
    }
}

/// The largest upper half of numbers.
fn most(numbers: &[f64]) -> i32 {
    numbers.iter().fold(0, |most, x| most.max(upper_half(*x)))
}

/// Moves a block of numbers by whole steps to where they are nearest to others.
struct Moving<'a> {
    has: &'a mut [f64],
    to: &'a [f64],
    step: f64,
    /// The buffer for the numbers of steps.
    packed: &'a mut Vec<u8>,
}

impl NullaryFnOnce for Moving<'_> {
    /// False if some are moved by too many steps, and the largest upper half.
    type Output = (bool, i32);

    // Without branches, so that the loop is vectorised.
    #[inline(always)]
    fn call(self) -> (bool, i32) {
        let (step, inverse) = (self.step, 1.0 / self.step);
        let (mut reaches, mut most) = (true, 0);
        let mut block = [0; BLOCK];
        let numbers = &mut block[..self.to.len()];
        let places = self.has.iter_mut().zip(self.to).zip(&mut *numbers);
        for ((has, to), number) in places {
            let steps = (to - *has) * inverse;
            let rounded = steps + ROUNDER;
            *has += step * (rounded - ROUNDER);
            *number = unsigned(rounded.to_bits() as i32);
            reaches &= steps.abs() <= MAX_STEPS;
            most = most.max(upper_half(*has));
        }
        pack(numbers, self.packed);
        (reaches, most)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn target(numbers: &[f64], dimension: usize) -> Target {
        let numbers = numbers.to_vec();
        Target {
            places: numbers.len() / dimension,
            dimension,
            at_once: 85,
            fill: Box::new(move |start, to| {
                to.copy_from_slice(&numbers[start..start + to.len()]);
            }),
        }
    }

    /// Checks that numbers follow an array as far as steps and their own rounding allow.
    fn assert_near(lanes: &Lanes, target: &Target, step: f64) {
        target.each(|coordinate, start, lane| {
            let has = &lanes.values[coordinate * lanes.places + start..];
            for (has, x) in has.iter().zip(lane) {
                let rounding = power_of_two(has.abs()) * f64::EPSILON;
                let distance = (has - x).abs();
                assert!(distance <= step / 2.0 + rounding, "{has} {x} {step}");
            }
        });
    }

    #[test]
    fn steps_are_powers_of_two_between_the_error_and_the_rounding() {
        assert_eq!(step(64.0, 0.0), 1.0);
        assert_eq!(step(127.9, 100.0), 1.0);
        assert_eq!(step(128.0, 100.0), 2.0);
        assert_eq!(step(0.0, 1.5), f64::EPSILON);
        assert_eq!(step(1e-300, 3.0), 2.0 * f64::EPSILON);
        assert_eq!(step(0.0, 0.0), f64::MIN_POSITIVE);
        assert_eq!(step(f64::MIN_POSITIVE, 1e-320), f64::MIN_POSITIVE);
        assert!((1.0 / step(f64::MAX, f64::MAX)).is_normal());
    }

    #[test]
    fn numbers_that_are_too_far_or_not_finite_are_not_reached() {
        let near = target(&[0.0, 1.0, 2.0, 3.0], 2);
        for (far, reached) in [
            (MAX_STEPS, true),
            (-MAX_STEPS, true),
            (MAX_STEPS + 1.0, false),
            (f64::INFINITY, false),
            (f64::NAN, false),
            (f64::MAX, false),
        ] {
            let mut lanes = Lanes::of(&near).unwrap();
            let change = lanes.follow(&target(&[far, 1.0, 2.0, 3.0], 2), 1.0);
            assert_eq!(change.is_some(), reached, "{far}");
        }
        let mut lanes = Lanes::of(&near).unwrap();
        assert!(lanes.follow(&target(&[0.0; 6], 2), 1.0).is_none());
        assert!(Lanes::of(&target(&[0.0, f64::NAN], 1)).is_none());
        assert!(Lanes::of(&target(&[f64::INFINITY], 1)).is_none());
    }

    #[test]
    fn truncated_or_long_input_is_an_error() {
        let numbers: Vec<f64> = (0..600).map(f64::from).collect();
        let zeros = Lanes::of(&target(&[0.0; 600], 2)).unwrap();
        let change = zeros.clone().follow(&target(&numbers, 2), 1.0).unwrap();
        let with = |numbers: Vec<u8>| {
            let numbers = numbers.into();
            zeros.clone().apply(&Change { step: 1.0, numbers })
        };
        let bytes = change.numbers.to_vec();
        assert_eq!(with(bytes.clone()), Ok(()));
        assert_eq!(
            with(bytes[..bytes.len() - 1].to_vec()),
            Err(Malformed::CutOff)
        );
        assert_eq!(with([&bytes[..], &[0]].concat()), Err(Malformed::TooLong));
    }

    /// Numbers may depend on which others are copied with them.
    #[test]
    fn as_many_points_are_copied_at_a_time_as_is_said() {
        for (places, at_once) in [(1000, 255), (1000, 384), (256, 256), (1, 48), (513, 1)] {
            let parts: Vec<_> = (0..places).step_by(at_once).collect();
            let part_of = move |start: usize| start as f64;
            let target = Target {
                places,
                dimension: 3,
                at_once,
                fill: Box::new(move |start, to| to.fill(part_of(start / 3))),
            };
            let lanes = Lanes::of(&target).unwrap();
            for (place, x) in lanes.values.iter().enumerate() {
                let part = parts[place % places / at_once];
                assert_eq!(*x, part_of(part), "{places} {at_once} {place}");
            }
        }
    }

    #[test]
    fn rounding_to_32_bits_is_within_half_a_step() {
        let lanes = |x: f64| Lanes::of(&target(&[x, 0.0], 1)).unwrap();
        let coarse = f64::from(f32::EPSILON);
        assert!(lanes(1.0).has_room_in_32_bits(coarse));
        assert!(!lanes(1.0).has_room_in_32_bits(coarse / 2.0));
        assert!(!lanes(1e39).has_room_in_32_bits(1e39));
        assert!(!lanes(1e-40).has_room_in_32_bits(1e-46));
    }

    proptest! {
        #[test]
        fn readers_have_the_same_numbers_near_those_of_each_iteration(
            places in 1..300_usize,
            dimension in 1..=16_usize,
            errors in prop::collection::vec(-40..20_i32, 1..8),
            seed in any::<u32>(),
        ) {
            let count = places * dimension;
            let mut x: Vec<f64> = (0..count).map(|i| 10.0 * f64::from(seed.wrapping_mul(i as u32)).sin()).collect();
            let mut server = Lanes::of(&target(&x, dimension)).unwrap();
            let mut reader = server.clone();
            for (k, error) in errors.into_iter().enumerate() {
                let error = 1.7_f64.powi(error);
                x.iter_mut().enumerate().for_each(|(i, x)| *x += error * ((i + k) as f64).sin());
                let target = target(&x, dimension);
                let step = step(error, server.largest());
                prop_assert!(step * 64.0 <= error || step <= server.largest() * f64::EPSILON);
                let Some(change) = server.follow(&target, step) else {
                    server = Lanes::of(&target).unwrap();
                    reader = server.clone();
                    continue;
                };
                assert_near(&server, &target, step);
                let again = reader.clone().follow(&target, step);
                prop_assert_eq!(again.as_ref(), Some(&change));
                reader.apply(&change).unwrap();
                prop_assert!(reader.values.iter().zip(&server.values).all(|(a, b)| a.to_bits() == b.to_bits()));
                prop_assert_eq!(reader.largest(), server.largest());
            }
        }
    }
}
