//! Comparisons of bases at the same parameters.

use serde_json::{Value, json};
use tonic::Code;

use crate::messages as pb;
use crate::rpc::connect;
use crate::support::{Server, problem};

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

/// The bases of a comparison: Bernstein, Said–Ball, Wang–Ball and B-splines.
async fn bases(server: &Server, query: &str) -> Vec<Value> {
    let rates = server.json(&format!("/v1/rates?{query}")).await;
    let bases = rates["bases"].as_array().unwrap().clone();
    let names: Vec<&Value> = bases.iter().map(|it| &it["basis"]).collect();
    assert_eq!(names, ["bernstein", "said_ball", "wang_ball", "bspline"]);
    bases
}

/// At t = i/m the least eigenvalue of Bernstein polynomials is m!/m^m. The same parameters in numbers
/// give the same, computed.
#[tokio::test]
async fn the_least_eigenvalue_of_bernstein_is_known() {
    let server = Server::start().await;
    for m in [1, 2, 3, 5, 10, 15] {
        let exact: f64 = (1..=m).map(|i| f64::from(i) / f64::from(m)).product();
        let steps: Vec<String> = (0..=m)
            .map(|i| format!("{}", f64::from(i) / f64::from(m)))
            .collect();
        for query in [
            format!("points={}", m + 1),
            format!("parameters={}", steps.join(",")),
        ] {
            let bernstein = &bases(&server, &query).await[0];
            let found = number(&bernstein["lambda_min"]);
            assert!((found / exact - 1.0).abs() < 1e-9, "{m}: {found} {exact}");
            assert!((number(&bernstein["rate"]) - (1.0 - exact)).abs() < 1e-12);
            assert_eq!(bernstein["degree"], m);
        }
    }
    // However small it is.
    let bernstein = &bases(&server, "points=30").await[0];
    assert!((number(&bernstein["lambda_min"]) / 3.4436e-12 - 1.0).abs() < 1e-3);
    assert!(bernstein["iterations"].as_u64().unwrap() > 1_000_000_000_000);
}

/// DP07, Theorem 4: the normalized B-basis is the fastest of its space. Bernstein beats Said–Ball, at
/// any parameters.
#[tokio::test]
async fn the_normalized_b_basis_is_the_fastest() {
    let server = Server::start().await;
    let mut queries: Vec<String> = (4..=14).map(|points| format!("points={points}")).collect();
    queries.push("parameters=0,0.1,0.15,0.4,0.7,0.9,1".to_owned());
    queries.push("parameters=-3,-1,0,2,2.5,7".to_owned());
    for query in queries {
        let bases = bases(&server, &query).await;
        let (bernstein, ball) = (&bases[0], &bases[1]);
        let rates = (number(&bernstein["rate"]), number(&ball["rate"]));
        assert!(rates.0 < rates.1, "{query}: {rates:?}");
        assert!(bernstein["iterations"].as_u64() <= ball["iterations"].as_u64());
    }
    // DP07, Table 1 is about 11 points, which are the default.
    assert_eq!(server.json("/v1/rates").await["points"], 11);
    let bases = bases(&server, "points=11&tolerance=1e-3").await;
    assert!(number(&bases[0]["rate"]) < number(&bases[1]["rate"]));
}

/// The rate and the iterations of a comparison are those of a fit with the same parameters.
#[tokio::test]
async fn rates_are_those_of_fits() {
    let server = Server::start().await;
    for degree in [3, 5] {
        let bases = bases(&server, &format!("points=11&degree={degree}")).await;
        for basis in [&bases[0], &bases[1], &bases[3]] {
            let mut of_fit = json!({"kind": basis["basis"]});
            if basis["basis"] == "bspline" {
                of_fit["degree"] = json!(degree);
                assert_eq!(basis["degree"], degree);
            }
            let points: Vec<[i32; 2]> = (0..11).map(|i| [i, i * i % 7]).collect();
            let job = server
                .fit(&json!({
                    "curve": {"points": points, "basis": of_fit, "parameters": "uniform"},
                    "stop": {"max_iterations": 1},
                }))
                .await;
            let expected = number(&job["predicted"]["rate"]);
            assert!((number(&basis["rate"]) - expected).abs() < 1e-9, "{basis}");
            let count = (1e-6_f64.ln() / expected.ln()).ceil();
            let found = number(&basis["iterations"]);
            assert!((found / count - 1.0).abs() < 1e-3, "{found} {count}");
        }
    }
    // Uniform cubic B-splines: λ_min is .3449 of 11 points, and nearly 1/3 of 500.
    let spline = &bases(&server, "points=500").await[3];
    assert!((number(&spline["lambda_min"]) - 1.0 / 3.0).abs() < 1e-3);
}

/// What rounding hides, and what would take too long, is left out.
#[tokio::test]
async fn unknown_rates_are_null() {
    let server = Server::start().await;
    let bases = bases(&server, "points=60&parameters=uniform").await;
    assert!(bases[0]["lambda_min"].is_number() && bases[0]["iterations"].is_null());
    assert!(bases[1]["lambda_min"].is_null() && bases[1]["rate"].is_null());
    assert!(bases[3]["iterations"].is_number());
}

/// The same numbers in messages.
#[tokio::test]
async fn messages_compare_alike() {
    let server = Server::start().await;
    let mut client = connect(&server).await;
    let parameters = vec![0.0, 0.2, 0.5, 0.9, 1.0];
    let request = pb::CompareBasesRequest {
        parameters,
        degree: Some(2),
        tolerance: Some(1e-3),
        ..Default::default()
    };
    let compared = client.compare_bases(request).await.unwrap().into_inner();
    let json = server
        .json("/v1/rates?parameters=0,0.2,0.5,0.9,1&degree=2&tolerance=1e-3")
        .await;
    assert_eq!((json["points"].as_u64(), compared.points), (Some(5), 5));
    for (basis, json) in compared.bases.iter().zip(json["bases"].as_array().unwrap()) {
        let name = json["basis"].as_str().unwrap().to_uppercase();
        assert_eq!(basis.basis().as_str_name(), format!("BASIS_KIND_{name}"));
        assert_eq!(json["degree"], basis.degree);
        assert_eq!(json["lambda_min"].as_f64(), basis.lambda_min);
        assert_eq!(json["rate"].as_f64(), basis.rate);
        assert_eq!(json["iterations"].as_u64(), basis.iterations);
    }
    for (request, part) in [
        (
            pb::CompareBasesRequest {
                points: 501,
                ..Default::default()
            },
            "points",
        ),
        (
            pb::CompareBasesRequest {
                parameters: vec![0.0, f64::NAN],
                ..Default::default()
            },
            "parameters",
        ),
        (
            pb::CompareBasesRequest {
                points: 5,
                degree: Some(0),
                ..Default::default()
            },
            "degree",
        ),
        (
            pb::CompareBasesRequest {
                points: 5,
                tolerance: Some(2.0),
                ..Default::default()
            },
            "tolerance",
        ),
    ] {
        let refused = client.compare_bases(request).await.unwrap_err();
        assert_eq!(refused.code(), Code::InvalidArgument);
        assert!(
            refused.message().starts_with(&format!("{part}: ")),
            "{refused:?}"
        );
    }
}

#[tokio::test]
async fn wrong_queries_are_refused() {
    let server = Server::start().await;
    let many = vec!["1"; 501].join(",");
    for (query, part, reason) in [
        ("points=1".into(), "points", "between 2 and 500"),
        ("points=501".into(), "points", "between 2 and 500"),
        ("points=many".into(), "points", "not a whole number"),
        (
            "points=11&parameters=chord_length".into(),
            "parameters",
            "no number",
        ),
        (
            "points=3&parameters=0,1".into(),
            "parameters",
            "2 parameters for 3 points",
        ),
        ("parameters=0,1,1".into(), "parameters", "strictly increase"),
        ("parameters=0,nan,1".into(), "parameters", "no number"),
        ("parameters=3".into(), "parameters", "between 2 and 500"),
        (format!("parameters={many}"), "parameters", "more than 500"),
        ("points=5&degree=0".into(), "degree", "between 1 and 100"),
        ("points=5&degree=101".into(), "degree", "between 1 and 100"),
        (
            "points=5&tolerance=0".into(),
            "tolerance",
            "between 0 and 1",
        ),
        (
            "points=5&tolerance=1".into(),
            "tolerance",
            "between 0 and 1",
        ),
        ("points=5&kind=bernstein".into(), "kind", ""),
    ] {
        let response = server
            .get(&format!("/v1/rates?{query}"))
            .send()
            .await
            .unwrap();
        let (status, answer) = problem(response).await;
        assert_eq!(status, 400, "{query}");
        let detail = answer["detail"].as_str().unwrap();
        assert!(
            detail.contains(part) && detail.contains(reason),
            "{query}: {detail}"
        );
    }
}
