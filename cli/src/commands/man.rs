//! `dynamics man`: the help texts as manual pages.

use crate::output;
use crate::whole_file::{WholeFile, make_folder};
use clap::{Args, Command};
use clap_mangen::Man;
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `man`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  dynamics man --out ~/.local/share/man/man1")]
pub struct Arguments {
    /// The folder for `dynamics.1` and a page for each command; made if it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Runs the command on the description of the whole command line.
///
/// # Errors
/// If the folder cannot be written to.
pub fn run(arguments: &Arguments, mut program: Command) -> anyhow::Result<()> {
    // Gives each command the name of its page, `dynamics-check`.
    program.build();
    make_folder(&arguments.out)?;
    let commands = program.get_subcommands().filter(|c| c.get_name() != "help");
    let mut out = output::stdout();
    for command in std::iter::once(&program).chain(commands) {
        let page = Man::new(command.clone());
        let path = arguments.out.join(page.get_filename());
        let mut text = Vec::new();
        page.render(&mut text)?;
        let mut file = WholeFile::create(&path)?;
        file.write_all(&text)?;
        file.finish()?;
        writeln!(out, "wrote {}", path.display())?;
    }
    Ok(out.flush()?)
}
