//! The commands of the README and of the tour, as a newcomer copies them.

use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Output};

use crate::program::{PROGRAM, Program};

const README: &str = include_str!("../../README.md");
const CALLS: &str = include_str!("../../docs/tutorials/http-api.md");
const CLIENTS: &str = include_str!("../../docs/reference/clients.md");
const JOBS: &str = include_str!("../../docs/reference/job.md");

/// The folders of documents.
const DOCS: [&str; 7] = [
    "docs",
    "docs/evidence",
    "docs/explanation",
    "docs/explanation/methods",
    "docs/how-to",
    "docs/reference",
    "docs/tutorials",
];

/// The blocks of code in a language.
fn code(text: &str, language: &str) -> Vec<String> {
    let blocks = text.split("```").skip(1).step_by(2);
    let blocks = blocks.filter_map(|block| block.strip_prefix(language)?.strip_prefix('\n'));
    blocks.map(str::to_owned).collect()
}

/// A directory like a new clone that has been built: with the examples and the program.
fn clone() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    symlink(examples, folder.path().join("examples")).unwrap();
    let release = folder.path().join("target/release");
    std::fs::create_dir_all(&release).unwrap();
    symlink(PROGRAM, release.join("piad")).unwrap();
    folder
}

fn run(program: &str, code: &str, folder: &Path) -> Output {
    let script = folder.join("script");
    std::fs::write(&script, code).unwrap();
    let mut command = Command::new(program);
    let output = command.arg(&script).current_dir(folder).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program}: {said}");
    output
}

/// Runs all commands of a text, with a server.
fn run_all(text: &str, folder: &Path) -> (String, String) {
    let data = tempfile::tempdir().unwrap();
    let program = Program::start(data.path());
    let commands = code(text, "sh").join("\n");
    let commands = commands.replace("127.0.0.1:8080", &program.address);
    // The server runs already.
    let script = format!("set -e -o pipefail\ncargo() {{ :; }}\n{commands}");
    let output = run("bash", &script, folder);
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr))
}

/// The types of the problems that were answered.
fn problems(printed: &str) -> Vec<&str> {
    let problems = printed.split("\"type\":\"/problems/").skip(1);
    problems
        .map(|rest| rest.split('"').next().unwrap())
        .collect()
}

#[test]
fn each_command_works_and_prints_its_output() {
    let folder = clone();
    let (printed, reported) = run_all(README, folder.path());
    // Only the points that are equal are refused, as it says there.
    assert_eq!(problems(&printed), ["invalid-fit"]);
    for file in ["wing", "airfoil", "peaks", "naca"] {
        let text = std::fs::read_to_string(folder.path().join(format!("{file}.step"))).unwrap();
        assert!(text.starts_with("ISO-10303-21;"), "{file}");
    }
    assert!(folder.path().join("scan.iges").is_file());
    // "16 instead of 121", and "four times the noise" is the tolerance.
    assert!(reported.contains("121 points, 16 control points, method least_squares"));

    let shown = code(README, "");
    let summary = shown.iter().find(|block| block.contains("wrote")).unwrap();
    for line in summary.lines() {
        // How long it takes is another matter, and so is how far it was when that was last said.
        let (begin, end) = match line.split_once(" in ") {
            Some((begin, rest)) => (begin, rest.split_once(": ").unwrap().1),
            None if line.starts_with("iteration ") => ("iteration ", ""),
            None => (line, ""),
        };
        let is_told = |it: &str| it.starts_with(begin) && it.ends_with(end);
        assert!(reported.lines().any(is_told), "{line}\n{reported}");
    }
    let stream = shown.iter().find(|block| block.contains("event:")).unwrap();
    for part in [
        "\"basis\":\"bernstein\",\"degree\":10",
        "\"error\":{\"max\":0.462013452",
        "\"iterations\":149,",
    ] {
        assert!(stream.contains(part) && printed.contains(part), "{part}");
    }
}

#[test]
fn it_is_short() {
    assert!(README.len() <= 8000, "{} bytes", README.len());
}

/// What GitHub makes of a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter_map(|c| match c {
        ' ' => Some('-'),
        _ if c.is_alphanumeric() || "-_".contains(c) => Some(c.to_ascii_lowercase()),
        _ => None,
    });
    kept.collect()
}

#[test]
fn links_lead_somewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let docs = DOCS.map(|folder| std::fs::read_dir(root.join(folder)).unwrap());
    let docs = docs.into_iter().flatten();
    let docs = docs.map(|entry| entry.unwrap().path());
    let pages = docs.filter(|path| path.extension().is_some_and(|extension| extension == "md"));
    for page in pages.chain([root.join("README.md")]) {
        let text = std::fs::read_to_string(&page).unwrap();
        let links = text
            .split("](")
            .skip(1)
            .map(|rest| rest.split_once(')').unwrap().0);
        for link in links.filter(|link| !link.contains("://")) {
            let (path, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = match path {
                "" => page.clone(),
                _ => page.parent().unwrap().join(path),
            };
            assert!(target.exists(), "{}: {link}", page.display());
            if !heading.is_empty() {
                let text = std::fs::read_to_string(target).unwrap();
                let mut headings = text.lines().filter_map(|line| line.strip_prefix('#'));
                let found =
                    headings.any(|line| anchor(line.trim_start_matches('#').trim()) == heading);
                assert!(found, "{}: {link}", page.display());
            }
        }
    }
}

#[test]
fn the_tour_with_curl_is_short_and_works() {
    let folder = clone();
    let (printed, _) = run_all(CALLS, folder.path());
    assert!(printed.len() < 100_000, "{} bytes", printed.len());
    // Only the job that has ended is refused, as it says there.
    // And the item of a batch that has one point.
    assert_eq!(problems(&printed), ["already-ended", "invalid-fit"]);
    let totals = printed
        .matches("\"totals\":{\"items\":3,\"converged\":")
        .count();
    assert_eq!(totals, 2, "of both batches");
    assert!(folder.path().join("helix.step").is_file());
    let lines = std::fs::read_to_string(folder.path().join("peaks.ndjson")).unwrap();
    assert!(lines.lines().last().unwrap().contains("\"end\""));
}

#[test]
fn files_are_posted_as_it_says() {
    let (printed, _) = run_all(JOBS, clone().path());
    assert_eq!(problems(&printed), [""; 0]);
    assert!(printed.contains("\"kind\":\"chebyshev\""), "{printed}");
}

#[test]
fn python_without_a_package_fits_and_says_why_not() {
    let data = tempfile::tempdir().unwrap();
    let program = Program::start(data.path());
    let (_, section) = CLIENTS.split_once("## Python without a package").unwrap();
    let (section, _) = section.split_once("## Generated clients").unwrap();
    let blocks = code(section, "python");
    let bare = blocks[0].replace("127.0.0.1:8080", &program.address);
    let more = "
print(degree, len(knots), len(poles))
try:
    fit([[0, 0], [1, 1], [1, 1], [2, 0]])
except ValueError as refusal:
    print(refusal)
";
    let output = run("python3", &format!("{bare}{more}"), clone().path());
    let printed = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = printed.lines().collect();
    assert_eq!(lines[0], "3 10 6");
    assert!(lines[1].starts_with("/curve/points/2: point 2 equals point 1"));
    // What follows uses what the snippet has made, and brings its own modules.
    let others = blocks[1..].concat();
    for (name, import) in [
        ("App.Vector", "import FreeCAD as App, Part"),
        ("Rhino.Geometry", "import Rhino"),
    ] {
        assert!(others.find(import).unwrap() < others.find(name).unwrap());
    }
}
