//! The memory of the machine, or of the control group of the process.

use std::fs;
use std::path::{Component, Path, PathBuf};

/// The memory of the machine, or of its control group if that has less. `None` if the system does not report it, such
/// as Linux without /proc.
pub(super) fn memory() -> Option<u64> {
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    let machine = Some(system.total_memory()).filter(|&memory| memory > 0)?;
    let limit = group_limit(Path::new("/"));
    Some(limit.unwrap_or(machine).min(machine))
}

/// A hierarchy of control groups that limits memory.
struct Hierarchy {
    /// The group that is mounted, as a path from the root of the hierarchy, and where it is mounted.
    mounted: PathBuf,
    at: PathBuf,
    version: Version,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    One,
    Two,
}

impl Version {
    /// The file with the limit of a group.
    fn limit(self) -> &'static str {
        match self {
            Self::One => "memory.limit_in_bytes",
            Self::Two => "memory.max",
        }
    }
}

/// The smallest limit of the group of this process and of the groups around it, of both versions of control groups;
/// files are below `root`.
fn group_limit(root: &Path) -> Option<u64> {
    let mounts = fs::read_to_string(root.join("proc/self/mountinfo")).ok()?;
    let groups = fs::read_to_string(root.join("proc/self/cgroup")).ok()?;
    let hierarchies = mounts.lines().filter_map(hierarchy);
    let limits = hierarchies.flat_map(|hierarchy| {
        let group = group(&groups, hierarchy.version).unwrap_or("/");
        limits(root, &hierarchy, group)
    });
    limits.min()
}

/// The hierarchy that a line of `/proc/self/mountinfo` mounts, if that limits memory.
fn hierarchy(line: &str) -> Option<Hierarchy> {
    let (place, kind) = line.split_once(" - ")?;
    let mut place = place.split(' ').skip(3);
    let (mounted, at) = (place.next()?, place.next()?);
    let mut kind = kind.split(' ');
    let version = match (kind.next()?, kind.nth(1)?) {
        ("cgroup2", _) => Version::Two,
        ("cgroup", options) if options.split(',').any(|it| it == "memory") => Version::One,
        _ => return None,
    };
    Some(Hierarchy {
        mounted: mounted.into(),
        at: at.into(),
        version,
    })
}

/// The group of the process by `/proc/self/cgroup`, whose lines are `4:memory:/a/b` or, of version 2, `0::/a/b`.
fn group(groups: &str, version: Version) -> Option<&str> {
    groups.lines().find_map(|line| {
        let mut parts = line.splitn(3, ':').skip(1);
        let (controllers, path) = (parts.next()?, parts.next()?);
        let is_it = match version {
            Version::One => controllers.split(',').any(|it| it == "memory"),
            Version::Two => controllers.is_empty(),
        };
        is_it.then_some(path)
    })
}

/// The limits of a group and of its parents, if they are mounted.
fn limits(root: &Path, hierarchy: &Hierarchy, group: &str) -> Vec<u64> {
    let top = root.join(hierarchy.at.strip_prefix("/").unwrap_or(&hierarchy.at));
    // In a container the group may be named from outside, where only the top is known here.
    let below = Path::new(group).strip_prefix(&hierarchy.mounted);
    let below = below.unwrap_or(Path::new(""));
    let is_inside = below
        .components()
        .all(|it| matches!(it, Component::Normal(_)));
    let below = if is_inside { below } else { Path::new("") };
    let groups = below.ancestors().map(|it| top.join(it));
    let limits =
        groups.filter_map(|it| fs::read_to_string(it.join(hierarchy.version.limit())).ok());
    // Without a limit version 2 says `max`, and version 1 a number that no machine has.
    limits
        .filter_map(|it| it.trim().parse().ok())
        .filter(|&it| it > 0)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The limit on a system with these files.
    fn limit(files: &[(&str, &str)]) -> Option<u64> {
        let root = tempfile::tempdir().unwrap();
        for (name, content) in files {
            let path = root.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, content).unwrap();
        }
        group_limit(root.path())
    }

    const ONE: &str =
        "30 24 0:26 / /sys/fs/cgroup/memory rw,nosuid shared:12 - cgroup cgroup rw,memory\n";
    const TWO: &str =
        "29 23 0:25 / /sys/fs/cgroup rw,nosuid shared:9 - cgroup2 cgroup2 rw,nsdelegate\n";
    const NONE: &str = "9223372036854771712\n";

    #[test]
    fn the_smallest_limit_around_the_process_holds() {
        let one = |groups: &str, inner: &str, outer: &str, top: &str| {
            limit(&[
                ("proc/self/mountinfo", ONE),
                ("proc/self/cgroup", groups),
                ("sys/fs/cgroup/memory/memory.limit_in_bytes", top),
                ("sys/fs/cgroup/memory/a/memory.limit_in_bytes", outer),
                ("sys/fs/cgroup/memory/a/b/memory.limit_in_bytes", inner),
            ])
        };
        let groups = "5:cpu,cpuacct:/x\n4:memory:/a/b\n0::/\n";
        assert_eq!(one(groups, "100\n", NONE, NONE), Some(100));
        assert_eq!(one(groups, NONE, "200\n", NONE), Some(200));
        assert_eq!(one(groups, "300\n", "200\n", "100\n"), Some(100));
        assert_eq!(one("4:memory:/\n", "1\n", "1\n", "300\n"), Some(300));
        let two = |inner: &str, outer: &str| {
            limit(&[
                ("proc/self/mountinfo", TWO),
                ("proc/self/cgroup", "0::/a.slice/b.service\n"),
                ("sys/fs/cgroup/a.slice/memory.max", outer),
                ("sys/fs/cgroup/a.slice/b.service/memory.max", inner),
            ])
        };
        assert_eq!(two("100\n", "max\n"), Some(100));
        assert_eq!(two("max\n", "200\n"), Some(200));
        assert_eq!(two("max\n", "max\n"), None);
    }

    #[test]
    fn containers_see_their_part_of_a_hierarchy() {
        let mount = "30 24 0:26 /docker/1f /sys/fs/cgroup/memory ro - cgroup cgroup rw,memory\n";
        for (groups, expected) in [
            ("4:memory:/docker/1f\n", Some(100)),
            ("4:memory:/docker/1f/sub\n", Some(50)),
            // Seen from elsewhere.
            ("4:memory:/elsewhere\n", Some(100)),
            ("4:memory:/../../1f\n", Some(100)),
        ] {
            let found = limit(&[
                ("proc/self/mountinfo", mount),
                ("proc/self/cgroup", groups),
                ("sys/fs/cgroup/memory/memory.limit_in_bytes", "100\n"),
                ("sys/fs/cgroup/memory/sub/memory.limit_in_bytes", "50\n"),
            ]);
            assert_eq!(found, expected, "{groups}");
        }
        assert_eq!(limit(&[]), None);
        assert_eq!(
            limit(&[("proc/self/mountinfo", TWO), ("proc/self/cgroup", "")]),
            None
        );
    }
}
