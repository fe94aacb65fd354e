"""A client of piad: curve and surface fitting in which every iteration is streamed.

    import piad

    with piad.Client("http://127.0.0.1:8080") as client:
        curve = client.fit([[0, 0], [1, 2], [3, 1], [4, 3]]).curve
        curve.evaluate(0.5), curve.degree, curve.knots, curve.control_points

- `client`: `Client`, the entry point; `job`: `Job`, its iterations and its result; `async_client`,
  `async_job`: the same for asyncio; `status`: the state of a job;
- `iteration`: `Iteration`, `Result` and their parts; `geometry`: `Curve` and `Surface`, and conversions to other
  packages; `points`: files of points; `plotting`: plots;
- `curvature`: `CurveShape` and `SurfaceShape`, what `Job.curvature` returns;
- `batch`: many fits in one request;
- `errors`: the exceptions.
"""

from importlib import metadata as _metadata
from pkgutil import extend_path as _extend_path

from .async_client import AsyncClient
from .async_job import AsyncJob
from .batch import AsyncBatch, Batch, BatchItem, BatchTotals
from .client import Client
from .curvature import CurvatureExtreme, CurvatureExtremes, CurveShape, KnotContinuity, KnotLine, SurfaceShape
from .errors import (
    ApiError,
    ConnectionLost,
    FieldError,
    JobFailed,
    MissingPackage,
    NotConverged,
    PiadError,
    Problem,
    ProtocolError,
    WaitTimeout,
)
from .geometry import Basis, Boundary, Curve, Surface
from .iteration import BadWeight, Deviation, Distances, Iteration, Result, Samples, Shape, Trim, boundary
from .job import Job
from .plotting import plot
from .points import FilePoints
from .status import JobWarning, Status

# gRPC code generated from the proto files is `piad.v1`, wherever it is installed.
__path__ = _extend_path(__path__, __name__)

try:
    __version__ = _metadata.version(__name__)
except _metadata.PackageNotFoundError:
    # The package is on the path but not installed.
    __version__ = "unknown"

__all__ = [
    "ApiError",
    "AsyncBatch",
    "AsyncClient",
    "AsyncJob",
    "BadWeight",
    "Basis",
    "Batch",
    "BatchItem",
    "BatchTotals",
    "Boundary",
    "Client",
    "ConnectionLost",
    "CurvatureExtreme",
    "CurvatureExtremes",
    "Curve",
    "CurveShape",
    "Deviation",
    "Distances",
    "FieldError",
    "FilePoints",
    "Iteration",
    "Job",
    "JobFailed",
    "JobWarning",
    "KnotContinuity",
    "KnotLine",
    "MissingPackage",
    "NotConverged",
    "PiadError",
    "Problem",
    "ProtocolError",
    "Result",
    "Samples",
    "Shape",
    "Status",
    "Surface",
    "SurfaceShape",
    "Trim",
    "WaitTimeout",
    "__version__",
    "boundary",
    "plot",
]
