//! Output on a standard error that cannot be written, inputs without an end, and names that would control the
//! terminal.

use std::fs::File;
use std::process::{Command, Stdio};

use crate::support::{Finished, Folder, PROGRAM};

/// A device that is always full; none where the system has none.
fn full() -> Option<File> {
    File::options().write(true).open("/dev/full").ok()
}

#[test]
fn a_full_standard_error_changes_no_exit_status() {
    let folder = Folder::with_curve();
    folder.write("broken.csv", "x,y\n1,2\n3,oops\n");
    for (arguments, status) in [
        (&["fit", "curve.csv", "-o", "out.step"][..], 0),
        (
            &[
                "fit",
                "curve.csv",
                "-o",
                "out.json",
                "--max-iterations",
                "1",
            ],
            1,
        ),
        (&["fit", "broken.csv"], 2),
        (&["fit", "missing.csv"], 2),
        (&["token", "create", "--tokens", "tokens.toml"], 0),
        (&["token", "revoke", "--tokens", "tokens.toml", "a"], 1),
        (&["store", "check", "nowhere"], 1),
        (&["health", "--listen", "127.0.0.1:1"], 1),
        (&["--log", "="], 2),
        (&["--listen", "nowhere"], 2),
        (&["man", "fly"], 2),
        // Its log cannot be written either.
        (&["--listen", "192.0.2.1:1", "--insecure-no-auth"], 1),
    ] {
        let Some(full) = full() else {
            return;
        };
        let output = folder.command(arguments).stderr(full).output().unwrap();
        assert_eq!(output.status.code(), Some(status), "{arguments:?}");
    }
    assert!(folder.read("out.step").starts_with(b"ISO-10303-21;"));
}

/// A token that was not printed is no success.
#[test]
fn a_full_standard_output_is_a_failure() {
    let folder = Folder::new();
    for arguments in [
        &["token", "create", "--tokens", "tokens.toml"][..],
        &["config"],
        &["completions", "bash"],
    ] {
        let Some(full) = full() else {
            return;
        };
        let finished = Finished::of(folder.command(arguments).stdout(full).output().unwrap());
        assert_eq!(finished.status, 1, "{arguments:?}");
        assert!(
            finished.err.contains("<stdout>: "),
            "{arguments:?}: {}",
            finished.err
        );
    }
}

#[test]
fn inputs_have_a_limit() {
    let folder = Folder::with_curve();
    let size = folder.read("curve.csv").len();
    let limit = |bytes: usize| bytes.to_string();
    let fits = folder.fit(&["curve.csv", "--max-input", &limit(size)]);
    assert_eq!(fits.status, 0, "{}", fits.err);
    let finished = folder.fit(&["curve.csv", "--max-input", &limit(size - 1)]);
    assert_eq!(finished.status, 2);
    assert!(
        finished.err.starts_with("curve.csv: larger than "),
        "{}",
        finished.err
    );
    assert!(finished.err.contains("--max-input"), "{}", finished.err);
    if !std::path::Path::new("/dev/zero").exists() {
        return;
    }
    for (arguments, name) in [
        (&["/dev/zero"][..], "/dev/zero"),
        (&["-"], "<stdin>"),
        (&["curve.csv", "--json", "/dev/zero"], "/dev/zero"),
    ] {
        let mut command = Command::new(PROGRAM);
        command
            .arg("fit")
            .args(arguments)
            .args(["--max-input", "1MiB"]);
        command.current_dir(folder.path("."));
        command.stdin(Stdio::from(File::open("/dev/zero").unwrap()));
        let finished = Finished::of(command.output().unwrap());
        assert_eq!(finished.status, 2, "{arguments:?}: {}", finished.err);
        let expected = format!("{name}: larger than 1.0 MiB; --max-input sets another limit\n");
        assert_eq!(finished.err, expected);
    }
}

#[cfg(unix)]
#[test]
fn names_do_not_control_the_terminal() {
    let folder = Folder::with_curve();
    let odd = "\u{1b}[2J\u{9b}31m\r.csv";
    folder.write(odd, &crate::support::curve(40));
    let note = "\u{1b}]0;title\u{7}";
    for arguments in [
        &["fit", odd, "-o", "\u{1b}[31mout.step"][..],
        &["fit", "\u{1b}[1mmissing.csv"],
        &["fit", "curve.csv", "-o", "\u{1b}[1mnowhere/out.step"],
        &["fit", "curve.csv", "--set", "\u{1b}[1m=3"],
        &["fit", "curve.csv", "--format", "\u{1b}[1m"],
        &["fit", "curve.csv", "--units", "\u{1b}[1m"],
        &["--config", "\u{1b}[1m.toml"],
        &["--listen", "\u{1b}[1m"],
        &["\u{1b}[1m"],
        &["token", "create", "--tokens", "tokens.toml", "--note", note],
        &["token", "list", "--tokens", "tokens.toml"],
        &["token", "revoke", "--tokens", "tokens.toml", "\u{1b}[1m"],
        &["store", "check", "\u{1b}[1m"],
        &["man", "\u{1b}[1m"],
    ] {
        let output = folder.command(arguments).output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8(said).unwrap();
        // The colours of the parser of arguments are for terminals alone.
        let controls = |c: char| c.is_control() && c != '\n';
        assert!(!said.contains(controls), "{arguments:?}: {said:?}");
        assert!(said.contains("\\u{1b}"), "{arguments:?}: {said}");
    }
}
