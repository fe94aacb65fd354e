#!/usr/bin/env python3
"""A client of piad from the proto file alone, as in a plug-in: fits, watches, resumes, edits,
cancels.

    make interop

or, with the packages of requirements.txt:

    cargo build && python3 tests/python/grpc_client.py [target/debug/piad]

Starts a server on a free port, and compares each iteration with the stream of server-sent events,
bit for bit.
"""

import contextlib
import json
import math
import pathlib
import re
import subprocess
import sys
import time
import urllib.request

import grpc
from google.rpc import error_details_pb2
from grpc_health.v1 import health_pb2, health_pb2_grpc
from grpc_reflection.v1alpha.proto_reflection_descriptor_database import ProtoReflectionDescriptorDatabase
from grpc_status import rpc_status
from messages import generate

ROOT = pathlib.Path(__file__).resolve().parents[2]


pb, pb_grpc = generate()


@contextlib.contextmanager
def server(program):
    """A server on a free port; shut down like an operator."""
    command = [program, "--listen", "127.0.0.1:0", "--store", ":memory:", "--max-iterations", "1000000000"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        for line in process.stderr:
            if address := re.search(r"listening on http://(\S+)", line):
                break
        yield address[1]
    finally:
        process.terminate()
        process.stderr.read()
        assert process.wait(timeout=10) == 0


def sse(address, job, after=None):
    """The iterations of a job as server-sent events."""
    request = urllib.request.Request(f"http://{address}/v1/jobs/{job}/events")
    if after is not None:
        request.add_header("Last-Event-ID", str(after))
    iterations = []
    with urllib.request.urlopen(request) as response:
        for line in response:
            if line.startswith(b"data: "):
                data = json.loads(line[6:])
                if "iteration" in data:
                    iterations.append(data)
    return iterations


def flat(value):
    return [x for item in value for x in flat(item)] if isinstance(value, list) else [value]


def assert_same(message, event):
    """Both have the same numbers, to the last bit."""
    assert message.iteration == event["iteration"]
    assert message.moved == event["moved"]
    assert message.error.max == event["error"]["max"]
    assert message.error.rms == event["error"]["rms"]
    assert list(message.control_net.points) == flat(event["control_points"])
    assert list(message.control_net.weights) == flat(event.get("weights", []))


def helix(count=200):
    angles = [6 * math.pi * i / (count - 1) for i in range(count)]
    return [x for a in angles for x in (math.cos(a), math.sin(a), a / 2)]


def read(events):
    """The job, its iterations and its end."""
    events = list(events)
    kinds = [event.WhichOneof("event") for event in events]
    assert kinds == ["job", *["iteration"] * (len(kinds) - 2), "end"], kinds
    return events[0].job, [event.iteration for event in events[1:-1]], events[-1].end


def fits_and_watches(stub, address):
    curve = pb.Curve(dimension=3, points=helix(), weights=[1 + (i % 3) for i in range(200)])
    request = pb.FitRequest(input=pb.JobInput(name="helix", curve=curve, stop=pb.StopRules(tolerance=1e-8)))
    job, iterations, end = read(stub.Fit(request))
    assert end.state == pb.JOB_STATE_CONVERGED and end.error.max <= 1e-8
    assert [iteration.iteration for iteration in iterations] == list(range(len(iterations)))
    events = sse(address, job.id)
    assert len(events) == len(iterations)
    for message, event in zip(iterations, events):
        assert_same(message, event)

    _, again, _ = read(stub.WatchJob(pb.WatchJobRequest(id=job.id)))
    assert again == iterations
    _, rest, _ = read(stub.WatchJob(pb.WatchJobRequest(id=job.id, resume_after=7)))
    assert rest == iterations[8:]
    for message, event in zip(rest, sse(address, job.id, after=7), strict=True):
        assert_same(message, event)

    result = stub.GetResult(pb.GetResultRequest(id=job.id)).result
    assert result.control_net == iterations[-1].control_net
    assert len(result.u.knots) == result.u.control_points + result.u.degree + 1
    third = stub.GetIteration(pb.GetIterationRequest(id=job.id, iteration=3)).iteration
    assert third == iterations[3]
    given = stub.GetInput(pb.GetInputRequest(id=job.id)).input
    assert given.curve.points == curve.points and given.name == "helix"
    return job.id


def edits(stub, parent):
    edit = pb.Edit(moved=[100], points=[5.0, 5.0, 5.0], method=pb.Method(local=pb.Method.Local(indices=[99, 100, 101])))
    job = stub.EditJob(pb.EditJobRequest(id=parent, edit=edit)).job
    assert job.parent.id == parent and job.computed.adjusted == 3
    options = pb.StreamOptions(changed=True)
    _, iterations, _ = read(stub.WatchJob(pb.WatchJobRequest(id=job.id, stream=options)))
    net = list(iterations[0].control_net.points)
    for iteration in iterations[1:]:
        changes = iteration.changes
        for k, place in enumerate(changes.indices):
            net[3 * place : 3 * place + 3] = changes.points[3 * k : 3 * k + 3]
    assert net == list(stub.GetResult(pb.GetResultRequest(id=job.id)).result.control_net.points)


def fits_a_surface(stub, address):
    points = [x for i in range(9) for j in range(7) for x in (i, j, math.sin(i) * math.cos(j))]
    direction = pb.SurfaceDirection(basis=pb.Basis(kind=pb.BASIS_KIND_BSPLINE, degree=2))
    surface = pb.Surface(dimension=3, rows=9, columns=7, points=points, u=direction)
    job, iterations, _ = read(stub.Fit(pb.FitRequest(input=pb.JobInput(surface=surface))))
    assert (job.u.degree, job.v.degree) == (2, 3)
    net = iterations[0].control_net
    assert (net.rows, net.columns) == (job.u.control_points, job.v.control_points)
    for message, event in zip(iterations, sse(address, job.id), strict=True):
        assert_same(message, event)


def fits_a_batch(stub):
    """Many curves, with results while they are sent; errors name their fields."""
    stop = pb.StopRules(tolerance=1e-8)

    def requests():
        yield pb.FitBatchRequest(options=pb.BatchOptions(defaults=pb.JobInput(stop=stop)))
        for count in range(200, 700):
            curve = pb.Curve(dimension=3, points=helix(count))
            yield pb.FitBatchRequest(item=pb.JobInput(name=str(count), curve=curve))
        yield pb.FitBatchRequest(item=pb.JobInput(curve=pb.Curve(dimension=2, points=[0, 0, 1, 1, 1, 1])))

    *responses, last = stub.FitBatch(requests())
    items = [response.item for response in responses]
    assert [item.index for item in items] == list(range(501))
    assert [item.name for item in items[:500]] == [str(count) for count in range(200, 700)]
    assert (last.totals.items, last.totals.converged, last.totals.failed) == (501, 500, 1), last
    assert items[500].problem.errors[0].field == "item.curve.points[4]", items[500]
    curve = pb.Curve(dimension=3, points=helix())
    job, *_ = read(stub.Fit(pb.FitRequest(input=pb.JobInput(curve=curve, stop=stop))))
    kept = stub.GetResult(pb.GetResultRequest(id=job.id)).result
    assert list(items[0].result.control_net.points) == list(kept.control_net.points)
    assert items[0].result.error == kept.error


def cancels(stub):
    endless = pb.JobInput(
        curve=pb.Curve(dimension=3, points=helix()),
        stop=pb.StopRules(tolerance=0, max_iterations=1_000_000_000),
    )
    job = stub.CreateJob(pb.CreateJobRequest(input=endless)).job
    events = stub.WatchJob(pb.WatchJobRequest(id=job.id))
    for _, event in zip(range(50), events):
        pass
    assert event.iteration.iteration == 48
    cancelled = stub.CancelJob(pb.CancelJobRequest(id=job.id)).job
    assert cancelled.state == pb.JOB_STATE_CANCELLED
    *_, last = events
    assert last.end.state == pb.JOB_STATE_CANCELLED
    stub.DeleteJob(pb.DeleteJobRequest(id=job.id))

    # A call that its client cancels ends the job, if requested.
    options = pb.StreamOptions(on_disconnect=pb.ON_DISCONNECT_CANCEL)
    call = stub.Fit(pb.FitRequest(input=endless, stream=options))
    job = next(call).job
    call.cancel()
    deadline = time.monotonic() + 10
    while stub.GetJob(pb.GetJobRequest(id=job.id)).job.state != pb.JOB_STATE_CANCELLED:
        assert time.monotonic() < deadline
        time.sleep(0.02)


def is_told_what_is_wrong(stub):
    points = [0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 0.0]
    try:
        stub.CreateJob(pb.CreateJobRequest(input=pb.JobInput(curve=pb.Curve(dimension=2, points=points))))
        raise AssertionError("two points are equal")
    except grpc.RpcError as error:
        assert error.code() == grpc.StatusCode.INVALID_ARGUMENT
        bad, info = error_details_pb2.BadRequest(), error_details_pb2.ErrorInfo()
        for detail in rpc_status.from_call(error).details:
            detail.Unpack(bad)
            detail.Unpack(info)
        assert bad.field_violations[0].field == "input.curve.points[4]", bad
        assert (info.domain, info.reason) == ("piad", "INVALID_FIT")


def is_a_good_citizen(channel):
    names = ProtoReflectionDescriptorDatabase(channel).get_services()
    assert "piad.v1.FittingService" in names, names
    health = health_pb2_grpc.HealthStub(channel)
    for service in ["", "piad.v1.FittingService"]:
        answer = health.Check(health_pb2.HealthCheckRequest(service=service))
        assert answer.status == health_pb2.HealthCheckResponse.SERVING
    code = grpc.StatusCode
    assert failure(lambda: health.Check(health_pb2.HealthCheckRequest(service="unknown"))) == code.NOT_FOUND

    def call(path, message=b""):
        return failure(lambda: channel.unary_unary(path)(message))

    for service in ["grpc.health.v1.Health", "grpc.reflection.v1.ServerReflection", "piad.v1.FittingService"]:
        assert call(f"/{service}/Nothing") == code.UNIMPLEMENTED, service
    for method in ["grpc.health.v1.Health/Check", "piad.v1.FittingService/GetJob", "piad.v1.FittingService/Fit"]:
        assert call(f"/{method}", b"\xff\xff") == code.INVALID_ARGUMENT, method


def failure(call):
    """The code with which a call fails."""
    try:
        call()
    except grpc.RpcError as error:
        return error.code()
    raise AssertionError("it does not fail")


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target/debug/piad")
    with server(program) as address, grpc.insecure_channel(address) as channel:
        stub = pb_grpc.FittingServiceStub(channel)
        job = fits_and_watches(stub, address)
        edits(stub, job)
        fits_a_surface(stub, address)
        fits_a_batch(stub)
        cancels(stub)
        is_told_what_is_wrong(stub)
        is_a_good_citizen(channel)
        jobs = stub.ListJobs(pb.ListJobsRequest(page_size=2))
        assert len(jobs.jobs) == 2 and jobs.next_page_token
    print("fits, fits batches, watches, resumes, edits, cancels: all the same as over REST")


if __name__ == "__main__":
    main()
