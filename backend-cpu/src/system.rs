//! How much memory there is.
//!
//! A system that overcommits grants what it does not have, and ends the process once it is touched; so a schedule is held
//! against what there is before anything is allocated.
use std::path::{Path, PathBuf};

/// Bytes that the process may take: what the system has available, or less where a control group says so; `u64::MAX`
/// where nobody says.
pub(crate) fn memory() -> u64 {
    let read = |path: &Path| std::fs::read_to_string(path).ok();
    memory_with(&read)
}

fn memory_with(read: &dyn Fn(&Path) -> Option<String>) -> u64 {
    let available = read(Path::new("/proc/meminfo")).and_then(|text| available(&text));
    let groups = read(Path::new("/proc/self/cgroup")).unwrap_or_default();
    let limits = limit_files(&groups)
        .into_iter()
        .filter_map(|path| limit(&read(&path)?));
    limits.chain(available).min().unwrap_or(u64::MAX)
}

/// `MemAvailable` of `/proc/meminfo`.
fn available(meminfo: &str) -> Option<u64> {
    let line = meminfo
        .lines()
        .find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim_end().parse().ok()?;
    kib.checked_mul(1024)
}

/// A limit as a control group has it; `max` is none.
fn limit(text: &str) -> Option<u64> {
    text.trim().parse().ok()
}

/// Where the limits of the control groups stand that `/proc/self/cgroup` names, and those of their ancestors, which hold
/// as well. Inside a container the names may be those outside, so the root is always among them.
fn limit_files(groups: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for line in groups.lines() {
        let mut parts = line.splitn(3, ':');
        let (Some(number), Some(controllers), Some(name)) =
            (parts.next(), parts.next(), parts.next())
        else {
            continue;
        };
        let (root, file) = if number == "0" && controllers.is_empty() {
            ("/sys/fs/cgroup", "memory.max")
        } else if controllers.split(',').any(|name| name == "memory") {
            ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
        } else {
            continue;
        };
        let group = Path::new(name.trim_start_matches('/'));
        let ancestors = group.ancestors();
        files.extend(ancestors.map(|group| Path::new(root).join(group).join(file)));
    }
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEMINFO: &str =
        "MemTotal:       16384000 kB\nMemFree:          100000 kB\nMemAvailable:    8000000 kB\n";

    fn memory_of(files: &[(&str, &str)]) -> u64 {
        memory_with(&|path| {
            let found = files.iter().find(|(name, _)| Path::new(name) == path);
            found.map(|(_, text)| (*text).into())
        })
    }

    #[test]
    fn without_limits_it_is_what_the_system_has_available() {
        assert_eq!(memory_of(&[("/proc/meminfo", MEMINFO)]), 8_000_000 << 10);
        let unlimited = [
            ("/proc/meminfo", MEMINFO),
            ("/proc/self/cgroup", "0::/\n"),
            ("/sys/fs/cgroup/memory.max", "max\n"),
        ];
        assert_eq!(memory_of(&unlimited), 8_000_000 << 10);
    }

    #[test]
    fn a_group_and_its_ancestors_limit_it() {
        let v2 = |own, parent| {
            memory_of(&[
                ("/proc/meminfo", MEMINFO),
                ("/proc/self/cgroup", "0::/jobs/one\n"),
                ("/sys/fs/cgroup/jobs/one/memory.max", own),
                ("/sys/fs/cgroup/jobs/memory.max", parent),
            ])
        };
        assert_eq!(v2("1073741824\n", "max\n"), 1 << 30);
        assert_eq!(v2("max\n", "536870912\n"), 512 << 20);
        assert_eq!(v2("max\n", "99999999999999\n"), 8_000_000 << 10);
    }

    /// The name is that outside of the container, where the root is the container's own group.
    #[test]
    fn the_first_version_and_names_from_outside_are_understood() {
        let files = [
            ("/proc/meminfo", MEMINFO),
            (
                "/proc/self/cgroup",
                "12:cpu,cpuacct:/x\n5:memory:/docker/abc\n1:name=systemd:/\n",
            ),
            ("/sys/fs/cgroup/memory/memory.limit_in_bytes", "268435456\n"),
        ];
        assert_eq!(memory_of(&files), 256 << 20);
    }

    #[test]
    fn nothing_known_is_no_limit() {
        assert_eq!(memory_of(&[]), u64::MAX);
        let nonsense = [
            ("/proc/meminfo", "MemAvailable: many kB\n"),
            ("/proc/self/cgroup", "x\n"),
        ];
        assert_eq!(memory_of(&nonsense), u64::MAX);
    }
}
