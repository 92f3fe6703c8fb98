//! Options that the commands share.

use std::path::PathBuf;

use clap::Args;

/// What is written besides the result.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Output")]
pub(crate) struct ReportOptions {
    /// Write a report as JSON to a file, or with `-` to standard output (the text then goes to standard error).
    #[arg(long, value_name = "FILE|-")]
    pub(crate) json: Option<PathBuf>,
    /// Say nothing but errors.
    #[arg(long, short)]
    pub(crate) quiet: bool,
}
