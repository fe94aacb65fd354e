//! What operators and generic clients expect of a gRPC server: reflection and health.

use futures_util::stream;
use tonic::Code;
use tonic::transport::{Channel, Endpoint};
use tonic_health::pb::HealthCheckRequest;
use tonic_health::pb::health_check_response::ServingStatus;
use tonic_health::pb::health_client::HealthClient;
use tonic_reflection::pb::{v1, v1alpha};

use crate::support::{NEVER, Server, authorization, eventually};

const SERVICE: &str = "piad.v1.FittingService";

async fn channel(server: &Server) -> Channel {
    let endpoint = Endpoint::from_shared(server.url.clone()).unwrap();
    endpoint.connect().await.unwrap()
}

#[tokio::test]
async fn reflection_lists_the_service() {
    use v1::server_reflection_request::MessageRequest;
    use v1::server_reflection_response::MessageResponse;
    let server = Server::start().await;
    let channel = channel(&server).await;
    let mut client = v1::server_reflection_client::ServerReflectionClient::new(channel.clone());
    let ask = |request| v1::ServerReflectionRequest {
        host: String::new(),
        message_request: Some(request),
    };
    let requests = [
        MessageRequest::ListServices(String::new()),
        MessageRequest::FileContainingSymbol("piad.v1.JobInput".to_owned()),
    ];
    let requests = stream::iter(requests.map(ask));
    let mut answers = client
        .server_reflection_info(requests)
        .await
        .unwrap()
        .into_inner();
    let services = answers.message().await.unwrap().unwrap().message_response;
    let Some(MessageResponse::ListServicesResponse(services)) = services else {
        panic!("services");
    };
    let names: Vec<&str> = services.service.iter().map(|it| it.name.as_str()).collect();
    assert!(names.contains(&SERVICE), "{names:?}");
    assert!(names.contains(&"grpc.health.v1.Health"), "{names:?}");
    let file = answers.message().await.unwrap().unwrap().message_response;
    assert!(matches!(
        file,
        Some(MessageResponse::FileDescriptorResponse(_))
    ));

    // Older clients know the alpha version only.
    let mut client = v1alpha::server_reflection_client::ServerReflectionClient::new(channel);
    let request = v1alpha::ServerReflectionRequest {
        host: String::new(),
        message_request: Some(
            v1alpha::server_reflection_request::MessageRequest::ListServices(String::new()),
        ),
    };
    let request = stream::iter([request]);
    let mut answers = client
        .server_reflection_info(request)
        .await
        .unwrap()
        .into_inner();
    let answer = answers.message().await.unwrap().unwrap();
    assert!(format!("{answer:?}").contains(SERVICE));
}

#[tokio::test]
async fn health_is_reported_until_the_server_ends() {
    // Waiting for the grace period would take forever.
    let server = Server::with(|config| config.grace = NEVER).await;
    let mut client = HealthClient::new(channel(&server).await);
    for service in ["", SERVICE] {
        let request = || HealthCheckRequest {
            service: service.to_owned(),
        };
        // The service is announced as soon as the server is there.
        eventually("it serves", async || match client.check(request()).await {
            Ok(answer) => answer.into_inner().status() == ServingStatus::Serving,
            Err(status) => {
                assert_eq!(status.code(), Code::NotFound);
                false
            }
        })
        .await;
    }
    let request = HealthCheckRequest {
        service: "unknown".to_owned(),
    };
    let unknown = client.check(request).await.unwrap_err();
    assert_eq!(unknown.code(), Code::NotFound);
    let request = HealthCheckRequest {
        service: SERVICE.to_owned(),
    };
    let mut watch = client.watch(request).await.unwrap().into_inner();
    let first = watch.message().await.unwrap().unwrap();
    assert_eq!(first.status(), ServingStatus::Serving);
    server.stop().await;
    // It may or may not receive that the server has stopped serving.
    let ended = loop {
        match watch.message().await {
            Ok(Some(answer)) => assert_eq!(answer.status(), ServingStatus::NotServing),
            ended => break ended,
        }
    };
    assert_eq!(ended.unwrap_err().code(), Code::Unavailable);
}

/// What a call ends with, as it comes over the wire: its code, and whether its head was all of it.
async fn call(server: &Server, path: &str, message: &[u8]) -> (Code, bool) {
    let address = server.url.strip_prefix("http://").unwrap();
    let stream = tokio::net::TcpStream::connect(address).await.unwrap();
    let (mut client, connection) = h2::client::handshake(stream).await.unwrap();
    let connection = tokio::spawn(connection);
    let mut request = axum::http::Request::post(format!("{}{path}", server.url))
        .header("content-type", "application/grpc")
        .header("te", "trailers");
    if let Some(token) = authorization() {
        request = request.header("authorization", token);
    }
    let request = request.body(()).unwrap();
    let (response, mut body) = client.send_request(request, false).unwrap();
    body.send_data(message.to_vec().into(), true).unwrap();
    let (head, mut body) = response.await.unwrap().into_parts();
    assert_eq!(head.status, 200);
    let whole = body.is_end_stream();
    while let Some(data) = body.data().await {
        data.unwrap();
    }
    let trailers = body.trailers().await.unwrap().unwrap_or_default();
    connection.abort();
    let status = head
        .headers
        .get("grpc-status")
        .or(trailers.get("grpc-status"));
    (Code::from_bytes(status.unwrap().as_bytes()), whole)
}

const HEALTH: &str = "/grpc.health.v1.Health";
const REFLECTION: &str = "/grpc.reflection.v1.ServerReflection";

/// A message behind its length.
fn framed(message: &[u8]) -> Vec<u8> {
    let length = u32::try_from(message.len()).unwrap().to_be_bytes();
    [&[0], &length[..], message].concat()
}

/// Clients in other languages wait for more after a head that does not end the call.
#[tokio::test]
async fn calls_that_fail_at_once_end_with_their_head() {
    let server = Server::start().await;
    // Field 1, a text.
    let unknown = framed(b"\x0a\x06nobody");
    for (service, method, code) in [
        (HEALTH, "Check", Code::NotFound),
        (HEALTH, "List", Code::Unimplemented),
        (HEALTH, "Nothing", Code::Unimplemented),
        (REFLECTION, "Nothing", Code::Unimplemented),
        (
            "/grpc.reflection.v1alpha.ServerReflection",
            "Nothing",
            Code::Unimplemented,
        ),
        ("/piad.v1.FittingService", "Nothing", Code::Unimplemented),
    ] {
        let path = format!("{service}/{method}");
        assert_eq!(call(&server, &path, &unknown).await, (code, true), "{path}");
    }
}

#[tokio::test]
async fn unreadable_messages_are_client_errors() {
    let server = Server::start().await;
    let compressed = [1, 0, 0, 0, 1, 0];
    let unknown_flag = [9, 0, 0, 0, 1, 0];
    for message in [
        &framed(b"\xff\xff")[..],
        // A text that is longer than the message.
        &framed(b"\x0a\x7fx"),
        // A message that is shorter than announced, and none.
        &framed(b"\x0a\x01x")[..6],
        b"",
        &compressed,
        &unknown_flag,
    ] {
        for path in [
            "/piad.v1.FittingService/GetJob",
            "/piad.v1.FittingService/Fit",
            "/grpc.health.v1.Health/Check",
        ] {
            let (code, whole) = call(&server, path, message).await;
            assert_eq!(
                (code, whole),
                (Code::InvalidArgument, true),
                "{path} {message:?}"
            );
        }
    }
}
