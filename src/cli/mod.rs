//! The program's commands.
mod bench;
mod bisect;
mod check;
mod chosen;
pub mod compare;
mod devices;
mod error;
mod graph;
mod guiding;
mod output;
mod profile;
mod reference;
mod render;
mod replay;
mod roam;
mod run;
mod scene;
mod settings;
mod stress;

pub use error::CommandError;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::process::ExitCode;

/// Real-time global illumination with surfels on wgpu, Vulkan and the CPU
#[derive(Debug, Parser)]
#[command(name = "gibs", version)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Render(Box<render::Args>),
    Reference(Box<reference::Args>),
    Compare(Box<compare::Args>),
    Check(Box<check::Args>),
    Bisect(Box<bisect::Args>),
    Replay(Box<replay::Args>),
    Graph(Box<graph::Args>),
    Profile(Box<profile::Args>),
    Stress(Box<stress::Args>),
    Roam(Box<roam::Args>),
    Guiding(Box<guiding::Args>),
    Bench(Box<bench::Args>),
    Settings(settings::Args),
    Devices(devices::Args),
}

/// Sends spans to Tracy from here on. A program that has a subscriber of its own keeps it.
#[cfg(feature = "tracy")]
fn listen() {
    use tracing_subscriber::layer::SubscriberExt;
    let layer = tracing_tracy::TracyLayer::default();
    let _ = tracing::subscriber::set_global_default(tracing_subscriber::registry().with(layer));
}

/// Leaves out what the panic hook says of kernels: it is told as an error of their stage.
#[cfg(feature = "cpu")]
fn tell_kernels_once() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !gibs_backend_cpu::in_kernel() {
            usual(panic);
        }
    }));
}

/// Runs the program: 0 done, 1 a check failed, 2 bad usage or bad input.
pub fn main() -> ExitCode {
    // A negative number by itself is a value, to be refused with its range, and no option.
    let command = Cli::command().mut_subcommands(|command| command.allow_negative_numbers(true));
    let parsed = command.try_get_matches();
    let cli = match parsed.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version go to standard output and are no failure.
            let _ = error.print();
            return if error.use_stderr() {
                ExitCode::from(2)
            } else {
                ExitCode::SUCCESS
            };
        }
    };
    #[cfg(feature = "cpu")]
    tell_kernels_once();
    #[cfg(feature = "tracy")]
    listen();
    let done = match cli.command {
        Command::Render(args) => render::run(&args),
        Command::Reference(args) => reference::run(&args),
        Command::Compare(args) => compare::run(*args).map_err(CommandError::from),
        Command::Check(args) => check::run(&args),
        Command::Bisect(args) => bisect::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Graph(args) => graph::run(&args),
        Command::Profile(args) => profile::run(&args),
        Command::Stress(args) => stress::run(&args),
        Command::Roam(args) => roam::run(&args),
        Command::Guiding(args) => guiding::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Settings(args) => settings::run(&args),
        Command::Devices(args) => devices::run(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            output::tell(&format!("error: {error}"));
            ExitCode::from(error.exit_code())
        }
    }
}
