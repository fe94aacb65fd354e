"""Writes least_squares.json: limits of least-squares fits with constraints, weights of data and
fairness.

    target/venv/bin/python tests/golden/least_squares.py

Smoothing splines come from scipy.interpolate.make_smoothing_spline, weighted fits from make_lsq_spline; the others
from the dense KKT system [[N, C'], [C, 0]] of collocation matrices by scipy.interpolate.BSpline, with integrals by
numpy's Gauss nodes. Every entry has the request and the control points of the minimum."""
import json
from math import comb
from pathlib import Path

import numpy as np
from scipy.interpolate import BSpline, make_lsq_spline, make_smoothing_spline
from scipy.optimize import nnls

CASES = []


def chord_length(points):
    return np.r_[0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]


def row(knots, p, t, r=0, free=None):
    """Derivative r of all functions at t; of closed directions with `free` control points those of a control point
    together, where function p // 2 belongs to the first one."""
    n = len(knots) - p - 1
    values = np.array([BSpline(knots, e, p)(t, nu=r) for e in np.eye(n)])
    if free is None:
        return values
    folded = np.zeros(free)
    for j in range(n):
        folded[(j - p // 2) % free] += values[j]
    return folded


def energy(knots, p, r, free=None):
    nodes, weights = np.polynomial.legendre.leggauss(p + 1)
    low, high = knots[p], knots[-p - 1]
    breaks = [x for x in np.unique(knots) if low <= x <= high]
    total = 0
    for a, b in zip(breaks[:-1], breaks[1:]):
        for x, w in zip(nodes, weights):
            f = row(knots, p, (a + b) / 2 + (b - a) / 2 * x, r, free)
            total = total + w * (b - a) / 2 * np.outer(f, f)
    return total


def kkt(N, b, C, R, tangents=()):
    """`tangents` are constraints with a non-negative multiple, which is optimised."""
    n, m = len(N), len(C)
    if not m:
        return np.linalg.solve(N, b)
    C, R = np.array(C), np.array(R, float)

    def solve(b, R):
        return np.linalg.solve(np.block([[N, C.T], [C, np.zeros((m, m))]]), np.vstack([b, R]))[:n]

    if not tangents:
        return solve(b, R)
    fixed = R.copy()
    fixed[tangents] = 0
    steps = [solve(0 * b, np.eye(m)[:, [k]] * R[k]) for k in tangents]
    start = solve(b, fixed)
    H = np.array([[np.sum(a * (N @ c)) for c in steps] for a in steps])
    h = np.array([np.sum(a * (b - N @ start)) for a in steps])
    root = np.linalg.cholesky(H)
    factors, _ = nnls(root.T, np.linalg.solve(root, h))
    return start + sum(s * a for s, a in zip(factors, steps))


def case(name, job, control_points):
    CASES.append({"name": name, "job": job, "control_points": np.asarray(control_points).tolist()})


def wave(n):
    s = np.linspace(0, 4, n)
    return np.c_[np.cos(s), np.sin(2 * s), s] + .02 * np.c_[np.sin(37 * s), np.cos(53 * s), np.sin(71 * s)]


def knots_of(t, p, n):
    """Clamped knots of n control points at equal shares of the indices of t."""
    inner = np.interp(np.arange(1, n - p) * (len(t) - 1) / (n - p), np.arange(len(t)), t)
    return np.r_[[t[0]] * (p + 1), inner, [t[-1]] * (p + 1)]


def curve(name, points, p, n, constraints=(), ends=None, weights=None, fairness=None, order=None):
    """`constraints` are pairs of JSON and (t, order of derivative, value)."""
    t = chord_length(points)
    knots = knots_of(t, p, n)
    A = np.array([row(knots, p, x) for x in t])
    W = np.ones(len(t)) if weights is None else np.asarray(weights)
    N, b = A.T @ (W[:, None] * A), A.T @ (W[:, None] * points)
    method = {"kind": "least_squares", "control_points": n, "variant": "direct"}
    if fairness is not None:
        r = order or 2
        N = N + fairness * W.sum() * (t[-1] - t[0]) ** (2 * r - 1) * energy(knots, p, r)
        method["fairness"] = fairness
        if order:
            method["fairness_order"] = order
    if weights is not None:
        method["data_weights"] = list(weights)
    if constraints:
        method["constraints"] = [c for c, _ in constraints]
    conditions = [f(t, points) for _, f in constraints]
    tangents = [k for k, (c, _) in enumerate(constraints) if "tangent" in c]
    if ends:
        method["end_points"] = ends
    if ends != "free":
        fixed = [x for x, r, _ in conditions if r == 0]
        conditions += [(t[k], 0, points[k]) for k in (0, -1) if t[k] not in fixed]
    C, R = [row(knots, p, x, r) for x, r, _ in conditions], [value for *_, value in conditions]
    job = {"curve": {"points": points.tolist(), "parameters": t.tolist(), "basis": {"kind": "bspline", "degree": p, "knots": knots.tolist()}}, "method": method}
    case(name, job, kkt(N, b, C, R, tangents))


def at(where, what, value):
    """A constraint of a curve, as JSON and as a condition."""
    order = {"point": 0, "derivative": 1, "tangent": 1, "second_derivative": 2}[what]

    def condition(t, points):
        x = t[0] if where == "start" else t[-1] if where == "end" else t[where["index"]] if "index" in where else where["parameter"]
        return x, order, np.asarray(value, float)
    return {"at": where, what: value}, condition


def through(index):
    return {"index": index}, lambda t, points: (t[index], 0, points[index])


def curves():
    data = wave(120)
    curve("ends", data, 3, 20)
    curve("ends by name, degree 2", data, 2, 15, ends="interpolated")
    curve("free ends, degree 4", data, 4, 18, ends="free")
    tangents = [at("start", "tangent", [0, 2, 1]), at("end", "tangent", [1, 1, 1]), through(60)]
    curve("tangents and a point", data, 3, 25, tangents)
    curve("derivatives, degree 5", data, 5, 21, [at("start", "derivative", [.5, 1, 0]), at("start", "second_derivative", [0, -1, 2]), at({"parameter": 3.21}, "point", [1, 2, 3]), at({"index": 90}, "derivative", [1, 0, 0])])
    curve("another start", data, 3, 20, [at("start", "point", [1.1, .1, .1])])
    curve("free ends with a point", data, 4, 17, [through(33)], ends="free")
    weights = [1 + 3 * (i % 5) for i in range(120)]
    weights[40:50] = [0] * 10
    curve("weights", data, 3, 22, weights=weights)
    curve("reversed tangents", data, 3, 16, [at("start", "tangent", [0, -2, -1]), at("end", "tangent", [1, 1, 1]), at({"index": 70}, "tangent", [1, 0, 0])])
    curve("weights and a tangent", data, 3, 22, [at("start", "tangent", [1, 0, 0])], weights=weights)
    for order in (None, 3):
        for fairness in (1e-10, 1e-6):
            curve(f"fairness {fairness}, order {order}", data, 4, 30, fairness=fairness, order=order)
    curve("fairness, a point and weights", data, 3, 40, [through(7), at("end", "second_derivative", [0, 0, 0])], weights=weights, fairness=1e-9)
    curve("more control points than data", wave(12), 3, 20, fairness=1e-6)
    few = wave(4)
    curve("four points", few, 3, 4, ends="free")
    curve("two control points", wave(9), 1, 2)


def smoothing():
    """Fairness is without units: lam = fairness n (t[-1] - t[0])^3."""
    x = np.sort(np.random.default_rng(3).uniform(0, 10, 25))
    y = np.sin(x) + .1 * np.cos(17 * x)
    knots = np.r_[[x[0]] * 4, x[1:-1], [x[-1]] * 4]
    for lam in (1e-3, .1, 10):
        spline = make_smoothing_spline(x, y, lam=lam)
        # The same spline over knots at all data, interpolated at one parameter for each control
        # point.
        places = np.array([knots[i + 1:i + 4].mean() for i in range(len(knots) - 4)])
        control = np.linalg.solve(np.array([row(knots, 3, s) for s in places]), spline(places))
        fairness = lam / len(x) / (x[-1] - x[0]) ** 3
        job = {"curve": {"points": [[v] for v in y], "parameters": x.tolist(), "basis": {"kind": "bspline", "degree": 3, "knots": knots.tolist()}},
               "method": {"kind": "least_squares", "control_points": len(x) + 2, "variant": "direct", "end_points": "free", "fairness": fairness}}
        case(f"make_smoothing_spline, lam {lam}", job, control[:, None])


def weighted():
    points = wave(80)
    t = chord_length(points)
    knots = knots_of(t, 3, 17)
    weights = .2 + np.abs(np.sin(np.arange(80.)))
    # scipy's weights multiply distances, ours their squares.
    spline = make_lsq_spline(t, points, knots, 3, w=np.sqrt(weights))
    job = {"curve": {"points": points.tolist(), "parameters": t.tolist(), "basis": {"kind": "bspline", "degree": 3, "knots": knots.tolist()}},
           "method": {"kind": "least_squares", "control_points": 17, "variant": "direct", "end_points": "free", "data_weights": weights.tolist()}}
    case("make_lsq_spline", job, spline.c)


def closed():
    """A closed curve of ten control points with given knots is that of uniform parameters: knots every n-th datum."""
    n, free, p = 60, 10, 3
    s = np.arange(n) * 2 * np.pi / n
    points = np.c_[np.cos(s) + .1 * np.cos(5 * s), np.sin(s)] + .01 * np.c_[np.sin(31 * s), np.cos(23 * s)]
    t = np.arange(n + 1) / n
    knots = np.arange(-p, free + p + 1) / free
    A = np.array([row(knots, p, x, 0, free) for x in t[:-1]])
    N, b = A.T @ A + 1e-9 * n * energy(knots, p, 2, free), A.T @ points
    C, R = [row(knots, p, .25, 0, free), row(knots, p, t[30], 1, free)], [np.array([0, 1.]), np.array([0, -6.])]
    constraints = [{"at": {"parameter": .25}, "point": [0, 1]}, {"at": {"index": 30}, "derivative": [0, -6]}]
    job = {"curve": {"points": points.tolist(), "parameters": t.tolist(), "closed": True, "basis": {"kind": "bspline", "degree": p}},
           "method": {"kind": "least_squares", "control_points": free, "variant": "direct", "fairness": 1e-9, "constraints": constraints}}
    case("closed", job, kkt(N, b, C, R))


def surface(name, shape, degrees, counts, constraints=(), ends=None, weights=None, fairness=None, order=2, boundaries=(), missing=()):
    """`constraints` are pairs of JSON and (u, v, orders, value); boundaries are (name, order, control points)."""
    u, v = np.linspace(0, 2, shape[0]), np.linspace(0, 1, shape[1]) ** 1.2
    x, y = np.meshgrid(u, v, indexing="ij")
    points = np.stack([x, y, np.sin(2 * x) * np.cos(3 * y) + .02 * np.sin(31 * x + 17 * y)], -1)
    ku, kv = knots_of(u, degrees[0], counts[0]), knots_of(v, degrees[1], counts[1])
    Au, Av = (np.array([row(k, p, s) for s in t]) for k, p, t in ((ku, degrees[0], u), (kv, degrees[1], v)))
    A, P = np.kron(Au, Av), points.reshape(-1, 3)
    W = np.ones(len(P)) if weights is None else np.asarray(weights, float).reshape(-1)
    for i, j in missing:
        W = W.copy()
        W[i * shape[1] + j] = 0
    N, b = A.T @ (W[:, None] * A), A.T @ (W[:, None] * P)
    if fairness is not None:
        w = fairness * W.sum() * max(u[-1], v[-1]) ** (2 * order - 2)
        N = N + w * sum(comb(order, k) * np.kron(energy(ku, degrees[0], order - k), energy(kv, degrees[1], k)) for k in range(order + 1))
    C, R = [], []
    for _, (s, t, (a, c), value) in constraints:
        C.append(np.kron(row(ku, degrees[0], s, a), row(kv, degrees[1], t, c)))
        R.append(np.asarray(value, float))
    for side, r, control in boundaries:
        axis, place = side.split("_")
        k, p, other = (ku, degrees[0], counts[1]) if axis == "u" else (kv, degrees[1], counts[0])
        f = row(k, p, k[0] if place == "start" else k[-1], r)
        for j, value in enumerate(control):
            e = np.eye(other)[j]
            C.append(np.kron(f, e) if axis == "u" else np.kron(e, f))
            R.append(np.asarray(value, float))
    if ends != "free":
        for i in (0, shape[0] - 1):
            for j in (0, shape[1] - 1):
                f = np.kron(Au[i], Av[j])
                if (i, j) not in missing and np.linalg.matrix_rank(np.array(C + [f]), 1e-9) > len(C):
                    C.append(f)
                    R.append(points[i, j])
    method = {"kind": "least_squares", "control_points": dict(zip("uv", counts)), "variant": "direct"}
    given = [c for c, _ in constraints]
    given += [{"at": {"boundary": side}, "control_points" if r == 0 else "cross_derivatives": np.asarray(c).tolist()} for side, r, c in boundaries]
    if given:
        method["constraints"] = given
    if ends:
        method["end_points"] = ends
    if weights is not None:
        method["data_weights"] = np.asarray(weights).tolist()
    if fairness is not None:
        method["fairness"] = fairness
        method["fairness_order"] = order
    grid = [[None if (i, j) in missing else points[i, j].tolist() for j in range(shape[1])] for i in range(shape[0])]
    basis = {a: {"kind": "bspline", "degree": p, "knots": k.tolist()} for a, p, k in zip("uv", degrees, (ku, kv))}
    job = {"surface": {"points": grid, "parameters": {"u": u.tolist(), "v": v.tolist()}, "basis": basis}, "method": method}
    case(name, job, kkt(N, b, C, R).reshape(*counts, 3))


def surfaces():
    surface("surface with corners", (14, 11), (3, 3), (7, 6))
    surface("surface with weights", (13, 9), (2, 3), (6, 5), weights=1 + np.arange(13)[:, None] % 3 + np.arange(9) % 4)
    surface("surface with fairness", (12, 10), (3, 3), (9, 8), fairness=1e-8)
    surface("surface with fairness of order 3", (12, 10), (3, 4), (8, 7), fairness=1e-9, order=3, ends="free")
    points = [({"at": {"parameter": [.7, .3]}, "point": [.7, .3, .5]}, (.7, .3, (0, 0), [.7, .3, .5])),
              ({"at": {"parameter": [1, .5]}, "derivative_u": [1, 0, 2]}, (1, .5, (1, 0), [1, 0, 2])),
              ({"at": {"parameter": [1, .5]}, "derivative_uv": [0, 0, 1]}, (1, .5, (1, 1), [0, 0, 1]))]
    surface("surface through points", (14, 11), (3, 3), (8, 7), points)
    control = np.c_[np.zeros(6), np.linspace(0, 1, 6), np.cos(np.arange(6.))]
    across = np.c_[np.ones(6), np.zeros(6), np.sin(np.arange(6.))]
    surface("surface along a boundary", (14, 11), (3, 2), (7, 6), boundaries=[("u_start", 0, control), ("u_start", 1, across)])
    control = np.c_[np.linspace(0, 2, 7), np.ones(7), np.zeros(7)]
    surface("surface along another boundary", (14, 11), (3, 3), (7, 6), boundaries=[("v_end", 0, control)])
    surface("surface with holes", (14, 11), (3, 3), (7, 6), missing=[(0, 0), (3, 4), (3, 5), (8, 1)], fairness=1e-10)


if __name__ == "__main__":
    curves()
    smoothing()
    weighted()
    closed()
    surfaces()
    Path(__file__).with_suffix(".json").write_text(json.dumps(CASES) + "\n")
    print(len(CASES), "fits")
