"""Makes more requests of schemathesis valid.

Requests whose fields are valid but inconsistent are rejected, as they should be, but test little.
So most requests name an existing job, stream parameters come alone and with an Accept header for
streams, and points can be fitted. Requests that violate the OpenAPI document are unchanged.
"""

import itertools
import os
import re

import schemathesis
from schemathesis.core.parameters import ParameterLocation as Place
from schemathesis.generation.meta import TestPhase

JOB = os.environ["PIAD_JOB"]
UNKNOWN = "00000000-0000-7000-8000-000000000000"
KEY = "Idempotency-Key"
RIGHT_KEY = re.compile("[ -~]{1,255}")
NUMBERS = itertools.count()
STREAMS = ["text/event-stream", "application/x-ndjson"]


@schemathesis.hook
def before_load_schema(context, raw_schema):
    """A stream is described as text; here each of its events is checked."""
    for resource in raw_schema["paths"].values():
        for operation in resource.values():
            for answer in operation["responses"].values():
                for content in answer.get("content", {}).values():
                    if "x-itemSchema" in content:
                        content["schema"] = content.pop("x-itemSchema")


@schemathesis.hook
def before_call(context, case, kwargs):
    if case.meta is None:
        return
    ends_jobs = case.method == "DELETE" or case.path.endswith("/cancel")
    if case.path_parameters and "id" in case.path_parameters:
        if ends_jobs and case.path_parameters["id"] == JOB:
            case.path_parameters["id"] = UNKNOWN
        elif not ends_jobs and case.meta.phase.name != TestPhase.STATEFUL and is_right(case, Place.PATH):
            case.path_parameters["id"] = JOB
    if case.headers and KEY in case.headers and is_right(case, Place.HEADER):
        # A key belongs to one request.
        case.headers[KEY] = f"{case.headers[KEY][:200]}-{next(NUMBERS)}"
    elif case.headers and KEY in case.headers and RIGHT_KEY.fullmatch(str(case.headers[KEY]).strip(" \t")):
        # Whitespace around the value of a header is not part of it (RFC 9110, 5.5): a key that is
        # invalid only because of it would be valid.
        case.headers[KEY] = ""
    if case.query:
        choose(case)
    if isinstance(case.body, dict) and is_right(case, Place.BODY):
        for job in case.body.get("items") or [case.body]:
            make_computable(job)


def is_right(case, place) -> bool:
    """True if this part of a request conforms to the OpenAPI document."""
    part = case.meta.components.get(place)
    return part is None or part.mode.is_positive


def choose(case) -> None:
    """Keeps one parameter of a query, and requests the stream of a new job."""
    size = len(str(case.query))
    if is_right(case, Place.QUERY):
        keep = sorted(case.query)[size % len(case.query)]
        case.query = {keep: case.query[keep]}
    if case.method == "POST":
        case.headers = {**(case.headers or {}), "Accept": STREAMS[size % 2]}


def make_computable(job: dict) -> None:
    curve, surface = job.get("curve"), job.get("surface")
    if isinstance(curve, dict):
        align(curve.get("points"))
    if isinstance(surface, dict):
        # Rows of numbers are heights, which are valid.
        align([point for row in surface.get("points") or [] for point in row if isinstance(point, list)])
    for shape in (curve, surface):
        if isinstance(shape, dict) and shape.get("weights") is None:
            job.pop("rational", None)


def align(points) -> None:
    """All points have the same number of coordinates, and no two are equal."""
    if not points:
        return
    dimension = min(map(len, points))
    for index, point in enumerate(points):
        del point[dimension:]
        point[0] = index + point[0] % 1000 / 1000
