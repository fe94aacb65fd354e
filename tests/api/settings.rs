//! Settings: the precedence of flags, variables, the file and defaults, and errors in each.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::program::{PROGRAM, Program};

/// Runs the program with a file of settings and a variable.
fn run(arguments: &[&str], file: &Path, variables: &[(&str, &str)]) -> Output {
    let mut command = Command::new(PROGRAM);
    command.args(arguments).arg("--config").arg(file);
    command.envs(variables.iter().copied()).output().unwrap()
}

/// The settings that a server would have.
fn settings(
    content: &str,
    arguments: &[&str],
    variables: &[(&str, &str)],
) -> Result<String, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("piad.toml");
    fs::write(&file, content).unwrap();
    let arguments = [&["config"], arguments].concat();
    let output = run(&arguments, &file, variables);
    let text = |bytes: &[u8]| {
        let text = String::from_utf8(bytes.to_vec()).unwrap();
        text.replace(folder.path().to_str().unwrap(), "")
    };
    match output.status.code() {
        Some(0) => Ok(text(&output.stdout)),
        Some(2) => Err(text(&output.stderr)),
        other => panic!("{other:?}: {}", text(&output.stderr)),
    }
}

#[test]
fn flags_come_before_variables_before_the_file_before_the_defaults() {
    let file = "
        listen = ['127.0.0.1:9010', 'unix:/run/piad.sock']
        max-jobs = 500
        heartbeat = 2.5
        memory = '3GiB'
        retain-age = '36h'
        cors-origin = 'https://cad.example'
    ";
    let arguments = ["--heartbeat", "7", "--max-jobs", "600"];
    let variables = [("PIAD_MAX_JOBS", "400"), ("PIAD_MEMORY", "2GiB")];
    let shown = settings(file, &arguments, &variables).unwrap();
    for line in [
        "listen = [\"127.0.0.1:9010\", \"unix:/run/piad.sock\"]  # /piad.toml",
        "max-jobs = 600  # --max-jobs",
        "heartbeat = 7  # --heartbeat",
        "memory = \"2GiB\"  # PIAD_MEMORY",
        "retain-age = \"36h\"  # /piad.toml",
        "cors-origin = [\"https://cad.example\"]  # /piad.toml",
        "grace = 4  # the default",
        "# workers is not set",
    ] {
        assert!(shown.lines().any(|it| it == line), "{line} in\n{shown}");
    }
    // What is shown is a file with the same settings.
    let again = settings(&shown, &[], &[]).unwrap();
    let values = |shown: &str| -> Vec<String> {
        let lines = shown.lines();
        lines
            .map(|it| it.split("  #").next().unwrap().to_owned())
            .collect()
    };
    assert_eq!(values(&again), values(&shown));
}

#[test]
fn urls_of_databases_are_not_shown() {
    let file = "store = 'postgres://piad:secret@db.example/piad'";
    let shown = settings(file, &[], &[]).unwrap();
    assert!(!shown.contains("secret"), "{shown}");
    assert!(
        shown.contains("# store is a URL, which may hold a password  # /piad.toml"),
        "{shown}"
    );
}

/// Whatever form it has, and wherever it stands, no password is shown.
#[test]
fn passwords_are_not_shown() {
    let urls = [
        "postgres://piad:secret@db.example/piad",
        "POSTGRES://piad:secret@db.example/piad",
        "PostgreSQL://db.example/piad?user=piad&password=secret",
    ];
    let mistakes = [
        "postgres:/piad:secret@db.example/piad",
        "postgres:piad:secret@db.example/piad",
        "postgres//piad:secret@db.example/piad",
        "mysql://piad:secret@db.example/piad",
        "host=db.example password=secret user=piad",
        "host=db.example user=piad password = 'se secret'",
    ];
    let shown = |name: &str, value: &str| {
        let (flag, variable) = (format!("--{name}"), name.replace('-', "_").to_uppercase());
        let file = format!("{name} = {value:?}");
        [
            settings("", &[&flag, value], &[]),
            settings("", &[], &[(&format!("PIAD_{variable}"), value)]),
            settings(&file, &[], &[]),
        ]
    };
    for url in urls {
        for shown in shown("store", url) {
            let shown = shown.unwrap();
            assert!(
                shown.contains("# store is a URL, which may hold"),
                "{shown}"
            );
            assert!(!shown.contains("secret"), "{shown}");
        }
    }
    for text in mistakes {
        for refused in shown("store", text) {
            let refused = refused.unwrap_err();
            assert!(refused.contains("begins with postgres://"), "{refused}");
            assert!(
                refused.contains("***") && !refused.contains("secret"),
                "{refused}"
            );
        }
    }
    for url in [
        "http://piad:secret@localhost:4317",
        "https://secret@collector",
    ] {
        for shown in shown("otlp-endpoint", url) {
            let shown = shown.unwrap();
            assert!(shown.contains("# otlp-endpoint is a URL"), "{shown}");
            assert!(!shown.contains("secret"), "{shown}");
        }
    }
    // Where it does not belong, in the help, and in other commands.
    for (arguments, variable) in [
        (&["--listen", urls[0]][..], ""),
        (&["--log-format", urls[0]], ""),
        (&[urls[0]], ""),
        (&["--help"], urls[0]),
        (&["store", "check", mistakes[0]], ""),
        (&["store", "copy", mistakes[4], "./b"], ""),
        (
            &["fit", "-", "--server", "ftp://piad:secret@fits.example"],
            "",
        ),
        (
            &["fit", "-", "--server", "http://piad:secret@127.0.0.1:1"],
            "",
        ),
    ] {
        let mut command = Command::new(PROGRAM);
        command.args(arguments).stdin(std::process::Stdio::null());
        for name in ["PIAD_STORE", "PIAD_OTLP_ENDPOINT"] {
            command.envs((!variable.is_empty()).then_some((name, variable)));
        }
        let output = command.output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8(said).unwrap();
        assert!(
            !said.is_empty() && !said.contains("secret"),
            "{arguments:?}: {said}"
        );
    }
}

/// Errors of a file name its line, whose content may have a password and is not shown.
#[test]
fn lines_of_the_file_are_not_shown() {
    for file in [
        "max-jobs = 5\nstore = postgres://piad:secret@db.example/piad",
        "max-jobs = 5\nstore = 'postgres://piad:secret@db.example/piad",
        "max-jobs = 5\nstore 'postgres://piad:secret@db.example/piad'",
        "max-jobs = 5\nstore = 'a' # postgres://piad:secret@db.example\nstore = 'secret'",
    ] {
        let error = settings(file, &[], &[]).unwrap_err();
        assert!(error.contains("/piad.toml: line "), "{file}: {error}");
        assert!(!error.contains("secret"), "{file}: {error}");
    }
}

#[test]
fn errors_in_the_file_name_it_and_the_setting() {
    for (file, reported) in [
        (
            "max-jobs = 'many'",
            "/piad.toml: invalid value 'many' for '--max-jobs",
        ),
        (
            "max-jobs = -1",
            "/piad.toml: invalid value '-1' for '--max-jobs",
        ),
        (
            "listen = ['localhost']",
            "/piad.toml: invalid value 'localhost' for '--listen",
        ),
        ("max_jobs = 5", "/piad.toml: there is no setting max_jobs"),
        (
            "config = 'other.toml'",
            "/piad.toml: there is no setting config",
        ),
        (
            "max-jobs = { of = 5 }",
            "/piad.toml: max-jobs is not a text",
        ),
        (
            "max-jobs = 2026-01-01",
            "/piad.toml: max-jobs is not a text",
        ),
        ("max-jobs = 5\nmax-jobs = 6", "line 2"),
        ("max-jobs", "line 1"),
    ] {
        let error = settings(file, &[], &[]).unwrap_err();
        assert!(error.contains(reported), "{file}: {error}");
    }
    // Also where a flag comes before it.
    let error = settings("max-jobs = 'many'", &["--max-jobs", "5"], &[]).unwrap_err();
    assert!(error.contains("invalid value 'many'"), "{error}");
    let missing = run(&["config"], Path::new("/nowhere/piad.toml"), &[]);
    let said = String::from_utf8_lossy(&missing.stderr);
    assert!(said.contains("/nowhere/piad.toml: No such file"), "{said}");
}

#[tokio::test]
async fn a_server_has_the_settings_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("piad.toml");
    fs::write(&file, "max-points = 7\nbase-path = '/fits'\n").unwrap();
    let server = Program::with(folder.path(), &["--config", file.to_str().unwrap()]);
    let address = server.address.strip_suffix("/fits").unwrap();
    let capabilities = format!("http://{address}/fits/v1/capabilities");
    let answer = server.client.get(capabilities).send().await.unwrap();
    let capabilities: serde_json::Value = answer.json().await.unwrap();
    assert_eq!(capabilities["limits"]["points"], 7, "{capabilities:#}");
}
