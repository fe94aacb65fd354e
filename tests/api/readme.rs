//! The first commands of the README, as a newcomer copies them.

use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use crate::program::Program;

const README: &str = include_str!("../../README.md");

/// The blocks of code in this language, between two headings.
fn code(language: &str, from: &str, to: &str) -> Vec<String> {
    let (_, section) = README.split_once(from).unwrap();
    let (section, _) = section.split_once(to).unwrap();
    let blocks = section.split("```").skip(1).step_by(2);
    let blocks = blocks.filter_map(|block| block.strip_prefix(language)?.strip_prefix('\n'));
    blocks.map(str::to_owned).collect()
}

/// Runs code in a folder that has the examples, and gives what it prints.
fn run(program: &str, code: &str, folder: &Path) -> String {
    let script = folder.join("script");
    std::fs::write(&script, code).unwrap();
    let mut command = Command::new(program);
    let output = command.arg(&script).current_dir(folder).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program}: {said}");
    String::from_utf8(output.stdout).unwrap()
}

fn folder_with_examples() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    symlink(examples, folder.path().join("examples")).unwrap();
    folder
}

#[test]
fn the_tour_with_curl_is_short_and_works() {
    let data = tempfile::tempdir().unwrap();
    let program = Program::start(data.path());
    let blocks = code("sh", "## Five minutes with curl", "## A job");
    assert_eq!(blocks.len(), 3);
    let tour = blocks
        .join("\n")
        .replace("127.0.0.1:8080", &program.address);
    let folder = folder_with_examples();
    let printed = run(
        "bash",
        &format!("set -e -o pipefail\n{tour}"),
        folder.path(),
    );
    assert!(printed.len() < 100_000, "{} bytes", printed.len());
    // Only the job that has ended and the points that are equal are refused, as it says there.
    let problems: Vec<&str> = printed
        .split("\"type\":\"/problems/")
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap())
        .collect();
    assert_eq!(problems, ["already-ended", "invalid-fit"]);
    assert!(folder.path().join("helix.step").is_file());
    let lines = std::fs::read_to_string(folder.path().join("peaks.ndjson")).unwrap();
    assert!(lines.lines().last().unwrap().contains("\"end\""));
}

#[test]
fn python_without_the_client_fits_and_says_why_not() {
    let data = tempfile::tempdir().unwrap();
    let program = Program::start(data.path());
    let blocks = code("python", "### From your CAD system", "## From code");
    let bare = blocks
        .iter()
        .find(|block| block.contains("urllib"))
        .unwrap();
    let bare = bare.replace("127.0.0.1:8080", &program.address);
    let more = "
print(degree, len(knots), len(poles))
try:
    fit([[0, 0], [1, 1], [1, 1], [2, 0]])
except ValueError as refusal:
    print(refusal)
";
    let folder = folder_with_examples();
    let printed = run("python3", &format!("{bare}{more}"), folder.path());
    let lines: Vec<&str> = printed.lines().collect();
    assert_eq!(lines[0], "3 10 6");
    assert!(lines[1].starts_with("/curve/points/2: point 2 equals point 1"));
    // What follows in the README uses what the snippet has made, and brings its own modules.
    let others = blocks.iter().filter(|block| !block.contains("urllib"));
    let others: String = others.cloned().collect();
    for (name, import) in [
        ("App.Vector", "import FreeCAD as App, Part"),
        ("Rhino.Geometry", "import Rhino"),
    ] {
        assert!(others.find(import).unwrap() < others.find(name).unwrap());
    }
}
