//! The shape of a curve.

use super::degenerate::{MOST_DEGENERATE, Vanishing};
use super::extremes::{Best, Bracket, Extreme, Extremes};
use super::jets::CurveJets;
use super::joints::{Joint, joints};
use crate::geometry::arc_length::ArcLength;
use crate::geometry::nurbs::Nurbs;
use crate::geometry::nurbs::sampling::SpanParameter;

/// About the number of evaluations to find the extremes.
const EVALUATIONS: usize = 1 << 18;

/// The least number of steps of a knot span of many, and of few.
const LEAST_STEPS: usize = 4;
const USUAL_STEPS: usize = 16;

/// The parameters that are evaluated at a time.
const TOGETHER: usize = 1 << 12;

/// Each of these rounds divides the interval that holds an extreme by half of the number of steps.
const ROUNDS: usize = 12;
const ROUND_STEPS: usize = 16;

/// The shape of a curve with two or more coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveShape {
    /// The length; NaN if numbers overflow.
    pub length: f64,
    /// Where its curvature is least and largest, to rounding beside samples of each knot span. Curvature of plane curves
    /// has a sign, so that the least is the sharpest turn to the right.
    pub extremes: Extremes,
    /// Parameters at which the derivative vanishes, so that there is no curvature, and near which it may be unbounded:
    /// at most [`MOST_DEGENERATE`] of those at which it was searched for.
    pub degenerate: Vec<f64>,
    /// The number of inner knots, and of the one where a closed curve returns to its start.
    pub joint_count: usize,
    /// The continuity at these knots, in their order; of more than `MOST_JOINTS` those with the least.
    pub joints: Vec<Joint>,
    /// Points and curvatures.
    pub samples: CurveSamples,
}

/// Curvature of a curve at parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveSamples {
    /// The parameters.
    pub parameters: Vec<f64>,
    /// The coordinates of the points, point by point.
    pub points: Vec<f64>,
    /// The curvatures; NaN where they are undefined.
    pub curvature: Vec<f64>,
}

impl CurveShape {
    /// The shape of a curve, with samples at these parameters. Its weights are positive, and its control points finite
    /// with two or more coordinates.
    pub fn new(nurbs: &Nurbs, sites: &[SpanParameter]) -> Self {
        let vanishing = Vanishing::along(nurbs);
        let (extremes, degenerate) = extremes(nurbs, &vanishing);
        let (joints, joint_count) = joints(nurbs, &vanishing);
        Self {
            length: ArcLength::new(nurbs).total(),
            extremes,
            degenerate,
            joint_count,
            joints,
            samples: samples(nurbs, &vanishing, sites),
        }
    }
}

fn samples(nurbs: &Nurbs, vanishing: &Vanishing, sites: &[SpanParameter]) -> CurveSamples {
    let mut samples = CurveSamples::default();
    for sites in sites.chunks(TOGETHER) {
        let jets = CurveJets::new(nurbs, vanishing, sites);
        for (i, site) in sites.iter().enumerate() {
            samples.parameters.push(site.t);
            samples.points.extend(jets.point(i));
            samples.curvature.push(jets.curvature(i));
        }
    }
    samples
}

/// The places of the least and the largest curvature, and those where it is undefined.
fn extremes(nurbs: &Nurbs, vanishing: &Vanishing) -> (Extremes, Vec<f64>) {
    let knots = &nurbs.u;
    let spans = knots.spans();
    let most = (4 * (knots.degree + 1)).max(USUAL_STEPS);
    let steps = (EVALUATIONS / spans.len().max(1)).clamp(LEAST_STEPS, most);
    let mut bests = Best::both();
    let mut degenerate: Vec<f64> = Vec::new();
    for spans in spans.chunks((TOGETHER / (steps + 1)).max(1)) {
        let whole = |span: usize| Bracket {
            span,
            low: knots.knots[span],
            high: knots.knots[span + 1],
        };
        let at = |bracket: Bracket| {
            let steps = bracket.steps(steps);
            steps.map(move |t| SpanParameter::new(bracket.span, t))
        };
        let sites: Vec<SpanParameter> = spans.iter().flat_map(|&span| at(whole(span))).collect();
        let jets = CurveJets::new(nurbs, vanishing, &sites);
        let curvatures: Vec<f64> = (0..sites.len()).map(|i| jets.curvature(i)).collect();
        let each = spans.iter().zip(curvatures.chunks(steps + 1));
        for (&span, curvatures) in each {
            let sites = whole(span).steps(steps);
            for (k, (&value, t)) in curvatures.iter().zip(sites).enumerate() {
                if value.is_nan() && degenerate.len() < MOST_DEGENERATE {
                    degenerate.push(t);
                }
                let near = &curvatures[k.saturating_sub(1)..(k + 2).min(curvatures.len())];
                let place = || {
                    // Beside a place without curvature it may be unbounded: nearer ones would only be larger.
                    let smooth = near.iter().all(|x| x.is_finite());
                    let bracket = smooth.then(|| whole(span).around(k, steps));
                    (SpanParameter::new(span, t), bracket)
                };
                bests.iter_mut().for_each(|best| best.offer(value, &place));
            }
        }
    }
    degenerate.dedup();
    let [smallest, largest] = bests.map(|best| refined(nurbs, vanishing, best));
    (Extremes { smallest, largest }, degenerate)
}

/// A place of a curve, and the interval around it in which the value may be better.
type Place = (SpanParameter, Option<Bracket>);

/// The best value near the one that was found.
fn refined(nurbs: &Nurbs, vanishing: &Vanishing, mut best: Best<Place>) -> Option<Extreme> {
    for _ in 0..ROUNDS {
        let Some((_, (_, Some(bracket)))) = best.found else {
            break;
        };
        let sites = bracket.steps(ROUND_STEPS);
        let sites: Vec<_> = sites.map(|t| SpanParameter::new(bracket.span, t)).collect();
        let jets = CurveJets::new(nurbs, vanishing, &sites);
        let mut round = best.again();
        for (k, &site) in sites.iter().enumerate() {
            let around = || (site, Some(bracket.around(k, ROUND_STEPS)));
            round.offer(jets.curvature(k), around);
        }
        if !best.improve(&round) {
            break;
        }
    }
    let (value, (site, _)) = best.found?;
    let jets = CurveJets::new(nurbs, vanishing, &[site]);
    Some(Extreme {
        u: site.t,
        v: None,
        point: jets.point(0).collect(),
        value,
    })
}
