//! Completions, manual pages, the version.

use crate::support::{Finished, Folder};

fn run(arguments: &[&str]) -> (i32, String) {
    let finished = Finished::of(Folder::new().command(arguments).output().unwrap());
    (finished.status, String::from_utf8(finished.out).unwrap())
}

#[test]
fn shells_complete_the_flags() {
    for shell in ["bash", "zsh", "fish"] {
        let (status, script) = run(&["completions", shell]);
        assert_eq!(status, 0);
        for flag in ["tolerance", "control-points", "token-file", "store"] {
            assert!(script.contains(flag), "{shell}: {flag}");
        }
    }
    assert_eq!(run(&["completions", "dos"]).0, 2);
}

#[test]
fn pages_of_the_manual_name_the_flags() {
    let (status, page) = run(&["man"]);
    assert_eq!(status, 0);
    assert!(page.contains(".TH piad 1") && page.contains("store\\-connections"));
    let (status, page) = run(&["man", "fit"]);
    assert_eq!(status, 0);
    for words in [
        ".TH piad-fit 1",
        "tolerance",
        "max\\-iterations",
        "Exit status",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert_eq!(run(&["man", "fly"]).0, 2);
}

#[test]
fn the_help_has_examples_and_statuses() {
    let (status, help) = run(&["fit", "--help"]);
    assert_eq!(status, 0);
    for words in [
        "piad fit wing.dat",
        "Exit status",
        "--iterations <DIR>",
        "130",
    ] {
        assert!(help.contains(words), "{words}: {help}");
    }
}
