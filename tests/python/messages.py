"""The messages and calls of the contract, as protoc makes them."""

import pathlib
import sys
import tempfile

from grpc_tools import protoc

ROOT = pathlib.Path(__file__).resolve().parents[2]


def generate():
    """Python from the contract, and nothing else of piad."""
    out = tempfile.mkdtemp()
    arguments = ["protoc", f"-I{ROOT / 'proto'}", f"--python_out={out}", f"--grpc_python_out={out}"]
    include = pathlib.Path(protoc.__file__).parent / "_proto"
    assert protoc.main([*arguments, f"-I{include}", "piad/v1/fitting.proto"]) == 0
    sys.path.insert(0, out)
    # A package of its own: the Python client, which may be installed, is also called piad.
    for package in ("piad", "piad/v1"):
        (pathlib.Path(out) / package / "__init__.py").touch()
    from piad.v1 import fitting_pb2, fitting_pb2_grpc

    return fitting_pb2, fitting_pb2_grpc
