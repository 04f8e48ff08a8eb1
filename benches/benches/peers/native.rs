//! Building and starting this program again for this machine's processor.

use std::path::PathBuf;
use std::process::Command;

/// Set in the second start.
const MARK: &str = "BENCHES_FOR_THIS_PROCESSOR";

/// Whether this is the second start.
pub fn is_native() -> bool {
    std::env::var_os(MARK).is_some()
}

/// Runs `cargo bench` once more with `-C target-cpu=native`, in a target folder of its own
/// (`native` in the one that is in use), and on one core if that can be had.
pub fn start_again() -> Result<(), String> {
    let this = std::env::current_exe().map_err(|e| e.to_string())?;
    // target/release/deps/peers-…
    let target: Option<PathBuf> = this.ancestors().nth(3).map(|p| p.join("native"));
    let target = target.ok_or_else(|| format!("{}: not in a target folder", this.display()))?;
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_string());
    let flags = std::env::var("RUSTFLAGS").unwrap_or_default();
    let mut command = if has_taskset() {
        // The build uses all cores; only what it starts is pinned.
        let mut command = Command::new(&cargo);
        command.env("CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER", "taskset -c 0");
        command.env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER", "taskset -c 0");
        command
    } else {
        Command::new(&cargo)
    };
    let status = command
        .args(["bench", "--quiet", "--bench", "peers", "--target-dir"])
        .arg(target)
        .arg("--manifest-path")
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"))
        .env("RUSTFLAGS", format!("{flags} -C target-cpu=native"))
        .env_remove("CARGO_TARGET_DIR")
        .env(MARK, "1")
        .status()
        .map_err(|e| format!("{cargo}: {e}"))?;
    if status.success() {
        Ok(())
    } else {
        Err("the timing run did not end well; its message stands above".to_string())
    }
}

fn has_taskset() -> bool {
    let probe = Command::new("taskset").args(["-c", "0", "true"]).output();
    probe.is_ok_and(|output| output.status.success())
}
