//! What is known about the machine and this process.

use serde::Serialize;

/// The computer a run took place on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Machine {
    /// Processor model, or the architecture where the model is unknown.
    pub cpu: String,
    /// Hardware threads this process may use.
    pub cores: usize,
    /// Operating system.
    pub os: String,
}

impl Machine {
    /// This machine.
    #[must_use]
    pub fn here() -> Self {
        let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
        let cpu = field(&read("/proc/cpuinfo"), "model name", ':');
        let os = field(&read("/etc/os-release"), "PRETTY_NAME", '=');
        Self {
            cpu: cpu.unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            os: os.unwrap_or_else(|| std::env::consts::OS.to_owned()),
        }
    }
}

/// The most memory this process has had resident, where the system tells.
#[must_use]
pub fn peak_resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    parse_peak(&status)
}

fn parse_peak(status: &str) -> Option<u64> {
    let value = field(status, "VmHWM", ':')?;
    let kibibytes: u64 = value.strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// The value of the first line `key <separator> value`, without quotes.
fn field(text: &str, key: &str, separator: char) -> Option<String> {
    let (_, value) = text.lines().filter_map(|line| line.split_once(separator)).find(|(name, _)| name.trim() == key)?;
    Some(value.trim().trim_matches('"').to_owned()).filter(|value| !value.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_found() {
        assert_eq!(field("a: 1\nmodel name\t: Some CPU @ 2\n", "model name", ':').as_deref(), Some("Some CPU @ 2"));
        assert_eq!(field("PRETTY_NAME=\"An OS 12\"\n", "PRETTY_NAME", '=').as_deref(), Some("An OS 12"));
        assert_eq!(field("a: 1\n", "b", ':'), None);
    }

    #[test]
    fn peak_is_in_bytes() {
        assert_eq!(parse_peak("VmPeak:\t 9 kB\nVmHWM:\t    2048 kB\n"), Some(2048 * 1024));
        assert_eq!(parse_peak("VmHWM: lots\n"), None);
    }

    #[test]
    fn this_machine_has_a_name_and_cores() {
        let machine = Machine::here();
        assert!(!machine.cpu.is_empty() && !machine.os.is_empty() && machine.cores > 0);
        if cfg!(target_os = "linux") {
            assert!(peak_resident_bytes().is_some_and(|bytes| bytes > 1 << 20));
        }
    }
}
