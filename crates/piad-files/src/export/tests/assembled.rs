//! B-splines of plain data.

use super::*;
use crate::export::nurbs::products;

fn data(degree: usize, knots: Option<&[f64]>, closed: bool) -> DirectionData {
    DirectionData {
        degree,
        knots: knots.map(<[f64]>::to_vec),
        closed,
    }
}

#[test]
fn results_are_assembled() {
    for nurbs in [wave(), ring(), arc()] {
        let u = data(nurbs.u.degree, Some(&nurbs.u.knots), nurbs.u.closed);
        let points = Points::from_flat(nurbs.points.dimension(), &nurbs.points.to_flat());
        let found = assemble(u, None, points, nurbs.weights.clone()).unwrap();
        assert_eq!(found, nurbs);
    }
    let tube = cylinder();
    let v = tube.v.clone().unwrap();
    let points = Points::from_flat(3, &tube.points.to_flat());
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let weights = products(Ok(&[1.0, half, 1.0]), Err(2));
    let (u, v) = (data(2, None, false), data(1, Some(&v.knots), false));
    assert_eq!(assemble(u, Some(v), points, Some(weights)).unwrap(), tube);
}

/// The name of the field, and the error.
#[test]
fn wrong_data_are_named() {
    let wave = wave();
    let points = || Points::from_flat(2, &wave.points.to_flat());
    let error = |u: DirectionData, weights: Option<Vec<f64>>| {
        assemble(u, None, points(), weights)
            .unwrap_err()
            .to_string()
    };
    let knots = |knots: &[f64]| error(data(3, Some(knots), false), None);
    assert!(knots(&[0.0; 7]).starts_with("knots: 7 given; degree 3 needs at least 8"));
    let falling = [0.0, 0.0, 0.0, 0.0, -0.4, 1.0, 1.0, 1.0, 1.0];
    assert_eq!(
        knots(&falling),
        "knots: number 4 is less than the one before it"
    );
    assert!(knots(&[0.0; 9]).contains("so that it is empty"));
    let five = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    assert!(
        knots(&five).contains("0 occurs 5 times"),
        "{}",
        knots(&five)
    );
    let few = error(data(3, None, false), None);
    assert!(
        few.starts_with("control_points: there are 5, and the knots and the degree are those of 4")
    );
    let own = data(3, Some(&wave.u.knots), false);
    let nan = knots(&[0.0, 0.0, 0.0, 0.0, f64::NAN, 1.0, 1.0, 1.0, 1.0]);
    assert_eq!(nan, "knots: number 4 is NaN");
    assert!(error(own.clone(), Some(vec![1.0; 4])).starts_with("weights: there are 4"));
    let zero = Some(vec![1.0, 1.0, 0.0, 1.0, 1.0]);
    assert!(error(own.clone(), zero).starts_with("weights: number 2 is 0"));
    let closed = DirectionData {
        closed: true,
        ..own.clone()
    };
    assert_eq!(
        error(closed, None),
        "closed: the last control point is not the first one"
    );
    let zero = DirectionData { degree: 0, ..own };
    assert!(error(zero, None).starts_with("degree: 0 is out of range"));
    let ring = ring();
    let mut points = Points::from_flat(2, &ring.points.to_flat());
    points.lanes_mut()[0][6] += 0.1;
    let u = data(3, Some(&ring.u.knots), true);
    let open = assemble(u, None, points, None).unwrap_err().to_string();
    assert_eq!(
        open,
        "closed: the last 3 control points are not the first ones again"
    );
}
