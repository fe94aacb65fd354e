//! Knots by a density, adjusted so that the data determine the fit.

use super::breaks::{Breaks, control_points_beyond_spans};
use super::monitor::Monitor;
use crate::basis::knots;

/// How far knots go towards those that have about as many data in each span, until the data
/// determine the fit.
const TOWARDS_DATA: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// Knots for this many control points that follow the density; where it needs more knots than there
/// are data, nearer to the data.
pub(crate) fn place(monitor: &Monitor, t: &[f64], control_points: usize) -> Option<Breaks> {
    if control_points == t.len() {
        // One for each datum: other knots hardly determine the fit.
        return even(monitor, t, control_points).filter(|line| line.is_determined(t));
    }
    let asked = monitor.place(control_points);
    if let Some(line) = asked.as_ref().filter(|line| line.is_determined(t)) {
        return Some(line.clone());
    }
    let even = even(monitor, t, control_points)?;
    TOWARDS_DATA.into_iter().skip(1).find_map(|part| {
        let asked = asked.as_ref().unwrap_or(&even);
        let pairs = asked.breaks().iter().zip(even.breaks());
        let breaks = pairs.map(|(a, b)| (1.0 - part) * a + part * b);
        let line = Breaks::new(even.degree(), even.is_closed(), breaks.collect())?;
        line.is_determined(t).then_some(line)
    })
}

/// Knots that follow the data (PT97 (9.68)–(9.69)), with a control point for each datum averages of
/// them (PT97 (9.8)).
pub(super) fn even(monitor: &Monitor, t: &[f64], control_points: usize) -> Option<Breaks> {
    let line = monitor.line();
    let (degree, closed) = (line.degree(), line.is_closed());
    let (start, end) = (line.breaks()[0], line.breaks()[line.spans()]);
    let spans = control_points.checked_sub(control_points_beyond_spans(degree, closed))?;
    let breaks = if closed {
        let at = |k: usize| {
            let x = k as f64 * t.len() as f64 / spans as f64;
            let i = (x as usize).min(t.len() - 1);
            let part = x - i as f64;
            let next = t.get(i + 1).copied().unwrap_or(end);
            (1.0 - part) * t[i] + part * next
        };
        (0..spans).map(at).chain([end]).collect()
    } else {
        let all = if control_points == t.len() {
            knots::averaged(t, degree)
        } else {
            knots::piegl_tiller(t, degree, control_points)
        };
        let mut breaks = all[degree..=degree + spans].to_vec();
        // The line can go beyond the data.
        breaks[0] = start.min(breaks[0]);
        breaks[spans] = end.max(breaks[spans]);
        breaks
    };
    Breaks::new(degree, closed, breaks)
}
