//! Generates Rust from `proto/piad/v1/fitting.proto`, without a protoc binary: the service for the
//! server, the client for its tests, and the descriptors for reflection.

use std::error::Error;
use std::path::PathBuf;

use protox::prost::Message;

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
    Ok(())
}
