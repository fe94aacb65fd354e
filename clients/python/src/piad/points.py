"""Points read from files by the server."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Optional, Union

from ._arrays import Array, as_array, size
from .errors import ProtocolError


@dataclass(frozen=True)
class FilePoints:
    """The points of a file, for fits."""

    points: Array
    """Of a curve and of scattered points of shape (n, dimension), of rows of a surface (rows, columns, dimension)."""
    name: Optional[str] = None
    """The name in the file."""
    notices: tuple[str, ...] = ()
    """Notes about how the file was read."""
    closed: bool = False
    """True if the curve is closed: the file repeats its first point at the end, which is dropped here."""
    parameters: Union[tuple[float, ...], Mapping[str, Any], None] = None
    """Parameters for the fit. Of a curve: the times of its points, if requested. Of a surface: the numbers of points of
    sections, the triangles of a mesh, or the rows and columns of a grid with missing points."""
    scattered: bool = False
    """True if the points are those of sections, or the vertices of a mesh."""

    def __repr__(self) -> str:
        closed = ", closed" if self.closed else ""
        name = "" if self.name is None else f" {self.name!r}"
        return f"<piad.FilePoints{name}: {size(self.points)}{closed}>"

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> FilePoints:
        """Reads an answer of the server."""
        shape = value.get("curve") or value.get("surface")
        if shape is None:
            raise ProtocolError("the server has read neither a curve nor a surface")
        parameters = shape.get("parameters")
        is_scattered = "scattered" in shape
        return cls(
            as_array(shape["scattered" if is_scattered else "points"]),
            value.get("name"),
            tuple(value["notices"]),
            shape.get("closed", False),
            tuple(parameters) if isinstance(parameters, list) else parameters,
            is_scattered,
        )
