"""Uses the API from a page of another origin, in Chromium: fetch, streams, EventSource, preflight.

    cors_check.py PROGRAM            # the server to start, such as target/debug/piad

Needs the packages of requirements.txt, and Debian's chromium and chromium-driver.
"""

import http.server
import shutil
import sys
import tempfile
import threading

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

from over_http import server

FLAGS = """
    --headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking
    --disable-component-update --disable-sync --disable-dev-shm-usage
""".split()

# Checks that run in the page and return their observations. BASE is the API.
CHECKS = {
    "a fetch with headers that need a preflight": """
        const post = () => fetch(BASE + "/v1/jobs", {
            method: "POST",
            headers: {"Content-Type": "application/json", "Prefer": "wait=60", "Idempotency-Key": "k", "X-Request-Id": "page-1"},
            body: JSON.stringify({curve: {points: [[0, 0], [1, 2], [3, 1], [4, 3]]}}),
        });
        const first = await post(), again = await post();
        window.job = await first.json();
        return {
            status: first.status,
            state: job.state,
            location: first.headers.get("Location") === job.links.self,
            applied: first.headers.get("Preference-Applied"),
            request: first.headers.get("X-Request-Id"),
            replayed: again.headers.get("Idempotency-Replayed"),
            same: (await again.json()).id === job.id,
        };
    """,
    "a stream that is the answer to a POST": """
        const response = await fetch(BASE + "/v1/jobs", {
            method: "POST",
            headers: {"Content-Type": "application/json", "Accept": "text/event-stream"},
            body: JSON.stringify({curve: {points: [[0, 0], [1, 2], [3, 1], [4, 3]]}}),
        });
        let text = "";
        const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
        for (let part; !(part = await reader.read()).done;) text += part.value;
        return {status: response.status, begins: text.includes("event: job"), ends: text.includes("event: end")};
    """,
    "an EventSource": """
        const seen = await new Promise((resolve, reject) => {
            const names = {job: 0, iteration: 0, end: 0};
            const source = new EventSource(BASE + job.links.events + "?last_event_id=0");
            for (const name in names) source.addEventListener(name, () => {
                names[name] += 1;
                if (name === "end") { source.close(); resolve(names); }
            });
            source.onerror = () => reject(new Error("the stream has broken off"));
        });
        return {job: seen.job, iterations: seen.iteration === job.iteration, end: seen.end};
    """,
    "a stream that is resumed by its header": """
        const response = await fetch(BASE + job.links.events, {headers: {"Last-Event-ID": "1"}});
        await response.text();
        return {status: response.status, after: response.headers.get("Piad-Resumed-After")};
    """,
    "a file with its name": """
        const response = await fetch(BASE + job.links.result + "/step");
        return {status: response.status, named: response.headers.get("Content-Disposition").includes(".step")};
    """,
    "a problem with its reason": """
        const response = await fetch(BASE + "/v1/jobs", {
            method: "POST", headers: {"Content-Type": "application/json"}, body: "{}",
        });
        return {status: response.status, explained: (await response.json()).errors.length > 0};
    """,
    "a deletion": """
        const response = await fetch(BASE + job.links.self, {method: "DELETE"});
        const gone = await fetch(BASE + job.links.self);
        return {status: response.status, gone: gone.status};
    """,
}
EXPECTED = {
    "a fetch with headers that need a preflight": {
        "status": 201, "state": "converged", "location": True, "applied": "wait=60", "request": "page-1",
        "replayed": "true", "same": True,
    },
    "a stream that is the answer to a POST": {"status": 200, "begins": True, "ends": True},
    "an EventSource": {"job": 1, "iterations": True, "end": 1},
    "a stream that is resumed by its header": {"status": 200, "after": "1"},
    "a file with its name": {"status": 200, "named": True},
    "a problem with its reason": {"status": 422, "explained": True},
    "a deletion": {"status": 204, "gone": 404},
}

# Requests that a browser must block.
REFUSED = """
    const failures = {};
    await fetch(BASE + "/v1/jobs").catch(error => { failures.get = error.name; });
    await fetch(BASE + "/v1/jobs", {
        method: "POST", headers: {"Content-Type": "application/json"}, body: "{}",
    }).catch(error => { failures.post = error.name; });
    failures.events = await new Promise(resolve => {
        const source = new EventSource(BASE + "/v1/jobs/00000000-0000-0000-0000-000000000000/events");
        source.onerror = () => resolve(source.readyState);
    });
    return failures;
"""


class Page(http.server.BaseHTTPRequestHandler):
    """An empty page."""

    def do_GET(self):
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(b"<!doctype html><title>a page</title>")

    def log_message(self, *_):
        pass


def run(browser, base: str, script: str):
    """The result of an asynchronous function in the page."""
    body = f"const BASE = {base!r};\n{script}"
    wrapped = f"const done = arguments[0]; (async () => {{ {body} }})().then(done, error => done(String(error)));"
    return browser.execute_async_script(wrapped)


def start_browser(profile: str, *flags: str):
    options = Options()
    options.binary_location = shutil.which("chromium")
    for flag in [*FLAGS, *flags, f"--user-data-dir={profile}"]:
        options.add_argument(flag)
    browser = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    browser.set_script_timeout(100)
    return browser


def check(browser, page: str, program: str) -> int:
    browser.get(page)
    failures = 0
    for origin in (page, "*"):
        with server(program, "--cors-origin", origin) as base:
            for name, script in CHECKS.items():
                seen = run(browser, base, script)
                good = seen == EXPECTED[name]
                failures += not good
                print(f"{'ok' if good else 'WRONG'}: {name}, --cors-origin {origin}" + ("" if good else f": {seen}"))
    for flags in ([], ["--cors-origin", "https://cad.example"]):
        with server(program, *flags) as base:
            seen = run(browser, base, REFUSED)
            # 2 is EventSource.CLOSED: it does not reconnect.
            good = seen == {"get": "TypeError", "post": "TypeError", "events": 2}
            failures += not good
            print(f"{'ok' if good else 'WRONG'}: nothing for pages that are not listed, {flags}" + ("" if good else f": {seen}"))
    return failures


def main() -> int:
    pages = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Page)
    threading.Thread(target=pages.serve_forever, daemon=True).start()
    page = f"http://localhost:{pages.server_port}"
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = start_browser(profile)
        try:
            return 1 if check(browser, page, sys.argv[1]) else 0
        finally:
            browser.quit()


if __name__ == "__main__":
    sys.exit(main())
