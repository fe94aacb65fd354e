//! The program: parses the command line and runs the command.

use std::env;
use std::io::IsTerminal;
use std::process::ExitCode;
use std::time::Duration;

use piad::command;
use piad::config::listen::Listen;
use piad::config::{self, Command, Config, LogFormat};
use piad::server;
use piad::server::probe::probe;
use piad::signals;
use piad::telemetry::endpoint::Endpoint;
use piad::telemetry::{self, Telemetry};
use piad::terminal::say;
use piad::trim;
use tracing::{error, info};
use tracing_subscriber::{EnvFilter, Layer, fmt};

/// All threads allocate and free frames of long curves, megabytes each, which makes the allocator of the C library hold
/// several times the memory in use. The memory that this allocator holds is returned by [`trim`].
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    let (cli, sources) = match config::parse(env::args_os().collect()) {
        Ok(parsed) => parsed,
        Err(error) => error.exit(),
    };
    match cli.command {
        None => serve(cli.config),
        Some(Command::Serve(config)) => serve(*config),
        Some(Command::Health {
            listen,
            tls_cert,
            timeout,
            ..
        }) => health(&listen, tls_cert.is_some(), timeout),
        Some(Command::Config(_)) => command::shells::show(sources.shown().as_bytes()),
        Some(Command::Fit(arguments)) => command::fit(&arguments),
        Some(Command::Store(arguments)) => command::store::run(&arguments),
        Some(Command::Token(arguments)) => command::token::run(&arguments),
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
            say(format_args!("piad: {reason}"));
            return ExitCode::from(2);
        }
    };
    let grace = config.grace;
    let code = serve_until_the_end(config, telemetry.as_ref());
    // The spans of all tasks have ended, as the runtime has.
    if let Some(telemetry) = telemetry {
        telemetry.stop(grace);
    }
    code
}

#[tokio::main]
async fn serve_until_the_end(config: Config, telemetry: Option<&Telemetry>) -> ExitCode {
    if let Err(reason) = start_log(&config, telemetry) {
        say(format_args!("piad: --log {:?}: {reason}", config.log));
        return ExitCode::from(2);
    }
    let interrupted = signals::interrupted();
    let exit_with_stdin = config.exit_with_stdin;
    let stopped = async move {
        match exit_with_stdin {
            true => tokio::select! {
                () = interrupted => {}
                () = signals::stdin_ended() => info!("the standard input has ended"),
            },
            false => interrupted.await,
        }
    };
    let mut listeners = Vec::new();
    for place in &config.listen {
        match place.bind().await {
            Ok(bound) => listeners.extend(bound),
            Err(reason) => {
                error!("cannot listen on {place}: {reason}");
                return ExitCode::FAILURE;
            }
        }
    }
    tokio::spawn(trim::network());
    match server::serve(listeners, config, stopped).await {
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
async fn health(places: &[Listen], is_secure: bool, timeout: u64) -> ExitCode {
    let mut sockets = places.iter().filter(|it| matches!(it, Listen::Unix(_)));
    let Some(place) = sockets.next().or(places.first()) else {
        say("piad: no listen address is configured");
        return ExitCode::FAILURE;
    };
    match probe(place, is_secure, Duration::from_secs(timeout)).await {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            say(format_args!("piad: {place} is not ready: {reason}"));
            ExitCode::FAILURE
        }
    }
}

fn start_log(config: &Config, telemetry: Option<&Telemetry>) -> Result<(), String> {
    let filter = EnvFilter::try_new(&config.log).map_err(|reason| reason.to_string())?;
    // A line that cannot be written is lost; reporting that on the same standard error would panic.
    let log = fmt::layer()
        .log_internal_errors(false)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal());
    let log = match config.log_format {
        LogFormat::Text => log.boxed(),
        LogFormat::Json => log.json().boxed(),
    };
    telemetry::start_log(log, filter, telemetry)
}
