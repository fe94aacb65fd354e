//! The program: parses the command line and starts what it asks for.

use std::io::IsTerminal;
use std::process::ExitCode;

use clap::Parser;
use piad::command;
use piad::config::{Cli, Command, Config, LogFormat};
use piad::server;
use piad::server::listen::Listen;
use piad::telemetry::endpoint::Endpoint;
use piad::telemetry::{self, Telemetry};
use piad::trim;
use tracing::{error, info};
use tracing_subscriber::{EnvFilter, Layer, fmt};

/// Frames of long curves come and go by the megabyte on all threads, which leaves the allocator of the
/// C library with several times the memory that is in use. What this one keeps is seen to by [`trim`].
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    let cli = Cli::parse();
    match cli.command {
        None => serve(cli.config),
        Some(Command::Serve(config)) => serve(*config),
        Some(Command::Health { listen, timeout }) => health(listen, timeout),
        Some(Command::Fit(arguments)) => command::fit(&arguments),
        Some(Command::Store(asked)) => command::store::run(&asked),
        Some(Command::Completions { shell }) => command::shells::completions(shell),
        Some(Command::Man { command }) => command::shells::manual(command.as_deref()),
    }
}

fn serve(config: Config) -> ExitCode {
    let endpoint = Endpoint::find(config.otlp_endpoint.as_deref());
    let telemetry = endpoint.and_then(|it| it.as_ref().map(Telemetry::start).transpose());
    let telemetry = match telemetry {
        Ok(telemetry) => telemetry,
        Err(reason) => {
            eprintln!("piad: {reason}");
            return ExitCode::from(2);
        }
    };
    let grace = config.grace;
    let code = serve_until_the_end(config, telemetry.as_ref());
    // The spans of all tasks have ended by now, as the runtime has.
    if let Some(telemetry) = telemetry {
        telemetry.stop(grace);
    }
    code
}

#[tokio::main]
async fn serve_until_the_end(config: Config, telemetry: Option<&Telemetry>) -> ExitCode {
    if let Err(reason) = start_log(&config, telemetry) {
        eprintln!("piad: --log {:?}: {reason}", config.log);
        return ExitCode::from(2);
    }
    let listeners = match config.listen.bind().await {
        Ok(listeners) => listeners,
        Err(reason) => {
            error!("cannot listen on {}: {reason}", config.listen);
            return ExitCode::FAILURE;
        }
    };
    tokio::spawn(trim::network());
    match server::serve(listeners, config, server::interrupted()).await {
        Ok(()) => {
            info!("stopped");
            ExitCode::SUCCESS
        }
        Err(reason) => {
            error!("{reason}");
            ExitCode::FAILURE
        }
    }
}

#[tokio::main(flavor = "current_thread")]
async fn health(listen: Listen, timeout: u64) -> ExitCode {
    match server::probe(&listen, std::time::Duration::from_secs(timeout)).await {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("piad: {listen} is not ready: {reason}");
            ExitCode::FAILURE
        }
    }
}

fn start_log(config: &Config, telemetry: Option<&Telemetry>) -> Result<(), String> {
    let filter = EnvFilter::try_new(&config.log).map_err(|reason| reason.to_string())?;
    let log = fmt::layer()
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal());
    let log = match config.log_format {
        LogFormat::Text => log.boxed(),
        LogFormat::Json => log.json().boxed(),
    };
    telemetry::start_log(log, filter, telemetry)
}
