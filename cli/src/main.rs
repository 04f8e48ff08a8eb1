//! The binary `dynamics`.

/// Filters over logs allocate many small matrices: a seventh of the time of `trace` is the
/// system's allocator.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> std::process::ExitCode {
    dynamics_cli::main()
}
