//! `dynamics completions`: what a shell completes.

use crate::output;
use clap::Args;
use clap_complete::Shell;
use std::io::Write;

/// Arguments of `completions`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  dynamics completions bash > ~/.local/share/bash-completion/completions/dynamics
  dynamics completions zsh > \"${fpath[1]}/_dynamics\"
  dynamics completions fish > ~/.config/fish/completions/dynamics.fish")]
pub struct Arguments {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Runs the command on the description of the whole command line.
///
/// # Errors
/// If nothing can be printed.
pub fn run(arguments: &Arguments, mut program: clap::Command) -> anyhow::Result<()> {
    let (name, mut script) = (program.get_name().to_string(), Vec::new());
    clap_complete::generate(arguments.shell, &mut program, name, &mut script);
    let mut out = output::stdout();
    out.write_all(&script)?;
    Ok(out.flush()?)
}
