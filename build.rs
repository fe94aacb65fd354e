//! Generates Rust from `proto/piad/v1/fitting.proto`, without a protoc binary: the service for the
//! server, the client for its tests, and the descriptors for reflection. Embeds the files for
//! browsers: the page from `viewer/dist`, and the API reference, which uses Swagger UI.

use std::error::Error;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{self, Cursor, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;

use flate2::Compression;
use flate2::write::GzEncoder;
use protox::prost::Message;
use sha2::{Digest, Sha256};
use utoipa_swagger_ui_vendored::SWAGGER_UI_VENDORED;
use zip::ZipArchive;

const PROTO: &str = "proto/piad/v1/fitting.proto";

/// Messages with geometry. The server encodes them once for all readers and sends the bytes.
const ENCODED: [&str; 5] = [
    "FitResponse",
    "GetInputResponse",
    "GetIterationResponse",
    "GetResultResponse",
    "WatchJobResponse",
];

/// Calls whose messages the server decodes and encodes itself, as they arrive.
const BY_HAND: [&str; 1] = ["FitBatch"];

/// The page, built by `make viewer`.
const VIEWER: &str = "viewer/dist";

/// The files of the reference that are the project's own.
const OWN_REFERENCE: [&str; 2] = ["src/api/openapi/page.html", "src/api/openapi/start.js"];

/// The required files of Swagger UI, including its licence.
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
    let mut served = descriptors.clone();
    let services = served.file.iter_mut().flat_map(|file| &mut file.service);
    for service in services {
        service
            .method
            .retain(|call| !BY_HAND.contains(&call.name()));
    }
    for message in ENCODED {
        let path = format!(".piad.v1.{message}");
        server = server.extern_path(path, "crate::api::stream::encoded::Encoded");
    }
    server.compile_fds(served)?;

    let client = out.join("client");
    std::fs::create_dir_all(&client)?;
    tonic_prost_build::configure()
        .build_server(false)
        .out_dir(client)
        .compile_fds(descriptors)?;
    let mut reference = unpack_reference(&out)?;
    reference.extend(OWN_REFERENCE.map(PathBuf::from));
    let viewer = fs::read_dir(VIEWER)?.map(|entry| entry.map(|entry| entry.path()));
    let viewer = viewer.collect::<Result<Vec<_>, _>>()?;
    println!("cargo::rerun-if-changed={VIEWER}");
    embed(&out, "viewer", viewer)?;
    embed(&out, "reference", reference)
}

/// Sets the version with the commit, if known: from the variable `PIAD_COMMIT`, for builds without
/// a repository, or from git for release builds. Other builds do not use git, so a commit does not
/// rebuild everything.
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
    println!("cargo::rustc-env=PIAD_FEATURES={}", features());
}

/// The kind of the build.
fn features() -> String {
    let variable = |name| std::env::var(name).unwrap_or_default();
    let (target, profile) = (variable("TARGET"), variable("PROFILE"));
    let simd = match variable("CARGO_CFG_TARGET_ARCH").as_str() {
        "x86_64" => ", x86-64-v3 and v4 where the machine has them",
        _ => "",
    };
    format!("features: http, grpc, fit, tls; {profile} build for {target}{simd}")
}

/// The commit of the repository, if the project is its root.
fn commit_of_repository() -> Option<String> {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).canonicalize().ok()?;
    let root = git(&["rev-parse", "--show-toplevel"])?;
    if Path::new(&root).canonicalize().ok()? != project {
        return None;
    }
    // Files that change with the commit. A missing file would always count as changed.
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

/// Extracts the files from the archive in the crate and returns their folder.
fn unpack_reference(out: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut archive = ZipArchive::new(Cursor::new(SWAGGER_UI_VENDORED))?;
    let mut unpacked = Vec::new();
    for name in REFERENCE {
        let ending = format!("/{name}");
        let found = archive
            .file_names()
            .flatten()
            .find(|path| path.ends_with(&ending));
        let path = found.ok_or(name)?.into_owned();
        let target = out.join(name.trim_start_matches("dist/"));
        io::copy(&mut archive.by_name(&path)?, &mut File::create(&target)?)?;
        unpacked.push(target);
    }
    Ok(unpacked)
}

/// Writes `{set}.rs`, a list of these files for `http::assets`: compressed, with hashes of their
/// contents.
fn embed(out: &Path, set: &str, mut files: Vec<PathBuf>) -> Result<(), Box<dyn Error>> {
    files.sort();
    let folder = out.join(set);
    fs::create_dir_all(&folder)?;
    let mut list = format!("{{ static FILES: [Asset; {}] = [\n", files.len());
    for file in files {
        // A file written by this run is always newer than the run.
        if !file.starts_with(out) {
            println!("cargo::rerun-if-changed={}", file.display());
        }
        let file = file.canonicalize()?;
        let name = file.file_name().and_then(|name| name.to_str());
        let name = name.ok_or("the name of a file is no text")?;
        let plain = fs::read(&file)?;
        let compressed = folder.join(format!("{name}.gz"));
        let mut encoder = GzEncoder::new(File::create(&compressed)?, Compression::best());
        encoder.write_all(&plain)?;
        encoder.finish()?;
        let digest = Sha256::digest(&plain);
        let hash: String = digest
            .iter()
            .take(16)
            .fold(String::new(), |mut hash, byte| {
                let _ = write!(hash, "{byte:02x}");
                hash
            });
        writeln!(
            list,
            "Asset::new({name:?}, {hash:?}, include_bytes!({compressed:?})),"
        )?;
    }
    list.push_str("]; &FILES }");
    fs::write(out.join(format!("{set}.rs")), list)?;
    Ok(())
}
