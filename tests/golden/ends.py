"""Writes ends.json: control points of interpolating B-splines with all kinds of end conditions, by
scipy.

    target/venv/bin/python tests/golden/ends.py

Curves without fixed weights come from scipy.interpolate.make_interp_spline with bc_type, where estimated
derivatives are those of numpy's polynomial through the first points; curves with fixed weights from a dense
system of rational basis functions and their derivatives; surfaces from curves, one direction after the other."""
import json
from pathlib import Path

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline


def chord_length(points):
    return np.r_[0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]


def knots(t, p):
    return np.r_[[t[0]] * (p + 1), t[1:-1], [t[-1]] * (p + 1)]


def estimated(t, values, count, given=()):
    """Derivatives 1 … count at t[0] of the polynomial of degree count + 1 (or less) through the first points that has
    the given derivatives there."""
    from math import factorial
    m = min(count + 1 - len(given), len(t) - 1)
    s = t[1:m + 1] - t[0]
    rest = values[1:m + 1] - values[0]
    for r, derivative in enumerate(given, 1):
        rest = rest - np.multiply.outer(s ** r, np.asarray(derivative) / factorial(r))
    orders = np.arange(len(given) + 1, len(given) + 1 + m)
    coefficients = np.linalg.solve(s[:, None] ** orders, rest.reshape(m, -1)) if len(given) < count else np.zeros((0, 1))
    found = list(given) + [c.reshape(values.shape[1:]) * factorial(r) for r, c in zip(orders, coefficients)]
    found += [np.zeros(values.shape[1:])] * (count - len(found))
    return found[:count]


def derivatives(t, values, end, count, length, at_end):
    """The conditions for scipy at an end: pairs of orders and derivatives."""
    if end == "natural":
        return [(2, np.zeros(values.shape[1:]))]
    if end == "repeated":
        return [(r, np.zeros(values.shape[1:])) for r in range(1, count + 1)]
    sign = -1.0 if at_end else 1.0
    if at_end:
        t, values = -t[::-1], values[::-1]
    given = []
    if isinstance(end, dict):
        if "tangent" in end:
            direction = np.asarray(end["tangent"], float)
            span = abs(t[-1] - t[0])
            size = np.linalg.norm(direction, axis=-1, keepdims=True)
            given = [direction / size * (np.asarray(length)[..., None] if direction.ndim > 1 else length) / span]
        else:
            given = [np.asarray(d, float) for d in end.get("derivatives", [end.get("derivative")])]
    given = [d * sign ** r for r, d in enumerate(given, 1)]
    return [(r, d * sign ** r) for r, d in enumerate(estimated(t, values, count, given), 1)]


def curve(t, values, p, ends, length=None):
    """Control points of the spline through values (n × …) with these ends."""
    front, back = p // 2, p - 1 - p // 2
    start = derivatives(t, values, ends[0], front, length, False)
    end = derivatives(t, values, ends[1], back, length, True)
    return make_interp_spline(t, values, p, t=knots(t, p), bc_type=(start or None, end or None)).c


def natural_pair(t, values, p, ends, length=None):
    return curve(t, values, p, ends, length)


def rational(t, points, p, ends, weights):
    """A dense system: R(t_i) c = P_i, and derivatives of the rational basis at the ends."""
    U, n = knots(t, p), len(t) - 1
    size = n + p
    basis = [BSpline(U, np.eye(size)[j], p) for j in range(size)]

    def row(x, order):
        value = np.array([[b.derivative(r)(x) if r else b(x) for b in basis] for r in range(order + 1)]) * weights
        total = value.sum(1)
        if order == 0:
            return value[0] / total[0]
        first = (value[1] - total[1] * value[0] / total[0]) / total[0]
        if order == 1:
            return first
        return (value[2] - total[2] * value[0] / total[0] - 2 * total[1] * first) / total[0]

    rows, right = [row(x, 0) for x in t], list(points)
    for end, at, reverse in ((ends[0], t[0], False), (ends[1], t[-1], True)):
        for order, derivative in derivatives(t, points, end, 1, None, reverse):
            rows.append(row(at, order))
            right.append(derivative)
    return np.linalg.solve(np.array(rows), np.array(right))


def spec(ends):
    return ends[0] if ends[0] == ends[1] and isinstance(ends[0], str) else {"start": ends[0], "end": ends[1]}


CASES = []


def case(name, job, control_points, weights=None):
    entry = {"name": name, "job": job, "control_points": np.asarray(control_points).tolist()}
    if weights is not None:
        entry["weights"] = np.asarray(weights).tolist()
    CASES.append(entry)


def add_curve(name, points, p, ends, parameters=None):
    points = np.asarray(points, float)
    t = chord_length(points) if parameters is None else np.asarray(parameters, float)
    job = {"curve": {"points": points.tolist(), "basis": {"kind": "bspline", "degree": p, "knots": "data"}, "ends": spec(ends)}}
    if parameters is not None:
        job["curve"]["parameters"] = list(parameters)
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    case(name, job, curve(t, points, p, ends, length))


def helix(n):
    angle = np.linspace(0, 6 * np.pi, n)
    return np.c_[np.cos(angle), np.sin(angle), angle / 2]


D = (np.array([0, 1, .5]) / np.hypot(1, .5)).tolist()
UNEVEN = [[0, 0], [.3, .8], [.5, 1], [1.7, 1.1], [1.9, .2], [2.6, -.4], [3, -.5], [4.2, .1], [4.3, .9], [5.5, 1.4], [6, 1]]
E2 = {"derivative": [.4, 2.1]}


def curves():
    add_curve("natural", helix(30), 3, ("natural", "natural"))
    add_curve("derivatives", helix(30), 3, ({"derivative": D}, {"derivative": D}))
    add_curve("estimated", helix(30), 3, ("estimated", "estimated"))
    add_curve("repeated", helix(30), 3, ("repeated", "repeated"))
    add_curve("natural and derivative", UNEVEN, 3, ("natural", E2))
    add_curve("derivative and natural", UNEVEN, 3, (E2, "natural"))
    add_curve("tangent and estimated", UNEVEN, 3, ({"tangent": [1, 3]}, "estimated"))
    add_curve("estimated and tangent", UNEVEN, 3, ("estimated", {"tangent": [-2, 1]}))
    add_curve("uneven parameters", UNEVEN, 3, ("estimated", "natural"), [0, 1, 1.5, 4, 4.2, 5, 7, 8, 8.1, 9, 20])
    add_curve("quintic, estimated", UNEVEN, 5, ("estimated", "estimated"))
    add_curve("quintic, one derivative", UNEVEN, 5, (E2, "repeated"))
    add_curve("quintic, two derivatives", UNEVEN, 5, ({"derivatives": [[.4, 2.1], [-1, .5]]}, {"derivatives": [[.7, -.2], [.3, .1]]}))
    add_curve("degree 7", UNEVEN, 7, ("estimated", {"tangent": [1, 0]}))
    add_curve("degree 4", UNEVEN, 4, (E2, "estimated"))
    add_curve("degree 2", UNEVEN, 2, ("estimated", "estimated"))
    add_curve("degree 2, derivative", UNEVEN, 2, (E2, "repeated"))
    add_curve("two points", UNEVEN[:2], 3, ("natural", "natural"))
    add_curve("two points, estimated", UNEVEN[:2], 3, ("estimated", "estimated"))
    add_curve("two points, natural and derivative", UNEVEN[:2], 3, ("natural", E2))
    add_curve("two points, derivative and natural", UNEVEN[:2], 3, (E2, "natural"))
    add_curve("three points", UNEVEN[:3], 3, ("natural", "estimated"))
    add_curve("one coordinate", np.sin(np.arange(9.0))[:, None], 3, ("natural", "estimated"), list(range(9)))


def weighted():
    points = np.array(UNEVEN)
    t, w = chord_length(points), np.array([1, .8, 1.3, 2, 1, .7, .9, 1.5, 1.2, 1, 2.5])
    lifted = np.c_[points * w[:, None], w]
    for ends in (("estimated", "natural"), ({"derivative": [.4, 2.1]}, {"tangent": [1, -1]})):
        given = []
        for end, at_end in zip(ends, (False, True)):
            if isinstance(end, str):
                given.append(end)
                continue
            # (w C)' = w' C + w C', with w' as it is estimated.
            i = -1 if at_end else 0
            slope = derivatives(t, w[:, None], "estimated", 1, None, at_end)[0][1]
            length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
            own = derivatives(t, points, end, 1, length, at_end)[0][1]
            given.append({"derivative": np.r_[slope * points[i] + w[i] * own, slope]})
        net = curve(t, lifted, 3, given)
        basis = {"kind": "bspline", "degree": 3, "knots": "data"}
        shape = {"points": UNEVEN, "basis": basis, "weights": w.tolist(), "ends": spec(ends)}
        case("homogeneous", {"curve": shape}, net[:, :2] / net[:, 2:], net[:, 2])
    every = np.r_[1, 1.4, w[1:-1], 1.1, 1.3]
    for ends in (("estimated", "estimated"), (E2, "natural"), ("natural", "repeated")):
        shape = {"points": UNEVEN, "basis": {"kind": "bspline", "degree": 3, "knots": "data"}, "weights": every.tolist(), "ends": spec(ends)}
        case("fixed weights", {"curve": shape, "rational": "fixed"}, rational(t, points, 3, ends, every))


def surfaces():
    u, v = np.array([0, .5, 1.2, 2, 2.3, 3.1, 4]), np.array([0, .7, 1, 2.2, 3, 3.4, 4.1, 5, 5.2])
    x, y = np.meshgrid(u, v, indexing="ij")
    points = np.stack([x, y, np.sin(x) * np.cos(.8 * y) + .1 * x * y], axis=2)
    rows, columns = len(u), len(v)
    across = [[.9, .1, .2 + .1 * np.cos(j)] for j in range(columns)]
    along = [[.1, 1.1, .3 * np.sin(i)] for i in range(rows)]

    def add(name, p, q, ends_u, ends_v):
        # Tangents have the length of their line over the range of its parameters.
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=2).sum(0)
        net = curve(u, points, p, ends_u, lengths)
        if any(isinstance(end, dict) for end in ends_v):
            # Derivatives along v at rows of data; the twist is that of the derivatives along u.
            net = both(p, q, ends_u, ends_v)
        else:
            net = np.moveaxis(curve(v, np.moveaxis(net, 1, 0), q, ends_v), 0, 1)
        basis = {"u": {"kind": "bspline", "degree": p, "knots": "data"}, "v": {"kind": "bspline", "degree": q, "knots": "data"}}
        shape = {"points": points.tolist(), "basis": basis, "parameters": {"u": u.tolist(), "v": v.tolist()}}
        shape["ends"] = {"u": spec(ends_u), "v": spec(ends_v)}
        case(name, {"surface": shape}, net)

    def both(p, q, ends_u, ends_v):
        """v first with the derivatives of each row; then u on the control points, where derivatives across the boundary
        are those of the curves through them along v with estimated ends."""
        lengths = np.linalg.norm(np.diff(points, axis=1), axis=2).sum(1)
        net = curve(v, np.moveaxis(points, 1, 0), q, ends_v, lengths)
        words = tuple("estimated" if isinstance(end, dict) else end for end in ends_v)
        start, end = [], []
        for side, at_end, target in ((ends_u[0], False, start), (ends_u[1], True, end)):
            count = p - 1 - p // 2 if at_end else p // 2
            for order, field in derivatives(u, points, side, count, None, at_end):
                target.append((order, curve(v, field, q, words)))
        return make_interp_spline(u, np.moveaxis(net, 0, 1), p, t=knots(u, p), bc_type=(start, end)).c

    add("surface, estimated", 3, 3, ("estimated",) * 2, ("estimated",) * 2)
    add("surface, natural", 3, 3, ("natural",) * 2, ("natural",) * 2)
    add("surface, mixed", 3, 3, ("natural", "estimated"), ("repeated", "natural"))
    add("surface, quintic and cubic", 5, 3, ("estimated",) * 2, ("natural", "estimated"))
    add("surface, derivatives across u", 3, 3, ({"derivative": across}, {"tangent": across}), ("estimated",) * 2)
    add("surface, derivatives across both", 3, 3, ({"derivative": across}, "estimated"), ({"derivative": along}, "estimated"))
    # A torus-like strip, closed along u.
    angle = np.arange(8) * 2 * np.pi / 8
    strip = np.stack([np.outer(np.cos(angle), 2 + .2 * v), np.outer(np.sin(angle), 2 + .2 * v), np.outer(np.ones(8), np.sin(v))], axis=2)
    period = np.r_[np.arange(9.0)]
    closed = make_interp_spline(period, np.concatenate([strip, strip[:1]]), 3, bc_type="periodic")
    net = np.moveaxis(curve(v, np.moveaxis(closed.c, 1, 0), 3, ("natural", "estimated")), 0, 1)
    shape = {"points": strip.tolist(), "parameters": {"u": period.tolist(), "v": v.tolist()}, "closed": {"u": True, "v": False}}
    shape["ends"] = {"v": {"start": "natural", "end": "estimated"}}
    case("surface, closed along u", {"surface": shape}, net)


curves()
weighted()
surfaces()
Path(__file__).with_name("ends.json").write_text(json.dumps(CASES, separators=(",", ":")) + "\n")
