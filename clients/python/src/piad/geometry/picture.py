"""Small pictures of curves and surfaces in SVG, without any other package."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from .._arrays import as_lists
from .shapes import EvaluatedCurve, EvaluatedSurface

_WIDTH, _HEIGHT, _MARGIN = 480.0, 300.0, 8.0

# Samples of a line, lines of a surface in each direction, and control points above which none is drawn.
_SAMPLES, _LINES, _MOST_POINTS = 300, 13, 200

Line = list[tuple[float, float]]


def curve_picture(curve: EvaluatedCurve) -> str:
    """A curve with its control points: in the plane, or in space seen from the side; values over their parameter."""
    parameters = _steps(curve.domain, _SAMPLES)
    points = as_lists(curve.evaluate(parameters))
    if curve.dimension == 1:
        return _picture([[(u, value[0]) for u, value in zip(parameters, points)]], [], equal=False)
    controls = as_lists(curve.control_points)
    shown = controls if len(controls) <= _MOST_POINTS else []
    return _picture([list(map(_seen, points))], list(map(_seen, shown)), equal=True)


def surface_picture(surface: EvaluatedSurface) -> str:
    """Lines of a surface in both directions, seen from the side; values are heights over their parameters."""
    ways = [_steps(interval, _LINES) for interval in surface.domain]
    long = [_steps(interval, 4 * _LINES) for interval in surface.domain]
    rows = _rows(surface, ways[0], long[1])
    columns = _rows(surface, long[0], ways[1])
    lines = [*rows, *(list(column) for column in zip(*columns))]
    if surface.dimension == 1:
        lines = _in_a_cube(lines)
    return _picture([list(map(_seen, line)) for line in lines], [], equal=True)


def _rows(surface: EvaluatedSurface, u: list[float], v: list[float]) -> list[list[Sequence[float]]]:
    """Points of a surface on a grid; those of values have their parameters as x and y."""
    points = as_lists(surface.evaluate(u, v))
    if surface.dimension > 1:
        return points  # type: ignore[no-any-return]
    return [[(x, y, value[0]) for y, value in zip(v, row)] for x, row in zip(u, points)]


def _in_a_cube(lines: list[list[Sequence[float]]]) -> list[list[Sequence[float]]]:
    """Points whose coordinates have different units, each scaled to the same length."""
    ranges = [(min(axis), max(axis)) for axis in zip(*(point for line in lines for point in line))]
    return [[[(x - low) / ((high - low) or 1.0) for x, (low, high) in zip(point, ranges)] for point in line] for line in lines]


def _steps(interval: tuple[float, float], count: int) -> list[float]:
    """Equal steps, with both ends as they are."""
    start, end = interval
    return [start + (end - start) * i / (count - 1) for i in range(count - 1)] + [end]


def _seen(point: Sequence[float]) -> tuple[float, float]:
    """A point on the paper: x and y of the plane; of space the first three coordinates, from the side and above."""
    if len(point) == 2:
        return point[0], point[1]
    x, y, z = point[:3]
    return (x - y) * math.cos(math.pi / 6), (x + y) / 2 * math.sin(math.pi / 6) + z


def _picture(lines: list[Line], controls: Line, *, equal: bool) -> str:
    """Lines with control points, as large as fits; with `equal` at the same scale in both directions."""
    seen = [point for line in (*lines, controls) for point in line]
    if not all(math.isfinite(x) and math.isfinite(y) for x, y in seen):
        raise ValueError("points at infinity cannot be drawn")
    left, right = min(x for x, _ in seen), max(x for x, _ in seen)
    low, high = min(y for _, y in seen), max(y for _, y in seen)
    room_x, room_y = _WIDTH - 2 * _MARGIN, _HEIGHT - 2 * _MARGIN
    scale_x = room_x / (right - left) if right > left else math.inf
    scale_y = room_y / (high - low) if high > low else math.inf
    if equal or not math.isfinite(scale_x + scale_y):
        scale_x = scale_y = min(scale_x, scale_y)
    if not math.isfinite(scale_x):
        # All of it is one point.
        scale_x = scale_y = 1.0
    width, height = (right - left) * scale_x + 2 * _MARGIN, (high - low) * scale_y + 2 * _MARGIN

    def placed(line: Line) -> Line:
        return [(_MARGIN + (x - left) * scale_x, _MARGIN + (high - y) * scale_y) for x, y in line]

    stroke = 2 if len(lines) == 1 else 1
    drawn = [_path(placed(line), "#2a6fdb", stroke) for line in lines]
    if controls:
        drawn.insert(0, _path(placed(controls), "#999", 1))
        drawn += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.5" fill="#999"/>' for x, y in placed(controls)]
    size = f'width="{width:.0f}" height="{height:.0f}" viewBox="0 0 {width:.1f} {height:.1f}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{"".join(drawn)}</svg>'


def _path(line: Iterable[tuple[float, float]], colour: str, width: int) -> str:
    places = " ".join(f"{x:.1f},{y:.1f}" for x, y in line)
    return f'<polyline points="{places}" fill="none" stroke="{colour}" stroke-width="{width}"/>'
