"""Checks deploy/ with Compose, Kubernetes schemas, Prometheus and Grafana, and that it uses only
existing metrics.

    make deploy

or, with the packages of requirements.txt and Debian's docker-compose, caddy and prometheus:

    tests/postgres python3 tests/python/deploy.py target/debug/piad

Checks:

- compose.yaml: by a parser of the Compose specification, and by docker-compose, which resolves
  variables and references. Mounted files exist. No container is started.
- Caddyfiles: by Caddy.
- kubernetes/: by overlays.py. Nothing runs in a cluster.
- alerts: by promtool, as a container of compose.yaml would see them, and their tests.
- metrics: alerts and dashboard use only those of real servers, one of them with a database.
"""

import json
import os
import pathlib
import re
import shutil
import sys
import tempfile
import urllib.request

import yaml
from caddyfile import of_debian
from compose_spec import PyCompose
from over_http import fetch, server
from overlays import check, kubernetes, read, run

ROOT = pathlib.Path(__file__).resolve().parents[2]
DEPLOY = ROOT / "deploy"


# Compose


def mounts(service: dict) -> dict[str, str]:
    """The mounted files of this directory, by their paths in the container."""
    volumes = (volume.split(":") for volume in service.get("volumes", []))
    return {to: source for source, to, *_ in volumes if source.startswith(".")}


def compose() -> dict:
    path = DEPLOY / "compose.yaml"
    [content] = read(path)
    # YAML's merges (<<) are resolved by then.
    PyCompose.from_json(json.dumps(content)).validate()
    run("docker-compose", "-f", path, "config", "--quiet")
    services = content["services"]
    files = [config["file"] for config in content["configs"].values()]
    files += [source for service in services.values() for source in mounts(service).values()]
    for file in files:
        check((DEPLOY / file).is_file(), f"compose.yaml mounts {file}, which is no file")
    for name, service in services.items():
        for port in service.get("ports", []):
            check(name == "tls" or port.startswith("127.0.0.1:"), f"{name} listens beyond this machine: {port}")
    check({"many", "tls", "observe"} == {p for s in services.values() for p in s.get("profiles", [])}, "other profiles")
    return content


def caddyfiles() -> None:
    environment = os.environ | {"PIAD_DOMAIN": "fit.example.org"}
    for name in ("Caddyfile", "Caddyfile.tls"):
        with tempfile.NamedTemporaryFile("w", prefix=name) as file:
            file.write(of_debian(DEPLOY / name))
            file.flush()
            run("caddy", "validate", "--adapter", "caddyfile", "--config", file.name, env=environment)


# Prometheus and Grafana


def prometheus(content: dict) -> None:
    with tempfile.TemporaryDirectory() as folder:
        for to, source in mounts(content["services"]["prometheus"]).items():
            target = pathlib.Path(folder) / pathlib.Path(to).relative_to("/etc/prometheus")
            target.parent.mkdir(exist_ok=True)
            shutil.copy(DEPLOY / source, target)
        output = run("promtool", "check", "config", pathlib.Path(folder) / "prometheus.yml")
        check(f"{len(alerts())} rules found" in output, f"prometheus.yml does not load all rules:\n{output}")
    run("promtool", "test", "rules", DEPLOY / "alerts" / "tests.yml")
    tests = (DEPLOY / "alerts" / "tests.yml").read_text()
    operations = (ROOT / "docs/how-to/operate.md").read_text()
    for alert in alerts():
        name, about = alert["alert"], alert["annotations"]
        check(f'alertname="{name}"' in tests, f"no test in which {name} fires")
        check(f"| `{name}` |" in operations, f"docs/how-to/operate.md does not describe {name}")
        section = re.search(r'See "(.+)" in docs/how-to/operate\.md\.$', about["description"])
        check(section and f"\n## {section[1]}\n" in operations, f"{name} names no section of docs/how-to/operate.md")
        check(about["summary"] and alert["labels"]["severity"] in ("critical", "warning"), f"{name} lacks a summary or severity")
    for name in re.findall(r"\| `(Piad\w+)` \|", operations):
        check(name in [alert["alert"] for alert in alerts()], f"docs/how-to/operate.md describes the unknown alert {name}")


def alerts() -> list[dict]:
    [content] = read(DEPLOY / "alerts" / "piad.yml")
    return [rule for group in content["groups"] for rule in group["rules"]]


def dashboard(content: dict) -> list[str]:
    """The queries of the dashboard, after checking its source and variables."""
    mounted = mounts(content["services"]["grafana"])
    board = json.loads((DEPLOY / mounted["/etc/grafana/dashboards/piad.json"]).read_text())
    variables = {variable["name"]: variable for variable in board["templating"]["list"]}
    ids = [panel["id"] for panel in board["panels"]]
    check(len(ids) == len(set(ids)), "panels share an id")
    queries = [variables["instance"]["query"]["query"]]
    for panel in board["panels"]:
        if panel["type"] == "row":
            continue
        for part in (panel, *panel["targets"]):
            check(part["datasource"]["uid"] == "${DS_PROMETHEUS}", f"{panel['title']}: another source")
        queries += [target["expr"] for target in panel["targets"]]
    used = set(re.findall(r"\$\{?(\w+)", json.dumps(board)))
    check(used <= {*variables, "__rate_interval"}, f"{used - set(variables)}: no such variables")
    # Replaces the variables of Grafana.
    plain = [query.replace("$__rate_interval", "1m").replace("$instance", ".*") for query in queries[1:]]
    with tempfile.NamedTemporaryFile("w", suffix=".yml") as file:
        rules = [{"record": f"panel:{index}", "expr": query} for index, query in enumerate(plain)]
        yaml.safe_dump({"groups": [{"name": "dashboard", "rules": rules}]}, file)
        file.flush()
        run("promtool", "check", "rules", file.name)
    return queries


# Metrics


def post(base: str, path: str, body: dict, wait: int = 60) -> dict:
    headers = {"Content-Type": "application/json", "Prefer": f"wait={wait}"}
    request = urllib.request.Request(base + path, json.dumps(body).encode(), headers)
    with urllib.request.urlopen(request) as response:
        return json.load(response)


def shown(program: str, store: str) -> str:
    """The metrics of a server after a job of each outcome that alerts use."""
    circle = [[i % 7, i * i % 11, i] for i in range(50)]
    overflowing = {"points": [[2e306 * (-1) ** i] for i in range(20)], "basis": {"kind": "bernstein"}, "parameters": "uniform"}
    with server(program, store=store) as base:
        states = [post(base, "/v1/jobs", {"curve": curve})["state"] for curve in ({"points": circle}, overflowing)]
        endless = {"curve": {"points": circle}, "stop": {"tolerance": 0, "max_iterations": 1_000_000}}
        job = post(base, "/v1/jobs", endless, wait=0)["links"]["self"]
        states.append(post(base, f"{job}/cancel", {})["state"])
        check(states == ["converged", "failed", "cancelled"], f"jobs ended otherwise: {states}")
        # Requests are counted after the first one.
        return [fetch(f"{base}{path}") for path in ("/readyz", "/metrics", "/metrics")][-1].decode()


def series(text: str) -> dict[str, list[dict[str, str]]]:
    """The labels of all series, by the names of their metrics."""
    found: dict[str, list[dict[str, str]]] = {}
    for name, labels in re.findall(r"^(\w+)(?:\{(.*)\})? \S+$", text, re.MULTILINE):
        found.setdefault(name, []).append(dict(re.findall(r'(\w+)="([^"]*)"', labels)))
    return found


def metrics(program: str, queries: list[str]) -> None:
    database = os.environ.get("PIAD_TEST_DATABASE")
    check(database, "metrics of a server with a database: start this with tests/postgres")
    there = series("\n".join(shown(program, store) for store in (":memory:", database)))
    # Prometheus' own.
    there["up"] = [{"job": "piad"}]
    for query in [*queries, *(alert["expr"] for alert in alerts())]:
        names = re.findall(r"\bpiad_\w+|\bup\b", query)
        check(names, f"no metric in {query}")
        for name in names:
            check(name in there, f"servers have no {name}: {query}")
        for name, matchers in re.findall(r"(\w+)\{([^}]*(?:\{[^}]*\}[^}]*)*)\}", query):
            for label_name, comparison, value in re.findall(r'(\w+)\s*(=~|!=|!~|=)\s*"([^"]*)"', matchers):
                values = {labels[label_name] for labels in there[name] if label_name in labels}
                # Prometheus adds the name of the server. A status that has not occurred is a
                # number.
                if label_name in ("instance", "status"):
                    continue
                check(values, f"{name} has no label {label_name}: {query}")
                if comparison == "=":
                    check(value in values, f"{name} has no {label_name} {value}: {query}")
    print(f"{len(there)} metrics, {len(queries)} queries, {len(alerts())} alerts")


def main() -> None:
    content = compose()
    caddyfiles()
    kubernetes(DEPLOY / "kubernetes")
    prometheus(content)
    metrics(sys.argv[1], dashboard(content))
    print("deploy/ is as it should be")


if __name__ == "__main__":
    main()
