use crate::{Failure, stdout};
use clap::{Args, Command};
use clap_mangen::Man;
use nextview_scan::files::{Overwrite, ResultFolder};
use std::io::Write;
use std::path::PathBuf;

/// Write the manual pages, one for each command.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  nextview man --out ~/.local/share/man/man1")]
pub(super) struct ManArgs {
    /// Folder for the pages
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Replace existing pages
    #[arg(long)]
    force: bool,
}

impl ManArgs {
    /// Writes the manual pages of this program.
    pub fn run(self, program: Command) -> Result<(), Failure> {
        let (out, rule) = (self.out, Overwrite::forced(self.force));
        // The command `help` needs no page.
        let pages = pages(program.disable_help_subcommand(true))?;
        let names: Vec<&str> = pages.iter().map(|(name, _)| name.as_str()).collect();
        let mut folder = ResultFolder::begin(&out, &names, rule)?;
        for (name, text) in &pages {
            folder.add(name, |writer| Ok(writer.write_all(text)?))?;
        }
        folder.publish()?;
        stdout::print(format!("{} manual pages in {}\n", pages.len(), out.display()))
    }
}

/// Returns the name and the text of each page.
fn pages(mut program: Command) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    program.build();
    let mut pages = Vec::new();
    let mut commands = vec![program];
    while let Some(command) = commands.pop() {
        commands.extend(command.get_subcommands().cloned());
        pages.push(page(command)?);
    }
    pages.sort();
    Ok(pages)
}

fn page(command: Command) -> Result<(String, Vec<u8>), Failure> {
    let page = Man::new(command).source(concat!("nextview ", env!("CARGO_PKG_VERSION")));
    let mut text = Vec::new();
    page.render(&mut text).map_err(Failure::data)?;
    Ok((page.get_filename(), text))
}
