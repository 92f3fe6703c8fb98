//! Command line of dermis: bake, render, bench and profile character skin; bend meshes along spines.

mod bake;
mod bench;
mod bench_report;
mod bench_run;
mod console;
mod devices;
mod flesh;
mod info;
mod options;
mod output;
mod parse;
mod png;
mod poses;
mod profile;
mod progress;
mod render;
mod samples;
mod session;
mod settled;
mod sphere_mesh;
mod stats;
mod table;
mod trace;

use std::{
    io, panic,
    process::ExitCode,
    sync::{Mutex, PoisonError},
};

use clap::{Parser, Subcommand};
use dermis::{Error, Result};

use crate::console::complain;

/// Character skin with contact and volume, on any Vulkan 1.2 device.
#[derive(Parser)]
#[command(
    name = "dermis",
    version,
    after_help = "Every command has its own --help with examples."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Devices(devices::Args),
    Info(info::Args),
    Bake(bake::Args),
    Render(render::Args),
    Bench(bench::Args),
    Profile(profile::Args),
    Flesh(flesh::Args),
    SphereMesh(sphere_mesh::Args),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    panic::set_hook(Box::new(remember_panic));
    match panic::catch_unwind(|| run(&cli.command)) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(error)) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Ok(Err(error)) => {
            complain(format_args!("error: {error}"));
            ExitCode::FAILURE
        }
        Err(_) => {
            let panic = PANIC.lock().unwrap_or_else(PoisonError::into_inner);
            complain(format_args!(
                "internal error: {panic}; please report it to the project, with the command line and the file"
            ));
            ExitCode::from(70)
        }
    }
}

fn run(command: &Command) -> Result<()> {
    match command {
        Command::Devices(args) => devices::run(args),
        Command::Info(args) => info::run(args),
        Command::Bake(args) => bake::run(args),
        Command::Render(args) => render::run(args),
        Command::Bench(args) => bench::run(args),
        Command::Profile(args) => profile::run(args),
        Command::Flesh(args) => flesh::run(args),
        Command::SphereMesh(args) => sphere_mesh::run(args),
    }
}

/// Whoever reads the output has had enough: not an error.
fn is_closed_pipe(error: &Error) -> bool {
    matches!(error, Error::File { source, .. } if source.kind() == io::ErrorKind::BrokenPipe)
}

/// The last panic, for the last line. Nothing is printed here: the library catches the panics of others.
static PANIC: Mutex<String> = Mutex::new(String::new());

fn remember_panic(info: &panic::PanicHookInfo) {
    let text = info.to_string().replace('\n', " ");
    *PANIC.lock().unwrap_or_else(PoisonError::into_inner) = text;
}
