//! The command line of the program.

use std::path::PathBuf;

use clap::{Parser, Subcommand};
use clap_complete::Shell;

use super::Config;
use super::fit_arguments::FitArguments;
use super::listen::Listen;
use super::values::{Lifetime, Storage};
use crate::access::scope::Scope;

/// Curve and surface fitting by progressive iterative approximation, every iteration streamed.
#[derive(Debug, Parser)]
#[command(name = "piad", version = env!("PIAD_VERSION"), long_version = concat!(env!("PIAD_VERSION"), "\n", env!("PIAD_FEATURES")), about, args_conflicts_with_subcommands = true)]
pub struct Cli {
    /// The command; the default is serve.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Settings of the server.
    #[command(flatten)]
    pub config: Config,
}

/// The commands of the program.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Serve fitting jobs over HTTP (the default command).
    Serve(Box<Config>),
    /// Write the settings of a server with these flags, variables and file, each with its source.
    Config(Box<Config>),
    /// Ask a running server whether it is ready; exit with 0 if it is (for containers).
    Health {
        /// The address of the server, a Unix domain socket first if there are several; 0.0.0.0 and :: mean
        /// this machine.
        #[arg(
            long,
            env = "PIAD_LISTEN",
            value_delimiter = ',',
            value_name = "PLACE",
            default_value = "127.0.0.1:8080"
        )]
        listen: Vec<Listen>,
        /// The certificate of the server, if it uses HTTPS; the certificate is not verified.
        #[arg(long, env = "PIAD_TLS_CERT", value_name = "FILE")]
        tls_cert: Option<PathBuf>,
        /// A file of settings, for the address and the certificate.
        #[arg(long = "config", env = "PIAD_CONFIG", value_name = "FILE")]
        config_file: Option<PathBuf>,
        /// Seconds to wait for the answer.
        #[arg(long, default_value = "3")]
        timeout: u64,
    },
    /// Fit the points of a file, or a job, and write the result; no server is needed.
    Fit(Box<FitArguments>),
    /// Copy, check, repair or export stored jobs, while no server uses them.
    #[command(subcommand)]
    Store(StoreCommand),
    /// Create, list and revoke the tokens of a server.
    #[command(subcommand)]
    Token(TokenCommand),
    /// Write completions for a shell to the standard output.
    Completions {
        /// The shell.
        shell: Shell,
    },
    /// Write a manual page to the standard output, in the format of man(1).
    Man {
        /// The command of the page, such as fit [default: the program].
        command: Option<String>,
    },
}

/// Commands for tokens.
#[derive(Debug, Subcommand)]
pub enum TokenCommand {
    /// Create a token and write it to the standard output. It cannot be shown again: the file keeps only its hash.
    Create {
        /// The file, created if it is missing.
        #[arg(long, env = "PIAD_TOKENS", value_name = "FILE")]
        tokens: PathBuf,
        /// The tenant that owns the jobs made with it. A tenant sees only its own jobs.
        #[arg(long, default_value = "default", value_name = "NAME")]
        tenant: String,
        /// The scopes of the token.
        #[arg(
            long,
            value_enum,
            value_delimiter = ',',
            default_value = "jobs:read,jobs:write"
        )]
        scope: Vec<Scope>,
        /// Lifetime, such as 720h, or never.
        #[arg(long, default_value = "2160h", value_name = "TIME")]
        expires: Lifetime,
        /// A note on its purpose, such as the name of its owner.
        #[arg(long, value_name = "TEXT")]
        note: Option<String>,
    },
    /// Write all tokens of a file, without the tokens themselves.
    List {
        /// The file.
        #[arg(long, env = "PIAD_TOKENS", value_name = "FILE")]
        tokens: PathBuf,
    },
    /// Remove a token from a file; servers refuse it within two seconds.
    Revoke {
        /// The file.
        #[arg(long, env = "PIAD_TOKENS", value_name = "FILE")]
        tokens: PathBuf,
        /// The id of the token, as in lists and the log.
        id: String,
    },
}

/// Commands for stores.
#[derive(Debug, Subcommand)]
pub enum StoreCommand {
    /// Copy all jobs, their results and idempotency keys into another store, which keeps its own. An
    /// interrupted copy can be repeated.
    Copy {
        /// The source: a directory, or the URL of a PostgreSQL database.
        from: Storage,
        /// The destination.
        to: Storage,
    },
    /// Read everything in a store and report damage; the store is not changed. Exit status 1 if anything is damaged.
    Check {
        /// A directory, or the URL of a PostgreSQL database.
        store: Storage,
    },
    /// Replace a damaged file by a new one with all readable jobs; the damaged one is kept beside it. Jobs whose
    /// results are lost run again.
    Repair {
        /// The directory of the file.
        store: Storage,
    },
    /// Write each readable job as ID.json, which POST /v1/jobs accepts, and its result as ID.result.json;
    /// the store is not changed. Exit status 1 if anything is damaged.
    Export {
        /// A directory, or the URL of a PostgreSQL database.
        store: Storage,
        /// The directory of the files.
        directory: PathBuf,
    },
}
