//! Short programs, one for each kind of fit.
//!
//! # A curve through points
//!
//! ```
//! use piad_fit::Fit;
//!
//! let points = [[0.0, 0.0], [1.0, 2.0], [3.0, 3.0], [5.0, 2.0], [6.0, 0.0]];
//! let curve = Fit::curve(&points).tolerance(1e-9).prepare()?.solve()?;
//! let (start, end) = curve.domain();
//! assert_eq!(curve.eval(start), [0.0, 0.0]);
//! println!("from {:?} to {:?}", curve.derivative(start), curve.derivative(end));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Every level, coarse first
//!
//! ```
//! use piad_fit::Fit;
//!
//! let points: Vec<[f64; 2]> = (0..50).map(|i| 0.1 * f64::from(i)).map(|t| [t.cos(), t.sin()]).collect();
//! let fit = Fit::curve(&points).tolerance(1e-6).prepare()?;
//! for level in fit.levels() {
//!     let curve = level.curve();
//!     println!("{}: {:e}, {} control points", level.iteration, level.error.max, curve.nurbs().rows());
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A closed curve
//!
//! ```
//! use piad_fit::Fit;
//!
//! let turn = |i: u32| std::f64::consts::TAU * f64::from(i) / 12.0;
//! let points: Vec<[f64; 2]> = (0..12).map(turn).map(|a| [3.0 * a.cos(), a.sin()]).collect();
//! let curve = Fit::curve(&points).closed().tolerance(1e-9).prepare()?.solve()?;
//! let (start, end) = curve.domain();
//! let gap = curve.eval(start)[0] - curve.eval(end)[0];
//! assert!(gap.abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # As few control points as a tolerance needs
//!
//! ```
//! use piad_fit::Fit;
//!
//! let points: Vec<[f64; 2]> = (0..500).map(|i| 0.02 * f64::from(i)).map(|x| [x, x.sin()]).collect();
//! let curve = Fit::curve(&points).fewest_control_points().tolerance(1e-3).prepare()?.solve()?;
//! assert!(curve.error().max <= 1e-3 && curve.nurbs().rows() < 20);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Least squares with a given tangent
//!
//! ```
//! use std::sync::Arc;
//!
//! use piad_fit::invalid::Side;
//! use piad_fit::method::{At, Constraint, LeastSquares, Wanted};
//! use piad_fit::{Fit, Method};
//!
//! let points: Vec<[f64; 2]> = (0..40).map(|i| 0.05 * f64::from(i)).map(|x| [x, x * x]).collect();
//! let level = Constraint { at: At::Side(Side::Start), wanted: Wanted::Tangent(vec![1.0, 0.0]) };
//! let settings = LeastSquares { constraints: Arc::new([level]), ..LeastSquares::new(8, 8) };
//! let curve = Fit::curve(&points).method(Method::LeastSquares(settings)).prepare()?.solve()?;
//! let [dx, dy] = curve.derivative(curve.domain().0)[..] else { unreachable!() };
//! assert!(dx > 0.0 && dy.abs() < 1e-9 * dx);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A smooth curve near noisy points
//!
//! ```
//! use piad_fit::method::{Fairness, LeastSquares};
//! use piad_fit::{Fit, Method};
//!
//! let noise = |i: u32| 0.1 * (f64::from(i * i) * 0.7).sin();
//! let points: Vec<[f64; 2]> = (0..200).map(|i| [f64::from(i), noise(i)]).collect();
//! let fairness = Some(Fairness { value: 1e-6, order: 2, by_data: false });
//! let settings = LeastSquares { fairness, ..LeastSquares::new(60, 60) };
//! let curve = Fit::curve(&points).method(Method::LeastSquares(settings)).prepare()?.solve()?;
//! assert!(curve.error().rms < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A rational curve
//!
//! ```
//! use piad_fit::Fit;
//!
//! let points = [[1.0, 0.0], [0.8, 0.6], [0.6, 0.8], [0.0, 1.0]];
//! let weights = vec![1.0, 2.0, 2.0, 1.0];
//! let curve = Fit::curve(&points).weights(weights).tolerance(1e-9).prepare()?.solve()?;
//! assert!(curve.nurbs().weights.is_some());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A surface through a grid
//!
//! ```
//! use piad_fit::{Fit, Method};
//!
//! let height = |i: u32, j: u32| (f64::from(i) * 0.5).sin() * (f64::from(j) * 0.4).cos();
//! let row = |i: u32| (0..9).map(|j| [f64::from(i), f64::from(j), height(i, j)]).collect();
//! let rows: Vec<Vec<[f64; 3]>> = (0..7).map(row).collect();
//! let surface = Fit::surface(&rows).method(Method::Direct).tolerance(1e-9).prepare()?.solve()?;
//! let [(u, _), (_, v)] = surface.domain();
//! let corner = surface.eval(u, v);
//! assert!(corner.iter().zip(rows[0][8]).all(|(x, datum)| (x - datum).abs() < 1e-9));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A surface near scattered points
//!
//! ```
//! use piad_fit::Fit;
//! use piad_fit::parameters::{CoordinatePlane, Scattered};
//!
//! let part = |i: u32, step: f64| (f64::from(i) * step).fract();
//! let place = |i: u32| [part(i, 0.7549), part(i, 0.5698)];
//! let points: Vec<[f64; 3]> = (0..400).map(place).map(|[x, y]| [x, y, x * x - y]).collect();
//! let fit = Fit::scattered(&points, Scattered::Coordinates(CoordinatePlane::Xy)).tolerance(1e-4);
//! let surface = fit.prepare()?.solve()?;
//! assert!((surface.eval(0.5, 0.5)[2] + 0.25).abs() < 2e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A fit that has not converged
//!
//! ```
//! use piad_fit::Fit;
//!
//! let points: Vec<[f64; 1]> = (0..60).map(|i| [f64::from(i % 7)]).collect();
//! let fit = Fit::curve(&points).max_iterations(3).prepare()?;
//! let stopped = fit.solve().unwrap_err();
//! println!("{stopped}; the nearest one is {:e} away", stopped.best.error().max);
//! # Ok::<(), piad_fit::Invalid>(())
//! ```
