//! What the user reads: text on standard output, notes on standard error, JSON where it was asked for.

use std::{
    fmt::Display,
    io::{self, Write},
    path::Path,
};

use dermis::{Error, Result, asset};
use serde::Serialize;

use crate::options::ReportOptions;

/// Standard output and standard error under one roof; a closed pipe is an [`Error::File`] that `main` keeps silent.
#[derive(Clone, Debug)]
pub(crate) struct Console {
    quiet: bool,
    json_on_stdout: bool,
}

impl Console {
    pub(crate) fn new(options: &ReportOptions) -> Self {
        Self {
            quiet: options.quiet,
            json_on_stdout: options.json.as_deref() == Some(Path::new("-")),
        }
    }

    /// Nothing but errors is wanted.
    pub(crate) fn quiet(&self) -> bool {
        self.quiet
    }

    /// The command's text: on standard output, or on standard error where JSON has the former.
    pub(crate) fn text(&self, text: impl Display) -> Result<()> {
        if self.quiet {
            return Ok(());
        }
        if self.json_on_stdout {
            writeln!(io::stderr(), "{text}").map_err(stderr)
        } else {
            writeln!(io::stdout(), "{text}").map_err(stdout)
        }
    }

    /// Something by the way: always on standard error.
    pub(crate) fn note(&self, text: impl Display) -> Result<()> {
        if self.quiet {
            return Ok(());
        }
        writeln!(io::stderr(), "{text}").map_err(stderr)
    }
}

/// A line on standard error, even when quiet; where that is closed, nobody is left to tell.
pub(crate) fn complain(line: impl Display) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Writes `value` where `--json` says, if it says so.
pub(crate) fn json(options: &ReportOptions, value: &impl Serialize) -> Result<()> {
    let Some(path) = &options.json else {
        return Ok(());
    };
    let mut text = serde_json::to_string_pretty(value)
        .map_err(|e| Error::argument("--json", e.to_string()))?;
    text.push('\n');
    if path == Path::new("-") {
        let mut out = io::stdout().lock();
        out.write_all(text.as_bytes())
            .and_then(|()| out.flush())
            .map_err(stdout)
    } else {
        asset::write_atomic(path, |out| out.write_all(text.as_bytes()))
    }
}

fn stdout(source: io::Error) -> Error {
    Error::file("standard output", source)
}

fn stderr(source: io::Error) -> Error {
    Error::file("standard error", source)
}
