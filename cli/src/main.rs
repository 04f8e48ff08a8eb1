//! The binary `dynamics`.

fn main() -> std::process::ExitCode {
    dynamics_cli::main()
}
