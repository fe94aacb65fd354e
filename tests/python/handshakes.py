"""TLS handshakes and streams with openssl, curl, gRPC and Chromium.

    handshakes.py PROGRAM            # the server to start, such as target/debug/piad

Needs the packages of requirements.txt, and Debian's openssl, curl, chromium and chromium-driver.
"""

import base64
import hashlib
import json
import pathlib
import subprocess
import sys
import tempfile

import cors_check
import grpc
from grpc_client import pb, pb_grpc
from over_http import server

JOB = {"curve": {"points": [[0, 0], [1, 2], [3, 1], [4, 3]]}, "stop": {"relative_tolerance": 1e-9}}
ENDLESS = {"curve": {"points": [[0, 0], [1, 2], [3, 1], [4, 3]]}, "stop": {"tolerance": 0, "max_iterations": 1_000_000}}

# The HTTP version and the events of a job, as seen by a page.
PAGE = """
    const [entry] = performance.getEntriesByType("navigation");
    const response = await fetch(BASE + "/v1/jobs", {
        method: "POST", headers: {"Content-Type": "application/json", "Prefer": "wait=60"},
        body: JSON.stringify(JOB),
    });
    const job = await response.json();
    const seen = await new Promise((resolve, reject) => {
        const names = {job: 0, iteration: 0, end: 0};
        const source = new EventSource(BASE + job.links.events);
        for (const name in names) source.addEventListener(name, () => {
            names[name] += 1;
            if (name === "end") { source.close(); resolve(names); }
        });
        source.onerror = () => reject(new Error("the stream has broken off"));
    });
    return {protocol: entry.nextHopProtocol, job: seen.job, all: seen.iteration === job.iteration + 1, end: seen.end};
"""


class Checks:
    """Fails with the expected and actual values."""

    def __init__(self) -> None:
        self.failures = 0

    def equal(self, what: str, seen: object, expected: object) -> None:
        good = seen == expected
        self.failures += not good
        print(f"{'ok' if good else 'WRONG'}: {what}" + ("" if good else f": {seen}, not {expected}"))


class Certificates:
    """A certificate authority and its certificates, as files in a folder."""

    def __init__(self, folder: str) -> None:
        self.folder = pathlib.Path(folder)
        self.authority = self.folder / "authority.pem"
        self.openssl("req", "-x509", *self.key("authority"), "-out", self.authority, "-subj", "/CN=an authority")
        for name, other in (("server", ",IP:127.0.0.1"), ("client", "")):
            self.sign(name, f"subjectAltName=DNS:localhost{other}")

    def openssl(self, *arguments: object) -> bytes:
        return subprocess.run(["openssl", *map(str, arguments)], check=True, capture_output=True).stdout

    def key(self, name: str) -> list[object]:
        return ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-keyout", self.folder / f"{name}.key"]

    def sign(self, name: str, extension: str) -> None:
        signer = ["-CA", self.authority, "-CAkey", self.folder / "authority.key"]
        names = ["-subj", f"/CN={name}", "-addext", extension, "-addext", "basicConstraints=critical,CA:FALSE"]
        self.openssl("req", "-x509", *self.key(name), *signer, "-out", self.folder / f"{name}.pem", *names)

    def pin(self) -> str:
        """The hash of the server's public key, to make a browser trust it."""
        public = self.openssl("pkey", "-in", self.folder / "server.key", "-pubout", "-outform", "der")
        return base64.b64encode(hashlib.sha256(public).digest()).decode()

    def flags(self) -> list[str]:
        return ["--tls-cert", str(self.folder / "server.pem"), "--tls-key", str(self.folder / "server.key")]

    def own(self) -> list[str]:
        return [str(self.folder / "client.pem"), str(self.folder / "client.key")]


def openssl(checks: Checks, address: str, files: Certificates) -> None:
    def shake(*flags: str) -> list[str]:
        command = ["openssl", "s_client", "-connect", address, "-CAfile", str(files.authority), "-verify_return_error", *flags]
        said = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True)
        return [said.stdout] if said.returncode == 0 else []

    for version, name in (("-tls1_2", "TLSv1.2"), ("-tls1_3", "TLSv1.3")):
        output = "".join(shake(version))
        checks.equal(f"openssl, {name}", f"New, {name}, Cipher is" in output and "Verify return code: 0 (ok)" in output, True)
    # Debian's openssl offers it only at its lowest level of security.
    checks.equal("openssl, TLS 1.1", shake("-tls1_1", "-cipher", "DEFAULT:@SECLEVEL=0"), [])
    for offered, chosen in (("h2,http/1.1", "h2"), ("http/1.1", "http/1.1"), ("http/1.1,h2", "h2")):
        output = "".join(shake("-alpn", offered))
        checks.equal(f"openssl, ALPN {offered}", f"ALPN protocol: {chosen}\n" in output, True)


def curl(checks: Checks, base: str, files: Certificates) -> None:
    command = ["curl", "--silent", "--show-error", "--no-buffer", "--cacert", str(files.authority)]
    for flag, version in (("--http1.1", "1.1"), ("--http2", "2")):
        said = subprocess.run([*command, flag, "-w", "%{http_version}", "-o", "/dev/null", f"{base}/readyz"], capture_output=True, text=True)
        checks.equal(f"curl, HTTP/{version}", said.stdout, version)
        stream = [*command, flag, "-H", "Accept: text/event-stream", "-H", "Content-Type: application/json"]
        stream += ["-d", json.dumps(ENDLESS), f"{base}/v1/jobs"]
        # The job does not end, so events arrive before its end.
        with subprocess.Popen(stream, stdout=subprocess.PIPE, text=True) as reading:
            events = 0
            for line in reading.stdout:
                events += line.startswith("event: iteration")
                if events == 20:
                    break
            reading.terminate()
        checks.equal(f"curl, events over HTTP/{version}", events, 20)
    said = subprocess.run([*command, base.replace("https:", "http:") + "/"], capture_output=True, text=True)
    checks.equal("curl, without TLS", "https://" in said.stdout, True)


def clients(checks: Checks, base: str, files: Certificates) -> None:
    command = ["curl", "--silent", "--cacert", str(files.authority), "-o", "/dev/null", "-w", "%{http_code}", f"{base}/readyz"]
    certificate, key = files.own()
    for flags, status in ((["--cert", certificate, "--key", key], "200"), ([], "000")):
        said = subprocess.run([*command, *flags], capture_output=True, text=True)
        checks.equal(f"curl, mutual TLS, {'with' if flags else 'without'} a certificate", said.stdout, status)


def call(checks: Checks, address: str, files: Certificates) -> None:
    trusted = grpc.ssl_channel_credentials(files.authority.read_bytes())
    points = [value for point in JOB["curve"]["points"] for value in point]
    job = pb.JobInput(curve=pb.Curve(dimension=2, points=points))
    with grpc.secure_channel(address, trusted) as channel:
        asked = pb_grpc.FittingServiceStub(channel).Fit(pb.FitRequest(input=job), timeout=60)
        watched = [answer.WhichOneof("event") for answer in asked]
        checks.equal("gRPC, a stream", [watched[0], watched[-1]], ["job", "end"])
    with grpc.secure_channel(address, grpc.ssl_channel_credentials()) as channel:
        try:
            pb_grpc.FittingServiceStub(channel).ListJobs(pb.ListJobsRequest(), timeout=10)
            output = "a response"
        except grpc.RpcError as error:
            output = error.code()
        checks.equal("gRPC, an authority that is not trusted", output, grpc.StatusCode.UNAVAILABLE)


def browse(checks: Checks, base: str, files: Certificates) -> None:
    base = base.replace("127.0.0.1", "localhost")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = cors_check.start_browser(profile, f"--ignore-certificate-errors-spki-list={files.pin()}")
        try:
            browser.get(f"{base}/")
            seen = cors_check.run(browser, base, f"const JOB = {json.dumps(JOB)};{PAGE}")
        finally:
            browser.quit()
    checks.equal("Chromium", seen, {"protocol": "h2", "job": 1, "all": True, "end": 1})


def main() -> int:
    checks = Checks()
    with tempfile.TemporaryDirectory() as folder:
        files = Certificates(folder)
        with server(sys.argv[1], *files.flags(), "--max-iterations", "1000000000") as base:
            address = base.removeprefix("https://")
            openssl(checks, address, files)
            curl(checks, base, files)
            call(checks, address, files)
            browse(checks, base, files)
        with server(sys.argv[1], *files.flags(), "--tls-client-ca", str(files.authority)) as base:
            clients(checks, base, files)
        socket = pathlib.Path(folder) / "piad.sock"
        with server(sys.argv[1], "--listen", f"unix:{socket}"):
            said = subprocess.run(["curl", "--silent", "--unix-socket", str(socket), "http://localhost/readyz"], capture_output=True, text=True)
            checks.equal("curl, a Unix domain socket", said.returncode, 0)
    return min(checks.failures, 1)


if __name__ == "__main__":
    sys.exit(main())
