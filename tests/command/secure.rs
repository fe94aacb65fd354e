//! Servers behind TLS: certificates that are trusted, and such that are not.

use crate::remote::Server;
use crate::support::{Finished, Folder};
use crate::tls_proxy::TlsProxy;

/// A fit on a server, trusting the authorities in a file.
fn fit(folder: &Folder, authorities: &str, arguments: &[&str]) -> Finished {
    folder.write("authorities.pem", authorities);
    let mut command = folder.command(&["fit", "curve.csv"]);
    command.args(arguments);
    command.env("SSL_CERT_FILE", folder.path("authorities.pem"));
    command.env_remove("SSL_CERT_DIR");
    Finished::of(command.output().unwrap())
}

#[test]
fn a_server_with_tls_gives_the_same_bits() {
    let folder = Folder::with_curve();
    let server = Server::start(&folder);
    let proxy = TlsProxy::with_certificate_for("127.0.0.1", &server.1);
    let here = folder.result(&["curve.csv"]);
    let finished = fit(&folder, &proxy.authority, &["--server", &proxy.url]);
    assert_eq!(finished.status, 0, "{}", finished.err);
    assert_eq!(finished.json()["control_points"], here["control_points"]);
    let job = format!("job {}/v1/jobs/", proxy.url);
    assert!(finished.err.contains(&job), "{}", finished.err);
    let files = ["-o", "a.step", "--iterations", "all"];
    let finished = fit(
        &folder,
        &proxy.authority,
        &[&["--server", proxy.url.as_str()], &files[..]].concat(),
    );
    assert_eq!(finished.status, 0, "{}", finished.err);
    assert!(folder.read("a.step").starts_with(b"ISO-10303-21;"));
}

#[test]
fn untrusted_certificates_are_reported() {
    let folder = Folder::with_curve();
    let server = Server::start(&folder);
    let proxy = TlsProxy::with_certificate_for("127.0.0.1", &server.1);
    let other = TlsProxy::with_certificate_for("fits.example.org", &server.1);
    let itself = TlsProxy::with_authority(&server.1);
    for (authorities, proxy, reason) in [
        (
            &other.authority,
            &proxy,
            "an authority that is not trusted here; trusted are those of the system, or of the file that SSL_CERT_FILE names",
        ),
        (&other.authority, &other, "fits.example.org"),
        (&itself.authority, &itself, "that of an authority (CA:TRUE)"),
        (
            &String::new(),
            &proxy,
            "no certificates of authorities to trust servers by: install those of the system (ca-certificates), or name a file of them in SSL_CERT_FILE",
        ),
    ] {
        let finished = fit(
            &folder,
            authorities,
            &["--server", &proxy.url, "-o", "a.step"],
        );
        assert_eq!(finished.status, 1);
        assert!(finished.err.starts_with("piad: "), "{}", finished.err);
        assert!(finished.err.contains(&proxy.url), "{}", finished.err);
        assert!(finished.err.contains(reason), "{}", finished.err);
        assert_eq!(finished.err.lines().count(), 1, "{}", finished.err);
        // Nothing has been asked of it.
        assert_eq!(proxy.seen(), (String::new(), String::new()));
        assert!(!folder.names().contains(&"a.step".to_owned()));
    }
    // Plain HTTP needs none.
    let finished = fit(&folder, "", &["--server", &server.1]);
    assert_eq!(finished.status, 0, "{}", finished.err);
}
