//! The tokens file: what changes it keeps its links, its owner and its mode; each change is noticed; and a server that
//! cannot read it any more says so.

use std::fs;
use std::path::Path;
use std::process::Command;

use reqwest::Method;
use serde_json::{Value, json};

use crate::data;
use crate::program::{PROGRAM, Program};
use crate::support::{eventually, problem};
use crate::tokens_file::TokensFile;

async fn status(server: &Program, path: &str, token: &str) -> u16 {
    let request = server.get(path).bearer_auth(token);
    request.send().await.unwrap().status().as_u16()
}

/// What a command for a tokens file says on the standard error, and whether it has succeeded.
fn run(verb: &str, path: &Path, arguments: &[&str]) -> (bool, String) {
    let mut command = Command::new(PROGRAM);
    command.args(["token", verb, "--tokens"]).arg(path);
    let output = command.args(arguments).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    (output.status.success(), said)
}

#[cfg(unix)]
#[tokio::test]
async fn a_token_is_revoked_in_the_file_behind_a_link() {
    let file = TokensFile::new();
    let token = file.token("default", "jobs:read");
    let id = file.last_id();
    let (target, link) = (file.path(), file.folder.path().join("link.toml"));
    std::os::unix::fs::symlink(&target, &link).unwrap();
    let server = Program::with(
        &file.folder.path().join("data"),
        &["--tokens", link.to_str().unwrap()],
    );
    assert_eq!(status(&server, "/v1/jobs", &token).await, 200);
    assert!(run("revoke", &link, &[&id]).0);
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert!(!fs::read_to_string(&target).unwrap().contains(&id));
    eventually("it is revoked", async || {
        status(&server, "/v1/jobs", &token).await == 401
    })
    .await;
    // A link to nothing is not replaced by a file.
    let nowhere = file.folder.path().join("nowhere.toml");
    std::os::unix::fs::symlink(file.folder.path().join("missing"), &nowhere).unwrap();
    let (made, said) = run("create", &nowhere, &[]);
    assert!(
        !made && said.contains("a link to a file that is not there"),
        "{said}"
    );
}

#[cfg(unix)]
#[test]
fn a_changed_file_keeps_its_owner_and_its_mode() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
    let file = TokensFile::new();
    file.token("default", "jobs:read");
    fs::set_permissions(file.path(), fs::Permissions::from_mode(0o640)).unwrap();
    // Only root may give files away.
    let other = chown(file.path(), Some(65_534), Some(65_534)).is_ok();
    let of = || {
        let about = fs::metadata(file.path()).unwrap();
        (about.uid(), about.gid(), about.mode() & 0o777)
    };
    let before = of();
    assert!(!other || before == (65_534, 65_534, 0o640));
    file.token("default", "jobs:read");
    file.revoke(&file.last_id());
    assert_eq!(of(), before);
    // Another name of the file would keep what is revoked.
    let (id, name) = (file.last_id(), file.folder.path().join("other.toml"));
    fs::hard_link(file.path(), &name).unwrap();
    let (revoked, said) = run("revoke", &file.path(), &[&id]);
    assert!(!revoked && said.contains("hard links"), "{said}");
    assert!(fs::read_to_string(file.path()).unwrap().contains(&id));
}

/// The text between quotation marks that follows the last place of a word.
fn last_value(content: &str, word: &str) -> String {
    let (_, rest) = content.rsplit_once(word).unwrap();
    rest.split('"').nth(1).unwrap().to_owned()
}

#[tokio::test]
async fn a_change_of_equal_time_and_length_is_noticed() {
    let file = TokensFile::new();
    let first = file.token("default", "jobs:read");
    let before = fs::read_to_string(file.path()).unwrap();
    let second = file.token("default", "jobs:read");
    let both = fs::read_to_string(file.path()).unwrap();
    let (one, other) = (last_value(&before, "hash"), last_value(&both, "hash"));
    fs::write(file.path(), &before).unwrap();
    let time = fs::metadata(file.path()).unwrap().modified().unwrap();
    let server = file.server(&[]);
    assert_eq!(status(&server, "/v1/jobs", &first).await, 200);
    let changed = before.replace(&one, &other);
    assert_eq!(changed.len(), before.len());
    let new = file.folder.path().join("new");
    fs::write(&new, changed).unwrap();
    let opened = fs::File::options().write(true).open(&new).unwrap();
    opened.set_modified(time).unwrap();
    fs::rename(&new, file.path()).unwrap();
    eventually("the second counts", async || {
        status(&server, "/v1/jobs", &second).await == 200
    })
    .await;
    assert_eq!(status(&server, "/v1/jobs", &first).await, 401);
}

#[tokio::test]
async fn a_server_that_cannot_read_the_file_any_more_is_not_ready() {
    let file = TokensFile::new();
    let token = file.token("default", "jobs:read");
    let server = file.server(&[]);
    let content = fs::read(file.path()).unwrap();
    let ready = async || server.get("/readyz").send().await.unwrap();
    for bytes in [None, Some(&b""[..]), Some(&content[..content.len() / 2])] {
        assert_eq!(ready().await.status(), 200);
        match bytes {
            None => fs::remove_file(file.path()).unwrap(),
            Some(bytes) => fs::write(file.path(), bytes).unwrap(),
        }
        eventually("it is not ready", async || ready().await.status() == 503).await;
        let (_, answer) = problem(ready().await).await;
        assert_eq!(answer["type"], "/problems/tokens-unreadable");
        let detail = answer["detail"].as_str().unwrap();
        assert!(detail.contains("cannot be read"), "{detail}");
        assert!(!detail.contains(file.path().to_str().unwrap()), "{detail}");
        assert_eq!(status(&server, "/v1/jobs", &token).await, 200);
        file.put(&content);
        eventually("it is ready again", async || ready().await.status() == 200).await;
    }
    let log = server.log();
    assert!(log.contains("the tokens before stay in use"), "{log}");
    assert!(log.contains("tokens.toml: No such file"), "{log}");
    assert!(
        log.contains("its last line is not `# end of file`"),
        "{log}"
    );
}

/// A server does not start with a file that is empty or cut off, and no command changes one.
#[test]
fn a_file_that_is_cut_off_is_no_file_of_tokens() {
    let file = TokensFile::new();
    file.token("default", "jobs:read");
    file.add("[tenant.cad]\njobs = 5\nstreams = 7");
    let content = fs::read(file.path()).unwrap();
    let quota = content.windows(7).position(|it| it == b"streams").unwrap();
    for length in [0, content.len() - 3, quota] {
        fs::write(file.path(), &content[..length]).unwrap();
        let mut server = Command::new("timeout");
        server.args(["-s", "KILL", "20", PROGRAM, "--store", ":memory:"]);
        server.args(["--listen", "127.0.0.1:0", "--tokens"]);
        let output = server.arg(file.path()).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{length}");
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains("its last line is not"), "{said}");
        for (verb, arguments) in [("list", &[][..]), ("create", &[]), ("revoke", &["a"])] {
            let (done, said) = run(verb, &file.path(), arguments);
            assert!(
                !done && said.contains("its last line is not"),
                "{verb}: {said}"
            );
        }
    }
}

/// A token of a tenant reads nothing of what is counted for other tenants.
#[tokio::test]
async fn metrics_of_other_tenants_need_a_scope_of_their_own() {
    let file = TokensFile::new();
    let tenants = ["a", "b"].map(|it| (it, file.token(it, "jobs:write,metrics")));
    let (all, admin) = (file.token("a", "metrics:all"), file.token("a", "admin"));
    let server = file.server(&[]);
    for (_, token) in &tenants {
        let job = json!({"curve": {"points": data::wave(20)}});
        let request = server.post("/v1/jobs").bearer_auth(token).json(&job);
        assert_eq!(request.send().await.unwrap().status(), 201);
    }
    let metrics = async |token: &str| {
        let request = server.get("/metrics").bearer_auth(token);
        let response = request.send().await.unwrap();
        assert_eq!(response.status(), 200);
        response.text().await.unwrap()
    };
    let has = |text: &str, tenant: &str| {
        ["jobs", "points"].map(|it| {
            let name = format!("piad_tenant_{it}_total{{tenant=\"{tenant}\"}}");
            text.contains(&name)
        })
    };
    for (tenant, token) in &tenants {
        let text = metrics(token).await;
        let other = if *tenant == "a" { "b" } else { "a" };
        assert_eq!(
            (has(&text, tenant), has(&text, other)),
            ([true; 2], [false; 2])
        );
        assert!(text.contains("piad_jobs_accepted_total 2"), "{text}");
    }
    for token in [&all, &admin] {
        let text = metrics(token).await;
        assert_eq!((has(&text, "a"), has(&text, "b")), ([true; 2], [true; 2]));
    }
    // It reads nothing else.
    let jobs = server
        .client
        .request(Method::GET, format!("http://{}/v1/jobs", server.address));
    let answer: Value = jobs
        .bearer_auth(&all)
        .send()
        .await
        .unwrap()
        .json()
        .await
        .unwrap();
    assert_eq!(answer["type"], "/problems/forbidden");
}
