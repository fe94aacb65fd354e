//! Streams that send only the control points that have moved.

use serde_json::{Value, json};

use crate::data;
use crate::support::{Server, Story, assert_query_refused, base, thinned};

/// Overwrites the control points, and weights, that an event says have moved.
pub fn apply(net: &mut Value, event: &Value) {
    let homogeneous = net.get("weights").is_some();
    for change in event["changed"].as_array().unwrap() {
        let change = change.as_array().unwrap();
        assert_eq!(change.len(), 2 + usize::from(homogeneous));
        let place = |array: &mut Value, value: &Value| match &change[0] {
            Value::Array(at) => {
                let at: Vec<usize> = at.iter().map(|i| i.as_u64().unwrap() as usize).collect();
                array[at[0]][at[1]] = value.clone();
            }
            at => array[at.as_u64().unwrap() as usize] = value.clone(),
        };
        place(&mut net["control_points"], &change[1]);
        if homogeneous {
            place(&mut net["weights"], &change[2]);
        }
    }
}

/// The events that have only what has changed, after checking that they make the whole stream.
async fn changes(server: &Server, story: &Story, after: Option<&str>) -> Vec<Value> {
    let path = format!("{}/events?changed=true", base(&story.job));
    let (events, end) = thinned(server, &path, after).await;
    assert_eq!(end, story.end);
    let first = story.iterations.len() - events.len();
    assert_eq!(&events[0], &story.iterations[first]);
    let mut net = events[0].clone();
    let mut changes = Vec::new();
    for (event, whole) in events.iter().zip(&story.iterations[first..]).skip(1) {
        for name in ["iteration", "error", "rate", "moved"] {
            assert_eq!(event[name], whole[name], "{name}");
        }
        if event.get("control_points").is_some() {
            assert_eq!(event, whole);
            net = event.clone();
        } else {
            assert!(event.get("weights").is_none());
            apply(&mut net, event);
            changes.push(event.clone());
        }
        assert_eq!(net["control_points"], whole["control_points"]);
        assert_eq!(net.get("weights"), whole.get("weights"));
    }
    changes
}

/// Places of the complete net, of which each knows its copies.
fn curves() -> Vec<Value> {
    let weights: Vec<f64> = (0..30).map(|i| 1.0 + f64::from(i % 4) / 2.0).collect();
    let knots =
        |degree: usize, knots: &str| json!({"kind": "bspline", "degree": degree, "knots": knots});
    let mut curves = vec![
        json!({"points": data::helix(), "basis": {"kind": "bernstein"}}),
        json!({"points": data::helix(), "basis": knots(3, "averaged")}),
        json!({"points": data::helix(), "weights": weights}),
        json!({"points": data::wave(30), "closed": true, "weights": weights}),
    ];
    for degree in 1..=6 {
        curves.push(json!({"points": data::helix(), "basis": knots(degree, "data")}));
        let basis = json!({"kind": "bspline", "degree": degree});
        curves.push(json!({"points": data::wave(7), "closed": true, "basis": basis}));
    }
    curves
}

#[tokio::test]
async fn changes_make_the_whole_curve() {
    let server = Server::start().await;
    let mut adaptive = 0;
    for curve in curves() {
        let count = curve["points"].as_array().unwrap().len();
        for method in [
            json!({"kind": "local", "indices": [0, 3, count - 1]}),
            json!({"kind": "local", "indices": [2]}),
            json!({"kind": "adaptive", "threshold": 0.01}),
        ] {
            let job = json!({"curve": curve, "method": method, "stop": {"max_iterations": 30}});
            let story = server.stream(&job).await;
            let changes = changes(&server, &story, None).await;
            if method["kind"] == "local" {
                assert_eq!(changes.len() + 1, story.iterations.len());
            } else {
                adaptive += changes.len();
            }
        }
    }
    // Not all of them: curves of degree 1 are there at once, and symmetric ones move as a whole.
    assert!(adaptive > 50, "{adaptive}");
}

#[tokio::test]
async fn changes_make_the_whole_surface() {
    let server = Server::start().await;
    let weights: Vec<Vec<f64>> = (0..9)
        .map(|i| (0..9).map(|j| 1.0 + f64::from((i + j) % 3)).collect())
        .collect();
    for surface in [
        json!({"points": data::peaks(9)}),
        json!({"points": data::peaks(9), "closed": {"u": true, "v": false}}),
        json!({"points": data::peaks(9), "closed": true, "basis": {"kind": "bspline", "degree": 4}}),
        json!({"points": data::peaks(9), "weights": weights}),
    ] {
        for method in [
            json!({"kind": "local", "indices": [[0, 0], [4, 4], [8, 1]]}),
            json!({"kind": "local", "sweeps": "rows"}),
            json!({"kind": "adaptive", "threshold": 0.05}),
        ] {
            let job = json!({"surface": surface, "method": method, "stop": {"max_iterations": 40}});
            let story = server.stream(&job).await;
            let changes = changes(&server, &story, None).await;
            assert!(!changes.is_empty(), "{job}");
            assert!(changes[0]["changed"][0][0].is_array());
        }
    }
}

#[tokio::test]
async fn every_connection_begins_with_all_control_points() {
    let server = Server::start().await;
    let job = json!({
        "curve": {"points": data::helix()},
        "method": {"kind": "local", "indices": [3, 4, 5]},
    });
    let story = server.stream(&job).await;
    let last = story.iterations.len() - 1;
    for k in 0..last {
        let changes = changes(&server, &story, Some(&k.to_string())).await;
        assert_eq!(changes.len(), last - k - 1);
    }
    // The same while it runs, and with a ring of one frame.
    let server = Server::with(|config| config.ring = "1B".parse().unwrap()).await;
    let story = server.stream(&job).await;
    let found = changes(&server, &story, None).await;
    assert!(found.len() + 2 >= story.iterations.len());
}

/// Where all of them move, that is shorter and simpler.
#[tokio::test]
async fn fits_that_move_all_points_send_all() {
    let server = Server::start().await;
    for method in ["global", "chebyshev", "direct"] {
        let mut job = data::small_job();
        job["method"] = json!({"kind": method});
        let story = server.stream(&job).await;
        assert!(changes(&server, &story, None).await.is_empty());
    }
}

#[tokio::test]
async fn what_does_not_go_with_changes_is_refused() {
    let server = Server::start().await;
    let job = server.fit(&data::small_job()).await;
    let path = format!("{}/events", base(&job));
    for (query, reason) in [
        ("changed=yes", "false or true"),
        ("changed=true&view=samples", "control points"),
        ("changed=true&view=errors", "control points"),
        ("changed=true&every=2", "none can be skipped"),
        ("changed=true&milestones=0.1", "none can be skipped"),
        ("changed=true&pace=latest", "none can be skipped"),
        ("changed=true&digits=auto", "coarser rounding"),
        ("changed=true&encoding=base64", "no array of numbers"),
        ("changed=true&encoding=base64_f32", "no array of numbers"),
    ] {
        assert_query_refused(&server, &path, query, "changed", reason).await;
    }
}
