"""Curve and surface fitting in which every iteration is streamed.

    import piad

    curve = piad.fit([[0, 0], [1, 2], [3, 1], [4, 3]], tolerance=1e-6).curve
    curve.evaluate(0.5), curve.degree, curve.knots, curve.control_points

- `fitting`: `fit`, `fit_file` and `read`, at a server of this process or at another one;
- `client`: `Client`, for iterations and jobs; `job`: `Job`, its iterations and its result; `async_client`,
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
    ServerNotStarted,
    WaitTimeout,
)
from .fitting import fit, fit_file, read
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
    "ServerNotStarted",
    "Shape",
    "Status",
    "Surface",
    "SurfaceShape",
    "Trim",
    "WaitTimeout",
    "__version__",
    "boundary",
    "fit",
    "fit_file",
    "plot",
    "read",
]


def __dir__() -> list[str]:
    """The names that programs use, for completions."""
    return sorted(__all__)
