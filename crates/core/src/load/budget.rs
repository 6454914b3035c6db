//! How much memory a recording may take when it is unpacked.

use std::cell::Cell;
use std::io::Read;
use std::path::Path;
use std::sync::LazyLock;

use crate::load::error::LoadError;
use crate::load::format::Format;
use crate::load::pieces::Pieces;

/// Environment variable that sets the budget, in megabytes (1e6 bytes).
pub const BUDGET_VARIABLE: &str = "DOUBLET_UNPACK_MB";
/// Part of the machine's memory that is the budget where none is set.
const PART_OF_MEMORY: u64 = 4;
/// Budget where nothing is known of the machine, bytes.
const UNKNOWN_MACHINE: u64 = 1 << 30;
const MEGABYTE: u64 = 1_000_000;
/// Bytes of a number in memory.
pub(crate) const NUMBER_BYTES: u64 = 8;

/// The budget of this program, bytes: what the environment says, or a quarter of the memory it may use.
static BUDGET: LazyLock<u64> = LazyLock::new(|| {
    let set = std::env::var(BUDGET_VARIABLE).ok().and_then(|text| text.trim().parse::<u64>().ok());
    set.map(|megabytes| megabytes.saturating_mul(MEGABYTE))
        .or_else(|| memory().map(|bytes| bytes / PART_OF_MEMORY))
        .unwrap_or(UNKNOWN_MACHINE)
});

/// Memory that this program may use, bytes: the least of the machine's, its control group's and its own limit; `None` where the
/// system does not say.
pub fn memory() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let machine = read("/proc/meminfo").and_then(|text| kilobytes(&text, "MemTotal:"));
    let group = read("/sys/fs/cgroup/memory.max").and_then(|text| text.trim().parse().ok());
    let own = read("/proc/self/limits").and_then(|text| address_space(&text));
    [machine, group, own].into_iter().flatten().min()
}

/// Memory that this program may still take now, bytes: the least of what the machine has available, what is left of its control group
/// without files that can be dropped, and what is left of its own limit; `None` where the system does not say.
pub fn available_memory() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let number = |path: &str| read(path).and_then(|text| text.trim().parse::<u64>().ok());
    let machine = read("/proc/meminfo").and_then(|text| kilobytes(&text, "MemAvailable:"));
    let dropped = read("/sys/fs/cgroup/memory.stat").and_then(|text| field(&text, "inactive_file ")?.parse().ok());
    let used = number("/sys/fs/cgroup/memory.current").map(|used| used.saturating_sub(dropped.unwrap_or(0)));
    let group = number("/sys/fs/cgroup/memory.max").zip(used).map(|(most, used)| most.saturating_sub(used));
    let taken = read("/proc/self/status").and_then(|text| kilobytes(&text, "VmSize:"));
    let own = read("/proc/self/limits").and_then(|text| address_space(&text));
    let own = own.zip(taken).map(|(most, taken)| most.saturating_sub(taken));
    [machine, group, own].into_iter().flatten().min()
}

/// What follows `name` on its line.
fn field<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    text.lines().find_map(|line| line.strip_prefix(name)).map(str::trim)
}

/// A field in kB of `/proc/meminfo` or `/proc/self/status`, in bytes.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    Some(field(text, name)?.strip_suffix("kB")?.trim().parse::<u64>().ok()?.saturating_mul(1024))
}

/// The soft limit of the address space in `/proc/self/limits`, in bytes.
fn address_space(text: &str) -> Option<u64> {
    field(text, "Max address space")?.split_whitespace().next()?.parse().ok()
}

/// What is left of the budget of one file.
pub(crate) struct Budget<'p> {
    path: &'p Path,
    format: Format,
    all: u64,
    left: Cell<u64>,
}

impl<'p> Budget<'p> {
    /// The budget of `path`. What takes no more than the file itself is not unpacked, so there is always that much.
    pub fn for_file(path: &'p Path, format: Format) -> Self {
        let stored = std::fs::metadata(path).map_or(0, |about| about.len());
        let all = (*BUDGET).max(stored);
        Self { path, format, all, left: Cell::new(all) }
    }

    /// The file and its size, which is known before anything of it is read.
    ///
    /// # Errors
    /// [`LoadError::Open`], and [`LoadError::TooLarge`] where it is larger than what was set for a recording.
    fn open(&self) -> Result<(std::fs::File, u64), LoadError> {
        let open = |cause| LoadError::Open { path: self.path.to_owned(), cause };
        let file = std::fs::File::open(self.path).map_err(open)?;
        let stored = file.metadata().map_err(open)?.len();
        if stored > *BUDGET {
            return Err(self.too_large(*BUDGET, format!("the file itself has {} MB", stored / MEGABYTE)));
        }
        Ok((file, stored))
    }

    /// The bytes of the file, which is read as a whole: its size is known before, and no more than that is read.
    ///
    /// # Errors
    /// [`LoadError::Open`], and [`LoadError::TooLarge`] where it is larger than what was set for a recording.
    pub fn read_whole(&self) -> Result<Vec<u8>, LoadError> {
        let (file, stored) = self.open()?;
        let mut contents = Vec::with_capacity(usize::try_from(stored).unwrap_or(0));
        // A file that grows meanwhile is read as far as it was.
        let read = file.take(stored).read_to_end(&mut contents);
        read.map_err(|cause| LoadError::Open { path: self.path.to_owned(), cause })?;
        Ok(contents)
    }

    /// The file, to be read piece by piece.
    pub fn pieces(&self) -> Result<Pieces<'p>, LoadError> {
        let (file, stored) = self.open()?;
        Ok(Pieces::new(self.path, file, usize::try_from(stored).unwrap_or(usize::MAX)))
    }

    /// Refuses `bytes` that are known beforehand, without taking them.
    pub fn check(&self, bytes: u64, what: impl FnOnce() -> String) -> Result<(), LoadError> {
        self.take(bytes, what).map(|()| self.give_back(bytes))
    }

    fn too_large(&self, all: u64, what: String) -> LoadError {
        let (path, format) = (self.path.to_owned(), self.format);
        LoadError::TooLarge { path, format, what, budget_mb: all / MEGABYTE }
    }

    /// All of it, bytes.
    pub fn all(&self) -> u64 {
        self.all
    }

    /// Takes `bytes` for `what`.
    ///
    /// # Errors
    /// [`LoadError::TooLarge`] when that is more than is left.
    pub fn take(&self, bytes: u64, what: impl FnOnce() -> String) -> Result<(), LoadError> {
        match self.left.get().checked_sub(bytes) {
            Some(left) => {
                self.left.set(left);
                Ok(())
            }
            None => Err(self.too_large(self.all, what())),
        }
    }

    /// Gives back what was taken for a moment.
    pub(crate) fn give_back(&self, bytes: u64) {
        self.left.set(self.left.get().saturating_add(bytes).min(self.all));
    }
}

#[cfg(test)]
mod tests {
    use super::{address_space, field, kilobytes};

    #[test]
    fn memory_is_read_as_the_system_writes_it() {
        let machine = "MemTotal:       24680124 kB\nMemFree: 1 kB\nMemAvailable:   12 kB\n";
        let [all, available] = ["MemTotal:", "MemAvailable:"].map(|name| kilobytes(machine, name));
        assert_eq!((all, available), (Some(24_680_124 * 1024), Some(12 * 1024)));
        assert_eq!(kilobytes("MemFree: 1 kB\n", "MemTotal:"), None);
        assert_eq!(field("active_file 7\ninactive_file 4096\n", "inactive_file "), Some("4096"));
        let limits = "Max open files            1024    4096    files\nMax address space         4294967296    unlimited  bytes\n";
        assert_eq!(address_space(limits), Some(4_294_967_296));
        assert_eq!(address_space("Max address space         unlimited    unlimited  bytes\n"), None);
    }
}
