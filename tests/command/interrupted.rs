//! Interrupts leave nothing behind.

#![cfg(unix)]

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use crate::support::Folder;

#[test]
fn an_interrupt_leaves_no_file() {
    let folder = Folder::with_curve();
    for signal in ["-INT", "-TERM"] {
        let mut fit =
            folder.command(&["fit", "curve.csv", "-o", "out.step", "--iterations", "all"]);
        fit.args([
            "--method",
            "transpose",
            "--tolerance",
            "1e-200",
            "--max-iterations",
            "900000000",
        ]);
        let mut child = fit
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        // It has begun.
        assert!(lines.next().unwrap().unwrap().starts_with("iteration "));
        let killed = Command::new("kill")
            .args([signal, &child.id().to_string()])
            .status();
        assert!(killed.unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130));
        assert_eq!(folder.names(), ["all", "curve.csv"]);
        assert_eq!(std::fs::read_dir(folder.path("all")).unwrap().count(), 0);
    }
}
