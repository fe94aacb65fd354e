"""Checks that the OpenAPI document is valid, and that responses of a real server and the examples
conform to it.

    description.py PROGRAM            # the server to start, such as target/debug/piad

Needs the packages of requirements.txt.
"""

import json
import math
import sys
import urllib.error
import urllib.request

import jsonschema_rs
from openapi_spec_validator import OpenAPIV31SpecValidator
from over_http import server

POINTS = [[0, 0], [1, 2], [3, 1], [4, 4], [5, 0], [6, 2]]
WEIGHTS = [1, 2, 3, 1, 1, 1]
LOCAL_GRID = {"kind": "local", "indices": [[1, 1], [2, 3]], "sweeps": "rows"}
LSPIA = {"kind": "least_squares", "control_points": {"u": 4, "v": 5}, "variant": "lspia", "mu": 0.1}

STREAMS = [
    "",
    "?view=samples",
    "?view=errors",
    "?every=1&changed=true",
    "?encoding=base64&every=1",
    "?encoding=base64_f32&every=1",
    "?view=samples&encoding=base64_f32",
    "?every=1&milestones=1,0.1,0.01",
]

LEVELS = ["", "?view=samples", "?view=errors", "?encoding=base64", "?encoding=base64_f32", "?view=samples&encoding=base64"]


def curve(**fields) -> dict:
    return {"points": POINTS, **fields}


def peaks(n: int) -> list:
    steps = [-3 + 6 * i / (n - 1) for i in range(n)]

    def z(x: float, y: float) -> float:
        return (
            3 * (1 - x) ** 2 * math.exp(-(x**2) - (y + 1) ** 2)
            - 10 * (x / 5 - x**3 - y**5) * math.exp(-(x**2) - y**2)
            - math.exp(-((x + 1) ** 2) - y**2) / 3
        )

    return [[[x, y, z(x, y)] for x in steps] for y in steps]


def jobs() -> list[dict]:
    """Jobs that cover all variants of responses."""
    grid = peaks(5)
    bernstein, spline = {"kind": "bernstein"}, {"kind": "bspline", "degree": 2}
    # Control points grow until they leave the range of numbers.
    overflowing = {"points": [[2e306 * (-1) ** i] for i in range(20)], "basis": bernstein, "parameters": "uniform"}
    return [
        {"name": "plain", "curve": curve()},
        # JSON has one type of numbers: 3.0 is an integer.
        {"curve": curve(basis={"kind": "bspline", "degree": 3.0}), "stop": {"max_iterations": 20.0}, "stream": {"every": 2.0}},
        {"curve": curve(closed=True, parameters="centripetal"), "method": {"kind": "weighted"}},
        {"curve": curve(basis={"kind": "said_ball"}), "method": {"kind": "extended"}},
        {"curve": curve(basis=bernstein), "stop": {"max_iterations": 3}},
        {"curve": curve(), "method": {"kind": "local", "indices": [1, 2]}},
        {"curve": curve(), "method": {"kind": "adaptive", "threshold": 0.01}},
        {"curve": curve(weights=WEIGHTS), "stream": {"every": 2}},
        {"curve": curve(weights=WEIGHTS), "rational": "fixed"},
        {"curve": curve(), "method": {"kind": "least_squares", "control_points": 4}},
        {"surface": {"points": grid, "basis": {"u": bernstein, "v": spline}}},
        {"surface": {"points": grid}, "method": LOCAL_GRID},
        {"surface": {"points": grid, "weights": {"u": [1, 2, 1, 1, 1], "v": [1, 1, 2, 1, 1]}}, "rational": "fixed"},
        {"surface": {"points": grid}, "method": LSPIA, "stop": {"max_iterations": 5}},
        {"curve": overflowing, "stop": {"tolerance": 1, "max_iterations": 100_000}},
    ]


class Server:
    """Sends requests and returns status and text of the responses."""

    def __init__(self, base: str):
        self.base = base

    def ask(self, path: str, body: object = None, accept: str = "application/json") -> tuple[int, str]:
        content = None if body is None else json.dumps(body).encode()
        headers = {"Content-Type": "application/json", "Accept": accept, "Prefer": "wait=60"}
        try:
            with urllib.request.urlopen(urllib.request.Request(self.base + path, content, headers)) as answer:
                return answer.status, answer.read().decode()
        except urllib.error.HTTPError as refusal:
            return refusal.code, refusal.read().decode()

    def json(self, path: str, body: object = None):
        status, text = self.ask(path, body)
        assert status < 300, f"{path}: {status} {text}"
        return json.loads(text)


def close(schema: object) -> None:
    """Forbids undocumented fields: clients ignore them, but here all must be documented."""
    if isinstance(schema, dict):
        for part in schema.values():
            close(part)
        fields = schema.get("properties")
        # Not a field of this name.
        is_open = fields is not None and not isinstance(fields.get("type"), str)
        if is_open and schema.get("type") == "object":
            schema.setdefault("additionalProperties", False)
    elif isinstance(schema, list):
        for part in schema:
            close(part)


class Description:
    """The OpenAPI document of the server."""

    def __init__(self, server: Server):
        self.document = server.json("/openapi.json")
        self.schemas = self.document["components"]["schemas"]
        self.closed = json.loads(json.dumps(self.schemas))
        close(self.closed)
        self.validators: dict[str, jsonschema_rs.Draft202012Validator] = {}
        self.checked = 0

    def check(self, name: str, value: object, what: str = "") -> None:
        if name not in self.validators:
            schema = {"$ref": f"#/components/schemas/{name}", "components": {"schemas": self.closed}}
            self.validators[name] = jsonschema_rs.Draft202012Validator(schema, validate_formats=True)
        wrong = [f"{error.instance_path}: {error.message}" for error in self.validators[name].iter_errors(value)]
        assert not wrong, f"{name} {what}: {wrong}\n{json.dumps(value, indent=1)[:4000]}"
        self.checked += 1


def examples(description: Description) -> None:
    for name, schema in description.schemas.items():
        assert schema["examples"], name
        for example in schema["examples"]:
            description.check(name, example, "example")
    for example in description.document["components"]["examples"].values():
        description.check("Problem", example["value"])
    paths = description.document["paths"]
    for path, name in [("/v1/jobs", "JobRequest"), ("/v1/batch", "BatchRequest"), ("/v1/jobs/{id}/edits", "EditRequest")]:
        shown = paths[path]["post"]["requestBody"]["content"]["application/json"]["examples"]
        for title, example in shown.items():
            description.check(name, example["value"], title)


def specification(description: Description) -> None:
    """Checks an OpenAPI 3.1 document with an independent validator."""
    assert description.document["openapi"].startswith("3.1.")
    errors = OpenAPIV31SpecValidator(description.document).iter_errors()
    wrong = [f"/{'/'.join(map(str, error.absolute_path))}: {error.message[:300]}" for error in errors]
    assert not wrong, wrong


def geometry(server: Server, description: Description) -> None:
    for body in jobs():
        description.check("JobRequest", body)
        job = server.json("/v1/jobs", body)
        description.check("Job", job)
        links = job["links"]
        description.check("Job", server.json(links["self"]))
        description.check("JobRequest", server.json(links["input"]))
        if job["state"] == "failed":
            continue
        for query in LEVELS:
            description.check("IterationEvent", server.json(f"{links['self']}/iterations/last{query}"), query)
            result = server.json(links["result"] + query)
            # Other views of a result are those of its iteration.
            description.check("IterationEvent" if "view" in query else "FitResult", result, query)
        if job["method"]["kind"] == "local":
            description.check("Limit", server.json(links["limit"]))
    description.check("JobPage", server.json("/v1/jobs?limit=3"))


def events(server: Server, description: Description) -> None:
    """As lines, which name their events."""
    seen = 0
    for body in jobs():
        links = server.json("/v1/jobs", body)["links"]
        for query in STREAMS:
            status, text = server.ask(links["events"] + query, accept="application/x-ndjson")
            if status == 400:
                description.check("Problem", json.loads(text), query)
                continue
            assert status == 200, (query, status, text)
            for line in text.splitlines():
                description.check("EventLine", json.loads(line), query)
                seen += 1
    assert seen > 200, seen


def server_sent_events(server: Server, description: Description) -> None:
    schemas = {"job": "JobEvent", "iteration": "IterationEvent", "end": "EndEvent"}
    _, text = server.ask("/v1/jobs", jobs()[0], accept="text/event-stream")
    seen = set()
    for block in text.split("\n\n"):
        fields = dict(line.split(": ", 1) for line in block.splitlines() if not line.startswith(":"))
        if "event" in fields:
            description.check("ServerSentEvent", fields)
            description.check(schemas[fields["event"]], json.loads(fields["data"]))
            seen.add(fields["event"])
    assert seen == schemas.keys(), seen


def batches(server: Server, description: Description) -> None:
    """Each line; those of items with geometry, with a problem, and the last ones."""
    batch = {"defaults": {"stop": {"max_iterations": 50}}, "items": [*jobs(), {"curve": {"points": [[0, 0]]}}]}
    description.check("BatchRequest", {**batch, "items": jobs()})
    names = {"index": "BatchItem", "totals": "BatchEnd", "problem": "BatchProblem"}
    seen = set()
    for query, body in [("", batch), ("?encoding=base64", batch), ("", {"items": [jobs()[0], "x"]}), ("", {"items": []})]:
        status, text = server.ask("/v1/batch" + query, body, accept="application/x-ndjson")
        assert status == 200, text
        for line in map(json.loads, text.splitlines()):
            description.check("BatchLine", line, query)
            description.check(names[next(iter(line))], line, query)
            seen.add(names[next(iter(line))])
    assert seen == {"BatchItem", "BatchEnd"}, seen


def edits(server: Server, description: Description) -> None:
    parent = server.json("/v1/jobs", jobs()[0])
    edit = {"points": [{"index": 2, "point": [3, 2]}], "iteration": 1}
    description.check("EditRequest", edit)
    job = server.json(parent["links"]["edits"], edit)
    assert job["parent"]["iteration"] == 1, job
    description.check("Job", job)


def server_itself(server: Server, description: Description) -> None:
    for path, schema in [
        ("/", "Service"),
        ("/livez", "Health"),
        ("/readyz", "Health"),
        ("/problems", "ProblemTypes"),
        ("/problems/invalid-fit", "ProblemType"),
        ("/v1/capabilities", "Capabilities"),
    ]:
        description.check(schema, server.json(path), path)
    refused = ["/nothing", "/v1/jobs/1", "/v1/jobs?limit=0", "/problems/none"]
    for path, body in [*((path, None) for path in refused), ("/v1/jobs", {"curve": 1})]:
        status, text = server.ask(path, body)
        assert status >= 400, path
        description.check("Problem", json.loads(text), path)


def main() -> None:
    with server(sys.argv[1]) as base:
        asked = Server(base)
        description = Description(asked)
        specification(description)
        examples(description)
        for check in (geometry, events, server_sent_events, batches, edits, server_itself):
            check(asked, description)
        print(f"{description.checked} examples and answers are what the description says")


if __name__ == "__main__":
    main()
