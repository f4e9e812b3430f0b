//! How much memory the process uses and may use: what lets a scene without end stop with an error instead of with the machine.
//!
//! The numbers come from Linux's `/proc`. Elsewhere nothing is known and nothing refused: the limits on single things (docs/limits.md) stand alone.

/// More memory is wanted than there is.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("out of memory: {} MiB are wanted where {} MiB are allowed (--max-memory MIB, Max_Memory=MIB)", wanted >> 20, limit >> 20)]
pub struct OutOfMemory {
    /// Bytes that the process would use.
    pub wanted: u64,
    /// Bytes that it may use.
    pub limit: u64,
}

/// What the process may use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MemoryLimit(u64);

impl Default for MemoryLimit {
    /// No limit.
    fn default() -> Self {
        Self(u64::MAX)
    }
}

/// Share of what is free that a job may take: files that it reads, the system and others want some.
const SHARE: f64 = 0.8;
/// Of an address space limit (`ulimit -v`) this part is for stacks, of which only touched pages count elsewhere, and for
/// arrays that grow by being copied.
const ADDRESS_SHARE: f64 = 0.4;

impl MemoryLimit {
    /// So many bytes, and never more than `ulimit -v` leaves room for.
    pub fn bytes(n: u64) -> Self {
        Self(n.min(address_limit().map_or(u64::MAX, |a| (a as f64 * ADDRESS_SHARE) as u64)))
    }

    /// Most of what is free on this machine and in its container, now.
    pub fn of_machine() -> Self {
        let free = [meminfo_free(), container_free()].into_iter().flatten().min();
        Self::bytes(free.map_or(u64::MAX, |f| (f as f64 * SHARE) as u64 + in_use().unwrap_or(0)))
    }

    /// Whether `more` bytes may be taken besides those in use.
    pub fn allows(self, more: u64) -> Result<(), OutOfMemory> {
        if self.0 == u64::MAX {
            return Ok(());
        }
        let wanted = in_use().unwrap_or(0).saturating_add(more);
        if wanted > self.0 { Err(OutOfMemory { wanted, limit: self.0 }) } else { Ok(()) }
    }
}

/// A number of KiB in a file of lines `Key: number kB`.
fn kib_in(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix(key))?;
    line.trim_start_matches(':').split_whitespace().next()?.parse::<u64>().ok()?.checked_mul(1024)
}

/// The most bytes that were resident in this process at once; known on Linux.
pub fn peak() -> Option<u64> {
    kib_in("/proc/self/status", "VmHWM")
}

/// Resident bytes of this process; known on Linux.
pub fn in_use() -> Option<u64> {
    kib_in("/proc/self/status", "VmRSS")
}

fn meminfo_free() -> Option<u64> {
    kib_in("/proc/meminfo", "MemAvailable")
}

/// What the control group (a container's limit) leaves.
fn container_free() -> Option<u64> {
    let number = |f: &str| std::fs::read_to_string(f).ok()?.trim().parse::<u64>().ok();
    let pairs = [
        ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),
        ("/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes"),
    ];
    pairs.into_iter().find_map(|(limit, used)| Some(number(limit)?.saturating_sub(number(used)?)))
}

/// `ulimit -v`, if there is one.
fn address_limit() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_limit_allows_everything_and_a_small_one_nothing() {
        assert_eq!(MemoryLimit::default().allows(u64::MAX), Ok(()));
        let small = MemoryLimit::bytes(1 << 20);
        assert!(matches!(small.allows(1 << 40), Err(OutOfMemory { limit: 1_048_576, .. })));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn linux_says_what_is_in_use() {
        let before = in_use().expect("a number");
        let block = vec![1u8; 64 << 20];
        assert!(in_use().expect("a number") > before + (32 << 20), "{}", block.len());
        assert!(MemoryLimit::of_machine().allows(0).is_ok());
        assert!(MemoryLimit::of_machine().allows(1 << 50).is_err());
    }
}
