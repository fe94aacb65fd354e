//! Tokens: every route and every call with none, with such that are not valid, with those of others, and with the
//! right one.

use std::collections::BTreeSet;
use std::fs;
use std::process::Command;

use reqwest::{Method, Response};
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::data;
use crate::program::{PROGRAM, Program};
use crate::support::{Story, base, eventually};
use crate::tokens_file::TokensFile;

const ALL: &str = "jobs:read,jobs:write,metrics";

async fn ask(server: &Program, method: Method, path: &str, token: Option<&str>) -> Response {
    let url = format!("http://{}{path}", server.address);
    let mut request = server.client.request(method.clone(), url);
    if let Some(token) = token {
        request = request.bearer_auth(token);
    }
    if method == Method::POST {
        request = request.json(&json!({"curve": {"points": data::wave(5)}}));
    }
    request.send().await.unwrap()
}

async fn status(server: &Program, method: Method, path: &str, token: Option<&str>) -> u16 {
    ask(server, method, path, token).await.status().as_u16()
}

/// Makes a job with a token, and waits for its end.
async fn fit(server: &Program, token: &str) -> Value {
    let request = server.post("/v1/jobs").header("prefer", "wait=100");
    let request = request.bearer_auth(token);
    let job = json!({"curve": {"points": data::wave(20)}});
    let response = request.json(&job).send().await.unwrap();
    assert_eq!(response.status(), 201);
    response.json().await.unwrap()
}

fn id_of(job: &Value) -> String {
    job["id"].as_str().unwrap().to_owned()
}

/// What a token for each purpose is good for.
struct Case {
    name: &'static str,
    token: Option<String>,
    expected: Expected,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Expected {
    /// 401.
    Unauthenticated,
    /// 404 for jobs of others, else as with the right one.
    Stranger,
    /// Neither.
    Answer,
}

fn cases(file: &TokensFile) -> Vec<Case> {
    use Expected::*;
    let case = |name, token, expected| Case {
        name,
        token,
        expected,
    };
    let right = file.token("a", ALL);
    let stranger = file.token("b", ALL);
    let revoked = file.token("a", ALL);
    file.revoke(&file.last_id());
    let expired = file.token("a", ALL);
    let text = fs::read_to_string(file.path()).unwrap();
    let (before, last) = text.rsplit_once("expires = ").unwrap();
    let (_, rest) = last.split_once('\n').unwrap();
    fs::write(
        file.path(),
        format!("{before}expires = \"2020-01-01T00:00:00Z\"\n{rest}"),
    )
    .unwrap();
    let other = if right.ends_with('A') { 'B' } else { 'A' };
    let similar = format!("{}{other}", &right[..right.len() - 1]);
    vec![
        case("none", None, Unauthenticated),
        case("similar", Some(similar), Unauthenticated),
        case("empty", Some(String::new()), Unauthenticated),
        case("revoked", Some(revoked), Unauthenticated),
        case("expired", Some(expired), Unauthenticated),
        case("of another tenant", Some(stranger), Stranger),
        case("right", Some(right), Answer),
    ]
}

/// The scope that an operation needs by the description of the API.
fn needed(operation: &Value) -> Option<String> {
    let scope = operation.pointer("/security/0/token/0")?;
    Some(scope.as_str().unwrap().to_owned())
}

/// Every route with every kind of token.
#[tokio::test]
async fn every_route_requires_its_token() {
    let file = TokensFile::new();
    let cases = cases(&file);
    let scopes = ["jobs:read", "jobs:write", "metrics"];
    let without = |scope: &str| {
        let others = scopes.into_iter().filter(|it| *it != scope);
        others.collect::<Vec<_>>().join(",")
    };
    let too_small = scopes.map(|scope| file.token("a", &without(scope)));
    let server = file.server(&["--log", "debug"]);
    let right = cases.last().unwrap().token.clone().unwrap();
    let id = fit(&server, &right).await["id"]
        .as_str()
        .unwrap()
        .to_owned();
    let description = server.json("/openapi.json").await;
    let mut guarded = 0;
    for (template, operations) in description["paths"].as_object().unwrap() {
        let path = template.replace("{k}", "0");
        let path = path
            .replace("{format}", "svg")
            .replace("{slug}", "not-found");
        for (verb, operation) in operations.as_object().unwrap() {
            let method: Method = verb.to_uppercase().parse().unwrap();
            let id = match verb == "delete" {
                true => id_of(&fit(&server, &right).await),
                false => id.clone(),
            };
            let path = path.replace("{id}", &id);
            let Some(scope) = needed(operation) else {
                let status = status(&server, method, &path, None).await;
                assert!(![401, 403].contains(&status), "{verb} {template}: {status}");
                assert!(
                    !template.starts_with("/v1") && template != "/metrics",
                    "{template}"
                );
                continue;
            };
            guarded += 1;
            let place = scopes.iter().position(|it| *it == scope).unwrap();
            let small = &too_small[place];
            let status = status(&server, method.clone(), &path, Some(small)).await;
            assert_eq!(status, 403, "{verb} {template} without {scope}");
            for case in &cases {
                // The right one is the last, and may delete the job.
                let response = ask(&server, method.clone(), &path, case.token.as_deref()).await;
                let (status, headers) = (response.status().as_u16(), response.headers().clone());
                let what = format!("{verb} {template}, {}: {status}", case.name);
                let is_of_job = template.contains("{id}");
                match case.expected {
                    Expected::Unauthenticated => {
                        assert_eq!(status, 401, "{what}");
                        let challenge = headers["www-authenticate"].to_str().unwrap();
                        assert!(challenge.starts_with("Bearer realm=\"piad\""), "{what}");
                        let problem: Value = response.json().await.unwrap();
                        assert_eq!(problem["type"], "/problems/unauthenticated");
                    }
                    Expected::Stranger if is_of_job => {
                        assert_eq!(status, 404, "{what}");
                        let problem: Value = response.json().await.unwrap();
                        assert_eq!(problem["type"], "/problems/unknown-job");
                    }
                    Expected::Stranger => assert!(![401, 403].contains(&status), "{what}"),
                    Expected::Answer => {
                        assert!(![401, 403].contains(&status) && status < 500, "{what}");
                        assert!(status != 404 || verb == "post", "{what}");
                    }
                }
            }
        }
    }
    assert!(guarded >= 20, "{guarded}");
    // No output contains a token.
    let metrics = ask(&server, Method::GET, "/metrics", Some(&right)).await;
    let reported = server.log() + &metrics.text().await.unwrap();
    for token in cases
        .iter()
        .filter_map(|it| it.token.as_ref())
        .chain(&too_small)
    {
        assert!(token.is_empty() || !reported.contains(token.as_str()));
    }
    for reason in ["missing", "unknown", "expired", "scope"] {
        assert!(
            reported.contains(&format!("piad_denied_total{{reason=\"{reason}\"}}")),
            "{reason}"
        );
    }
    assert!(reported.contains("a request was denied"));
}

/// Every call with every kind of token, as bytes: what is denied is denied before a message is read.
#[tokio::test]
async fn every_call_requires_its_token() {
    let file = TokensFile::new();
    let cases = cases(&file);
    let reader = file.token("a", "jobs:read");
    let writer = file.token("a", "jobs:write");
    let server = file.server(&[]);
    let client = reqwest::Client::builder().http2_prior_knowledge();
    let client = client.build().unwrap();
    let call = async |path: &str, token: Option<&str>| {
        let mut request = client.post(format!("http://{}{path}", server.address));
        if let Some(token) = token {
            request = request.bearer_auth(token);
        }
        let request = request.header("content-type", "application/grpc");
        let request = request.header("te", "trailers").body(vec![0; 5]);
        let response = request.send().await.unwrap();
        let status = response.headers().get("grpc-status");
        status.map(|it| it.to_str().unwrap().to_owned())
    };
    let (unauthenticated, denied) = (Some("16".to_owned()), Some("7".to_owned()));
    let reads = [
        "GetJob",
        "ListJobs",
        "GetIteration",
        "GetResult",
        "GetDeviation",
        "GetInput",
        "CompareBases",
        "WatchJob",
    ];
    let writes = ["CreateJob", "Fit", "CancelJob", "DeleteJob", "EditJob"];
    for (names, wrong_scope) in [(&reads[..], &writer), (&writes[..], &reader)] {
        for name in names {
            let path = format!("/piad.v1.FittingService/{name}");
            assert_eq!(call(&path, Some(wrong_scope)).await, denied, "{name}");
            for case in &cases {
                let status = call(&path, case.token.as_deref()).await;
                let what = format!("{name}, {}: {status:?}", case.name);
                match case.expected {
                    Expected::Unauthenticated => assert_eq!(status, unauthenticated, "{what}"),
                    _ => assert!(status != unauthenticated && status != denied, "{what}"),
                }
            }
        }
    }
    // A call that there is not needs a token, too; health needs none.
    let unknown = "/piad.v1.FittingService/Unknown";
    assert_eq!(call(unknown, None).await, unauthenticated);
    let health = call("/grpc.health.v1.Health/Check", None).await;
    assert_ne!(health, unauthenticated);
}

/// Paths, methods and headers that mean something else elsewhere.
#[tokio::test]
async fn nothing_gets_around_a_token() {
    let file = TokensFile::new();
    let token = file.token("default", ALL);
    let server = file.server(&[]);
    let raw = async |line: &str, headers: &str| {
        let mut stream = TcpStream::connect(&server.address).await.unwrap();
        let request =
            format!("{line} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n{headers}\r\n");
        stream.write_all(request.as_bytes()).await.unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).await.unwrap();
        answer.split(' ').nth(1).unwrap().parse::<u16>().unwrap()
    };
    for path in [
        "//v1/jobs",
        "/v1//jobs",
        "/v1/jobs/",
        "/./v1/jobs",
        "/v1/./jobs",
        "/v1/x/../jobs",
        "/%76%31/jobs",
        "/v1/%6aobs",
        "/v1%2fjobs",
        "/V1/jobs",
        "/v1/jobs;a=b",
        "/v1/jobs%00",
        "/livez/../v1/jobs",
        "/livez%2f..%2fv1/jobs",
        "http://localhost/v1//jobs",
    ] {
        let status = raw(&format!("GET {path}"), "").await;
        assert!([400, 401, 404].contains(&status), "{path}: {status}");
    }
    for line in [
        "GET /v1/jobs",
        "HEAD /v1/jobs",
        "GET http://localhost/v1/jobs",
        "GET /v1/jobs?a=b",
    ] {
        assert_eq!(raw(line, "").await, 401, "{line}");
    }
    for method in ["OPTIONS", "PUT", "PATCH", "TRACE", "get"] {
        let status = raw(&format!("{method} /v1/jobs"), "").await;
        assert!([405, 401].contains(&status), "{method}: {status}");
    }
    for header in [
        "X-HTTP-Method-Override: GET",
        "X-Original-URL: /livez",
        "X-Rewrite-URL: /livez",
        "X-Forwarded-User: admin",
        "Forwarded: for=127.0.0.1",
        "Proxy-Authorization: Bearer TOKEN",
        "Cookie: token=TOKEN",
        "Authorization: Basic TOKEN",
        "Authorization: TOKEN",
        "Authorization: Bearer",
        "Authorization: Bearer TOKEN\r\nAuthorization: Bearer TOKEN",
        "Authorization: Bearer TOKEN, Bearer TOKEN",
    ] {
        let headers = format!("{}\r\n", header.replace("TOKEN", &token));
        assert_eq!(raw("GET /v1/jobs", &headers).await, 401, "{header}");
    }
    for query in ["token", "access_token", "ticket"] {
        assert_eq!(
            raw(&format!("GET /v1/jobs?{query}={token}"), "").await,
            401,
            "{query}"
        );
    }
    for scheme in ["Bearer", "bearer", "BEARER"] {
        let headers = format!("Authorization: {scheme} {token}\r\n");
        assert_eq!(raw("GET /v1/jobs", &headers).await, 200, "{scheme}");
    }
}

#[tokio::test]
async fn a_tenant_knows_of_its_own_jobs_alone() {
    let file = TokensFile::new();
    let (a, b) = (file.token("a", ALL), file.token("b", ALL));
    let server = file.server(&[]);
    let keyed = async |token: &str| {
        let request = server.post("/v1/jobs").bearer_auth(token);
        let request = request
            .header("idempotency-key", "the same")
            .header("prefer", "wait=100");
        let job = json!({"curve": {"points": data::wave(20)}});
        let response = request.json(&job).send().await.unwrap();
        assert_eq!(response.status(), 201);
        let replayed = response.headers().contains_key("idempotency-replayed");
        (response.json::<Value>().await.unwrap(), replayed)
    };
    let ((mine, _), (theirs, replayed)) = (keyed(&a).await, keyed(&b).await);
    assert!(mine["id"] != theirs["id"] && !replayed);
    let (again, replayed) = keyed(&a).await;
    assert!(mine["id"] == again["id"] && replayed);
    for _ in 0..4 {
        fit(&server, &b).await;
    }
    // Lists and their cursors.
    let mut seen = BTreeSet::new();
    let mut next = Some("/v1/jobs?limit=2".to_owned());
    while let Some(path) = next {
        let page: Value = ask(&server, Method::GET, &path, Some(&b))
            .await
            .json()
            .await
            .unwrap();
        for job in page["jobs"].as_array().unwrap() {
            assert!(seen.insert(job["id"].as_str().unwrap().to_owned()));
        }
        next = page["next"].as_str().map(str::to_owned);
    }
    assert_eq!(seen.len(), 5);
    assert!(!seen.contains(mine["id"].as_str().unwrap()));
    // A cursor that is the id of a job of another tenant is a point in time, and reveals nothing about it.
    let path = format!("/v1/jobs?cursor={}", mine["id"].as_str().unwrap());
    let page: Value = ask(&server, Method::GET, &path, Some(&b))
        .await
        .json()
        .await
        .unwrap();
    assert_eq!(page["jobs"], json!([]));
    // A job that there is and one that there is not are answered the same.
    let nobody = mine["id"]
        .as_str()
        .unwrap()
        .replace(|c: char| c.is_ascii_digit(), "0");
    let reported = async |id: &str| {
        let path = format!("/v1/jobs/{id}");
        let problem: Value = ask(&server, Method::GET, &path, Some(&b))
            .await
            .json()
            .await
            .unwrap();
        problem["detail"].as_str().unwrap().replace(id, "ID")
    };
    assert_eq!(
        reported(mine["id"].as_str().unwrap()).await,
        reported(&nobody).await
    );
    // What it made is still its own after a restart, and the other's is not.
    drop(server);
    let server = file.server(&[]);
    assert_eq!(
        status(&server, Method::GET, base(&mine), Some(&a)).await,
        200
    );
    assert_eq!(
        status(&server, Method::GET, base(&mine), Some(&b)).await,
        404
    );
    assert_eq!(
        status(&server, Method::DELETE, base(&mine), Some(&b)).await,
        404
    );
    assert_eq!(
        status(&server, Method::DELETE, base(&mine), Some(&a)).await,
        204
    );
}

#[tokio::test]
async fn a_ticket_opens_the_stream_of_its_job() {
    let file = TokensFile::new();
    let (a, b) = (
        file.token("a", "jobs:read,jobs:write"),
        file.token("b", ALL),
    );
    let id = file.run("list", &[]);
    let id = String::from_utf8(id.stdout).unwrap();
    let id = id.split_whitespace().next().unwrap().to_owned();
    let server = file.server(&["--log", "debug"]);
    let (job, other) = (fit(&server, &a).await, fit(&server, &a).await);
    let tickets = format!("{}/tickets", base(&job));
    let made = ask(&server, Method::POST, &tickets, Some(&a)).await;
    assert_eq!(made.status(), 201);
    let made: Value = made.json().await.unwrap();
    let ticket = made["ticket"].as_str().unwrap();
    assert!(made["expires"].as_str().unwrap().ends_with('Z'));

    let events = |job: &Value, query: &str| format!("{}/events?{query}ticket={ticket}", base(job));
    for query in ["", "view=errors&"] {
        let response = ask(&server, Method::GET, &events(&job, query), None).await;
        assert_eq!(response.status(), 200);
        let story = Story::read(response).await;
        assert_eq!(story.end["state"], "converged");
    }
    // Nothing else.
    assert_eq!(
        status(&server, Method::GET, &events(&other, ""), None).await,
        401
    );
    let result = format!("{}/result?ticket={ticket}", base(&job));
    assert_eq!(status(&server, Method::GET, &result, None).await, 401);
    assert_eq!(
        status(&server, Method::GET, base(&job), Some(ticket)).await,
        401
    );
    assert_eq!(status(&server, Method::POST, &tickets, Some(&b)).await, 404);
    // A token counts before a ticket.
    assert_eq!(
        status(&server, Method::GET, &events(&job, ""), Some(&b)).await,
        404
    );
    assert!(!server.log().contains(ticket));
    // It ends with its token.
    file.revoke(&id);
    eventually("it is revoked", async || {
        status(&server, Method::GET, &events(&job, ""), None).await == 401
    })
    .await;

    let open = Program::start(file.folder.path().join("open").as_path());
    let job = open.fit(&json!({"curve": {"points": data::wave(5)}})).await;
    let response = open
        .post(&format!("{}/tickets", base(&job)))
        .send()
        .await
        .unwrap();
    assert_eq!(response.status(), 409);
    let path = format!("{}/events?ticket={ticket}", base(&job));
    assert_eq!(open.get(&path).send().await.unwrap().status(), 200);
}

#[tokio::test]
async fn tokens_come_and_go_while_the_server_runs() {
    let file = TokensFile::new();
    let first = file.token("default", ALL);
    let server = file.server(&[]);
    let answers = async |token: &str| status(&server, Method::GET, "/v1/jobs", Some(token)).await;
    assert_eq!(answers(&first).await, 200);
    let second = file.token("default", ALL);
    server.signal("-HUP");
    eventually("the second", async || answers(&second).await == 200).await;
    // A file that is none changes nothing.
    let content = fs::read_to_string(file.path()).unwrap();
    fs::write(file.path(), "token = 5").unwrap();
    eventually("a failure", async || {
        let metrics = ask(&server, Method::GET, "/metrics", Some(&first)).await;
        metrics
            .text()
            .await
            .unwrap()
            .contains("piad_reloads_failed_total 1")
    })
    .await;
    assert!(server.log().contains("the tokens before stay in use"));
    assert_eq!(answers(&second).await, 200);
    fs::write(file.path(), content).unwrap();
    file.revoke(&file.last_id());
    eventually("it is revoked", async || answers(&second).await == 401).await;
    assert_eq!(answers(&first).await, 200);
}

#[tokio::test]
async fn a_server_for_the_network_needs_tokens() {
    let folder = tempfile::tempdir().unwrap();
    let start = |arguments: &[&str], token: Option<&str>| {
        let mut command = Command::new("timeout");
        command.args([
            "-s",
            "KILL",
            "3",
            PROGRAM,
            "--listen",
            "0.0.0.0:0",
            "--store",
            ":memory:",
        ]);
        command.args(arguments).env_remove("PIAD_TOKEN");
        command.envs(token.map(|token| ("PIAD_TOKEN", token)));
        let output = command.output().unwrap();
        String::from_utf8(output.stderr).unwrap()
    };
    let refused = start(&[], None);
    for word in ["--tokens", "--tls-client-ca", "--insecure-no-auth"] {
        assert!(refused.contains(word), "{refused}");
    }
    assert!(!refused.contains("listening"));
    let short = start(&[], Some("too short"));
    assert!(short.contains("at least 32 characters"), "{short}");
    assert!(start(&["--insecure-no-auth"], None).contains("listening on"));
    let long = "a-token-that-cannot-be-guessed-as-it-is-long";
    let said = start(&[], Some(long));
    assert!(
        said.contains("listening on") && said.contains("tokens are sent over the network"),
        "{said}"
    );
    assert!(!said.contains(long));

    let file = folder.path().join("tokens.toml");
    for (content, reported) in [
        ("token = 5", "tokens.toml"),
        ("[[token]]\nid = 'a'", "missing field"),
        ("other = 5", "unknown field"),
    ] {
        fs::write(&file, content).unwrap();
        let said = start(&["--tokens", file.to_str().unwrap()], None);
        assert!(
            said.contains("--tokens") && said.contains(reported),
            "{content}: {said}"
        );
    }
    let said = start(&["--tokens", "/nowhere/tokens.toml"], None);
    assert!(
        said.contains("/nowhere/tokens.toml: No such file"),
        "{said}"
    );
}

#[tokio::test]
async fn a_token_of_the_variable_is_good_for_everything() {
    let folder = tempfile::tempdir().unwrap();
    let token = "a-token-that-cannot-be-guessed-as-it-is-long";
    let script = format!("export PIAD_TOKEN={token}; exec \"$@\"");
    let server = Program::in_shell(&script, folder.path());
    for path in ["/v1/jobs", "/metrics", "/v1/capabilities"] {
        assert_eq!(status(&server, Method::GET, path, Some(token)).await, 200);
        assert_eq!(status(&server, Method::GET, path, None).await, 401);
    }
    // The command has it from the same variable.
    let points = folder.path().join("points.csv");
    fs::write(&points, "0,0\n1,2\n3,1\n4,3\n").unwrap();
    let fit = |token: &str| {
        let mut command = Command::new(PROGRAM);
        command.arg("fit").arg(&points).env("PIAD_TOKEN", token);
        let url = format!("http://{}", server.address);
        command.args(["--server", &url]).output().unwrap()
    };
    assert!(fit(token).status.success());
    let refused = fit("another-token-that-is-as-long-as-that-one");
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(said.contains("the token is not valid"), "{said}");
}

#[test]
fn tokens_are_printed_once_and_stored_as_hashes() {
    let file = TokensFile::new();
    let output = file.run(
        "create",
        &[
            "--tenant",
            "cad",
            "--expires",
            "24h",
            "--note",
            "of the lab",
        ],
    );
    assert!(output.status.success());
    let token = String::from_utf8(output.stdout).unwrap().trim().to_owned();
    assert!(token.starts_with("piad_") && token.len() == 48, "{token}");
    let reported = String::from_utf8(output.stderr).unwrap();
    assert!(
        reported.contains("jobs:read,jobs:write") && reported.contains("of the lab"),
        "{reported}"
    );
    let kept = fs::read_to_string(file.path()).unwrap();
    assert!(
        !kept.contains(&token) && !reported.contains(&token),
        "{kept}"
    );
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = fs::metadata(file.path()).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
    }
    let output = file.run("create", &["--expires", "never", "--scope", "metrics"]);
    assert!(output.status.success());
    let list = String::from_utf8(file.run("list", &[]).stdout).unwrap();
    let lines: Vec<_> = list.lines().collect();
    let [first, second] = lines[..] else {
        panic!("{list}");
    };
    assert!(
        first.contains("  cad  ") && first.contains("expires 20"),
        "{list}"
    );
    assert!(
        second.contains("  default  metrics  ") && second.contains("never expires"),
        "{list}"
    );
    let id = first.split_whitespace().next().unwrap();
    file.revoke(id);
    let again = file.run("revoke", &[id]);
    assert_eq!(again.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&again.stderr).contains(&format!("there is no token {id}")));
    for (arguments, reported) in [
        (["--tenant", "a b"], "the name of a tenant"),
        (["--expires", "soon"], "not a time such as 720h, or never"),
        (["--expires", "0h"], "not a time such as 720h, or never"),
        (["--scope", "jobs"], "invalid value 'jobs'"),
    ] {
        let output = file.run("create", &arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(
            !output.status.success() && said.contains(reported),
            "{arguments:?}: {said}"
        );
    }
    let elsewhere = Command::new(PROGRAM)
        .args(["token", "list", "--tokens", "/nowhere/tokens.toml"])
        .output()
        .unwrap();
    assert!(String::from_utf8_lossy(&elsewhere.stderr).contains("/nowhere/tokens.toml"));
}
