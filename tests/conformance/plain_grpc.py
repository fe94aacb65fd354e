"""Plain protoc-generated code in the scenarios of README.md."""

import json
import pathlib
import sys
import time
from typing import Any

import grpc
from google.rpc import error_details_pb2
from grpc_status import rpc_status

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python"))
from messages import generate  # noqa: E402
from packed import moved  # noqa: E402

Json = dict[str, Any]


pb, pb_grpc = generate()
_, SCENARIO, URL, TOKEN = sys.argv
# The number of retries of a call that has not arrived.
ATTEMPTS = 100
channel = grpc.insecure_channel(URL.removeprefix("http://"), [("grpc.max_receive_message_length", -1)])
stub = pb_grpc.FittingServiceStub(channel)
metadata = [("authorization", f"Bearer {TOKEN}")]


def flat(value: Any) -> list[float]:
    return [number for part in value for number in flat(part)] if isinstance(value, list) else [value]


def message(request: Json):
    stop = pb.StopRules(**request.get("stop", {}))
    if "curve" in request:
        points = request["curve"]["points"]
        return pb.JobInput(curve=pb.Curve(dimension=len(points[0]), points=flat(points)), stop=stop)
    rows = request["surface"]["points"]
    surface = pb.Surface(dimension=len(rows[0][0]), rows=len(rows), columns=len(rows[0]), points=flat(rows))
    return pb.JobInput(surface=surface, stop=stop)


def create(request: Json) -> str:
    answer = stub.CreateJob(pb.CreateJobRequest(input=message(request)), metadata=metadata)
    return answer.job.id


def name_of(state: int) -> str:
    return pb.JobState.Name(state).removeprefix("JOB_STATE_").lower()


def result(job: str) -> Json:
    *_, last = stub.WatchJob(pb.WatchJobRequest(id=job), metadata=metadata)
    fitted = stub.GetResult(pb.GetResultRequest(id=job), metadata=metadata).result
    return {
        "state": name_of(last.end.state),
        "iteration": fitted.iteration,
        "error": fitted.error.max,
        "control_points": list(fitted.control_net.points),
        "knots": list(fitted.u.knots),
    }


def events(job: str):
    """The events of a job; the call is resumed after the last iteration if it breaks."""
    after, left = None, ATTEMPTS
    while True:
        try:
            for event in stub.WatchJob(pb.WatchJobRequest(id=job, resume_after=after), metadata=metadata):
                if event.WhichOneof("event") == "iteration":
                    after, left = event.iteration.iteration, ATTEMPTS
                yield event
            return
        except grpc.RpcError as error:
            left -= 1
            if left == 0 or error.code() != grpc.StatusCode.UNAVAILABLE:
                raise
            time.sleep(0.2)


def levels(request: Json, pause: float = 0.0, ready: bool = False) -> Json:
    numbers, points, state = [], [], ""
    for event in events(create(request)):
        if event.WhichOneof("event") == "end":
            state = name_of(event.end.state)
        if event.WhichOneof("event") != "iteration":
            continue
        numbers.append(event.iteration.iteration)
        points = [*points[:1], list(event.iteration.control_net.points)]
        if ready and numbers[-1] == 5:
            print("ready", flush=True)
        time.sleep(pause)
    return {"numbers": numbers, "first": points[0], "last": points[-1], "state": state}


def differences(request: Json) -> Json:
    numbers, points, state = [], [], ""
    watching = pb.WatchJobRequest(id=create(request), stream=pb.StreamOptions(json_encoding=pb.JSON_ENCODING_DELTA))
    for event in stub.WatchJob(watching, metadata=metadata):
        if event.WhichOneof("event") == "end":
            state = name_of(event.end.state)
        if event.WhichOneof("event") != "iteration":
            continue
        numbers.append(event.iteration.iteration)
        if event.iteration.WhichOneof("geometry") == "deltas":
            change = event.iteration.deltas
            points.append(moved(points[-1], change.step, change.points, change.dimension))
        else:
            points.append(list(event.iteration.control_net.points))
    return {"numbers": numbers, "points": points, "state": state}


def refused(call: Any) -> Json:
    """The problem of a rejected call, as in HTTP."""
    try:
        call()
    except grpc.RpcError as error:
        bad, info = error_details_pb2.BadRequest(), error_details_pb2.ErrorInfo()
        for detail in rpc_status.from_call(error).details:
            detail.Unpack(bad)
            detail.Unpack(info)
        kind = f"/problems/{info.reason.lower().replace('_', '-')}"
        return {"type": kind, "fields": [violation.field for violation in bad.field_violations], "detail": error.details()}
    raise SystemExit("it was not refused")


def cancel(request: Json) -> Json:
    job = create(request)
    watching = events(job)
    while next(watching).WhichOneof("event") != "iteration":
        pass
    ask = pb.CancelJobRequest(id=job)
    state, again = (name_of(stub.CancelJob(ask, metadata=metadata).job.state) for _ in range(2))
    return {"state": state, "again": again}


def edit(request: Json) -> Json:
    job = create(request["job"])
    result(job)
    moves = request["edit"]["points"]
    change = pb.Edit(moved=[move["index"] for move in moves], points=flat([move["point"] for move in moves]))
    edited = stub.EditJob(pb.EditJobRequest(id=job, edit=change), metadata=metadata).job
    return {**result(edited.id), "parent": job, "is_parent": edited.parent.id == job}


def tokens(request: Json) -> Json:
    without = refused(lambda: stub.CreateJob(pb.CreateJobRequest(input=message(request))))["type"]
    return {"without": without, "with": result(create(request))["state"]}


def large(request: Json) -> Json:
    summary = levels(request)
    return {"numbers": summary["numbers"], "count": len(summary["last"]), "sum": sum(summary["last"])}


SCENARIOS = {
    "fit": lambda request: result(create(request)),
    "watch": levels,
    "resume": lambda request: levels(request, ready=True),
    "cancel": cancel,
    "edit": edit,
    "errors": lambda request: refused(lambda: create(request)),
    "tokens": tokens,
    "large": large,
    "differences": differences,
    "slow": lambda request: levels(request, pause=0.02),
}

if __name__ == "__main__":
    print(json.dumps(SCENARIOS[SCENARIO](json.load(sys.stdin))))
