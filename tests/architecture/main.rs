//! Files use each other in one direction: no file needs one that needs it, and neither does a folder or
//! file at the top of a crate.
//!
//! What a file uses is read from its `use` declarations and from its other paths; a name that a module passes on
//! (`pub use`) belongs to the file that defines it. Tests and the contents of macros are left out.
//!
//! [`wording`] checks the words of comments and messages.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    missing_docs,
    unreachable_pub,
    reason = "tests fail by panicking, and they have no users"
)]

mod modules;
mod paths;
mod wording;

use std::path::Path;

use petgraph::algo::tarjan_scc;
use petgraph::graphmap::DiGraphMap;

use modules::{Modules, Name};

/// The folders with the sources of the crates.
const CRATES: [&str; 3] = ["crates/piad-fit/src", "crates/piad-files/src", "src"];

/// The groups of modules that use each other in a circle.
fn circles(uses: &[(Name, Name)]) -> Vec<String> {
    let names: Vec<String> = uses
        .iter()
        .flat_map(|(user, used)| [user.join("::"), used.join("::")])
        .collect();
    let edges = names.chunks_exact(2).filter(|pair| pair[0] != pair[1]);
    let graph: DiGraphMap<&str, ()> = edges
        .map(|pair| (pair[0].as_str(), pair[1].as_str()))
        .collect();
    let groups = tarjan_scc(&graph).into_iter();
    let circles = groups.filter(|group| group.len() > 1);
    circles.map(|group| group.join(" and ")).collect()
}

#[test]
fn files_use_each_other_in_one_direction() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for folder in CRATES {
        let modules = Modules::of(&root.join(folder));
        let uses = modules.uses();
        assert!(
            uses.len() > 10 * CRATES.len(),
            "nothing is read in {folder}"
        );
        assert_eq!(circles(&uses), [""; 0], "{folder}");
        let top = |name: &Name| name.iter().take(1).cloned().collect::<Name>();
        let tops: Vec<(Name, Name)> = uses
            .iter()
            .map(|(user, used)| (top(user), top(used)))
            .filter(|(user, used)| !user.is_empty() && !used.is_empty())
            .collect();
        assert_eq!(circles(&tops), [""; 0], "folders of {folder}");
    }
}

/// The check finds what it is for.
#[test]
fn circles_are_found() {
    let name = |text: &str| text.split("::").map(str::to_owned).collect::<Name>();
    let uses = |pairs: &[(&str, &str)]| -> Vec<(Name, Name)> {
        let pairs = pairs.iter();
        pairs.map(|(user, used)| (name(user), name(used))).collect()
    };
    assert!(circles(&uses(&[("a", "b"), ("b", "c::d"), ("a", "c::d")])).is_empty());
    assert_eq!(
        circles(&uses(&[("a", "b"), ("b", "c::d"), ("c::d", "a")])).len(),
        1
    );
}
