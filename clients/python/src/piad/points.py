"""Points that the server reads from files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Optional

from ._arrays import Array, as_array, size
from .errors import ProtocolError


@dataclass(frozen=True)
class FilePoints:
    """The points of a file, as fits take them."""

    points: Array
    """Of a curve of shape (n, dimension), of a surface (rows, columns, dimension)."""
    name: Optional[str] = None
    """What the file calls itself."""
    notices: tuple[str, ...] = ()
    """What was found out about the file, in sentences."""
    closed: bool = False
    """The curve is closed: the file had its first point at the end again, which is not among the points."""
    parameters: Optional[tuple[float, ...]] = None
    """The parameters of the points of a curve: their times, where these were asked for."""

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
        return cls(
            as_array(shape["points"]),
            value.get("name"),
            tuple(value["notices"]),
            shape.get("closed", False),
            None if parameters is None else tuple(parameters),
        )
