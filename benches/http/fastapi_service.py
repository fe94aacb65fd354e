"""The obvious alternative: the same fit as a FastAPI service with numpy, scipy.sparse and orjson.

Cubic B-splines with knots at the data (chord length), classical PIA, every iteration as a server-sent event.

    uvicorn fastapi_service:app --port 8090 --workers 2
"""

import numpy as np
import orjson
from fastapi import FastAPI, Request
from fastapi.responses import StreamingResponse
from scipy.interpolate import BSpline

app = FastAPI()


def prepare(points: np.ndarray):
    """The collocation matrix, with repeated ends added to the first and last control point."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    t = np.concatenate([[0.0], np.cumsum(steps)])
    knots = np.concatenate([[t[0]] * 3, t, [t[-1]] * 3])
    return BSpline.design_matrix(t, knots, 3).tocsr(), knots


@app.post("/fit")
async def fit(request: Request) -> StreamingResponse:
    job = orjson.loads(await request.body())
    points = np.array(job["curve"]["points"], dtype=float)
    iterations = job["stop"]["max_iterations"]

    def events():
        matrix, knots = prepare(points)
        yield b"event: job\ndata: " + orjson.dumps({"degree": 3, "knots": knots}, option=orjson.OPT_SERIALIZE_NUMPY) + b"\n\n"
        x = points.copy()
        for k in range(iterations + 1):
            net = np.concatenate([x[:1], x, x[-1:]])
            delta = points - matrix @ net
            lengths = np.linalg.norm(delta, axis=1)
            at = int(lengths.argmax())
            event = {
                "iteration": k,
                "error": {"max": float(lengths[at]), "rms": float(np.sqrt(np.mean(lengths**2))), "sum": float(lengths.sum()), "at": at},
                "control_points": net,
            }
            data = orjson.dumps(event, option=orjson.OPT_SERIALIZE_NUMPY)
            yield b"event: iteration\nid: " + str(k).encode() + b"\ndata: " + data + b"\n\n"
            x += delta
        yield b"event: end\nid: end\ndata: {}\n\n"

    return StreamingResponse(events(), media_type="text/event-stream")
