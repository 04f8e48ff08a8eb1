//! The command line once more, so that its tests run the program as it is now: cargo
//! builds a package's own binaries before its tests, but not those of other packages.

fn main() -> std::process::ExitCode {
    dynamics_cli::main()
}
