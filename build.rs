//! Generates Rust from `proto/piad/v1/fitting.proto`, without a protoc binary: the service for the
//! server, the client for its tests, and the descriptors for reflection. And unpacks the files of
//! Swagger UI that the reference of the API is made of.

use std::error::Error;
use std::fs::File;
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};
use std::process::Command;

use protox::prost::Message;
use utoipa_swagger_ui_vendored::SWAGGER_UI_VENDORED;
use zip::ZipArchive;

const PROTO: &str = "proto/piad/v1/fitting.proto";

/// Messages that carry geometry. The server makes them once for all readers and sends them as the
/// bytes that they are.
const ENCODED: [&str; 5] = [
    "FitResponse",
    "GetInputResponse",
    "GetIterationResponse",
    "GetResultResponse",
    "WatchJobResponse",
];

/// What a page needs of Swagger UI, and what its licence asks to be passed on.
const REFERENCE: [&str; 4] = [
    "dist/swagger-ui-bundle.js",
    "dist/swagger-ui.css",
    "LICENSE",
    "NOTICE",
];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=proto");
    name_version();
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    let descriptors = protox::compile([PROTO], ["proto"])?;
    std::fs::write(out.join("fitting.bin"), descriptors.encode_to_vec())?;

    let mut server = tonic_prost_build::configure().build_client(false);
    for message in ENCODED {
        let path = format!(".piad.v1.{message}");
        server = server.extern_path(path, "crate::api::stream::encoded::Encoded");
    }
    server.compile_fds(descriptors.clone())?;

    let client = out.join("client");
    std::fs::create_dir_all(&client)?;
    tonic_prost_build::configure()
        .build_server(false)
        .out_dir(client)
        .compile_fds(descriptors)?;
    unpack_reference(&out)
}

/// Gives the program its version with the commit that it is built from, if that is known: from the
/// variable `PIAD_COMMIT`, for builds without a repository, or for releases from git. Other builds do
/// not ask git, so that a commit does not build everything again.
fn name_version() {
    println!("cargo::rerun-if-env-changed=PIAD_COMMIT");
    let given = std::env::var("PIAD_COMMIT").ok();
    let released = std::env::var("PROFILE").is_ok_and(|profile| profile == "release");
    let commit = given
        .map(|commit| commit.trim().to_owned())
        .filter(|commit| !commit.is_empty())
        .or_else(|| released.then(commit_of_repository).flatten())
        .unwrap_or_default();
    let version = env!("CARGO_PKG_VERSION");
    let version = match commit.as_str() {
        "" => version.to_owned(),
        commit => format!("{version} ({commit})"),
    };
    println!("cargo::rustc-env=PIAD_VERSION={version}");
    println!("cargo::rustc-env=PIAD_BUILD_COMMIT={commit}");
}

/// The commit of the repository, if the project is one and not only somewhere inside of one.
fn commit_of_repository() -> Option<String> {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).canonicalize().ok()?;
    let root = git(&["rev-parse", "--show-toplevel"])?;
    if Path::new(&root).canonicalize().ok()? != project {
        return None;
    }
    // What changes with the commit. A file that is not there would count as changed every time.
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
    let names = [
        Some("HEAD"),
        Some("logs/HEAD"),
        Some("packed-refs"),
        branch.as_deref(),
    ];
    for name in names.into_iter().flatten() {
        if let Some(path) = git(&["rev-parse", "--git-path", name])
            && Path::new(&path).exists()
        {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    git(&["rev-parse", "--short=12", "HEAD"])
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    (output.status.success() && !text.trim().is_empty()).then(|| text.trim().to_owned())
}

/// Writes the files out of the archive that the crate holds.
fn unpack_reference(out: &Path) -> Result<(), Box<dyn Error>> {
    let mut archive = ZipArchive::new(Cursor::new(SWAGGER_UI_VENDORED))?;
    for name in REFERENCE {
        let ending = format!("/{name}");
        let found = archive
            .file_names()
            .flatten()
            .find(|path| path.ends_with(&ending));
        let path = found.ok_or(name)?.into_owned();
        let name = name.trim_start_matches("dist/");
        let mut file = File::create(out.join(name))?;
        io::copy(&mut archive.by_name(&path)?, &mut file)?;
    }
    Ok(())
}
