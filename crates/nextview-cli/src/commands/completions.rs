use crate::{Failure, stdout};
use clap::{Args, Command};
use clap_complete::Shell;

/// Print a shell completion script.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

const EXAMPLES: &str = "\
Examples:
  nextview completions bash > ~/.local/share/bash-completion/completions/nextview
  nextview completions zsh > ~/.zfunc/_nextview        with ~/.zfunc in fpath
  nextview completions fish > ~/.config/fish/completions/nextview.fish";

impl CompletionsArgs {
    /// Prints the completion script of this program.
    pub fn run(self, mut program: Command) -> Result<(), Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut program, "nextview", &mut script);
        stdout::print(script)
    }
}
