//! Generates Rust from `proto/piad/v1/fitting.proto`, without a protoc binary: the service for the
//! server, the client for its tests, and the descriptors for reflection. And unpacks the files of
//! Swagger UI that the reference of the API is made of.

use std::error::Error;
use std::fs::File;
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};

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
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    let descriptors = protox::compile([PROTO], ["proto"])?;
    std::fs::write(out.join("fitting.bin"), descriptors.encode_to_vec())?;

    let mut server = tonic_prost_build::configure().build_client(false);
    for message in ENCODED {
        let path = format!(".piad.v1.{message}");
        server = server.extern_path(path, "crate::api::rpc::encoded::Encoded");
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
