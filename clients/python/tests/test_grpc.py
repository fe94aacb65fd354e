"""The code that protoc generates from the contract is `piad.v1`: it works beside this package."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT, Server

PROGRAM = """
import sys
import grpc
import piad
from piad.v1 import fitting_pb2 as pb, fitting_pb2_grpc

url = sys.argv[1]
stub = fitting_pb2_grpc.FittingServiceStub(grpc.insecure_channel(url.removeprefix("http://")))
curve = pb.Curve(dimension=2, points=[0, 0, 1, 2, 3, 1, 4, 3])
events = list(stub.Fit(pb.FitRequest(input=pb.JobInput(curve=curve))))
with piad.Client(url) as client:
    result = client.job(events[0].job.id).result()
assert result.state == "converged"
net = list(events[-2].iteration.control_net.points)
assert net == [x for point in result.curve.control_points for x in point]
"""


@pytest.mark.parametrize("imported_first", ["piad", "piad.v1.fitting_pb2"])
def test_generated_code_and_the_client(server: Server, tmp_path: Path, imported_first: str) -> None:
    generate = ["-m", "grpc_tools.protoc", f"-I{ROOT / 'proto'}", "--python_out=.", "--grpc_python_out=."]
    subprocess.run([sys.executable, *generate, "piad/v1/fitting.proto"], cwd=tmp_path, check=True)
    program = tmp_path / "fit.py"
    program.write_text(f"import {imported_first}\n{PROGRAM}")
    done = subprocess.run([sys.executable, str(program), server.url], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
