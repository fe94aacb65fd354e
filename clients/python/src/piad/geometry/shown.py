"""What curves and surfaces have for their readers: pictures and files."""

from __future__ import annotations

from collections.abc import Coroutine
from html import escape
from os import PathLike
from pathlib import Path
from typing import Any, Literal, Optional, Protocol, Union

from .._blocking import run
from ._optional import load


class Export(Protocol):
    """Writes a file of a geometry: `AsyncJob.download`."""

    def __call__(
        self,
        format: Literal["step", "svg"],
        path: Union[str, PathLike[str]],
        *,
        units: Optional[Literal["mm", "m", "in"]] = None,
    ) -> Coroutine[Any, Any, Path]: ...


class Shown:
    """A curve or a surface."""

    _export: Optional[Export] = None

    def export_by(self, export: Export) -> None:
        """The server that has fitted it writes its files."""
        # The geometry itself is frozen.
        object.__setattr__(self, "_export", export)

    def to_step(self, path: Union[str, PathLike[str]], *, units: Optional[Literal["mm", "m", "in"]] = None) -> Path:
        """Writes a STEP file, with `units` as the unit of the coordinates, and returns its path.

        The server writes it as long as it keeps the job. A `ValueError` if this is not the result of a fit of a `Client`:
        `Job.download` and `AsyncJob.download` write iterations, and other formats.
        """
        return run(self._exporter("step")("step", path, units=units))

    def to_svg(self, path: Union[str, PathLike[str]]) -> Path:
        """Writes a drawing, as `to_step` a STEP file: with the control points, and the data coloured by their distances."""
        return run(self._exporter("svg")("svg", path))

    def _exporter(self, format: str) -> Export:
        if self._export is None:
            raise ValueError(
                f"only results of a Client are written by to_{format}: use job.download({format!r}, path) for others"
            )
        return self._export

    def plot(
        self, *, ax: Any = None, net: bool = True, data: Any = None, samples: Optional[int] = None, **style: Any
    ) -> Any:
        """Draws it with matplotlib, as `piad.plot` does, and returns the axes."""
        load("matplotlib.pyplot", "piad[plot]")
        return self._plot(ax, net, data, samples, style)

    def _plot(self, ax: Any, net: bool, data: Any, samples: Optional[int], style: dict[str, Any]) -> Any:
        raise NotImplementedError

    def _picture(self) -> str:
        raise NotImplementedError

    def _repr_html_(self) -> str:
        """Itself in notebooks: a line and a picture."""
        try:
            picture = self._picture()
        except (ValueError, ZeroDivisionError):
            # A weight of zero, of a fit that fails.
            picture = ""
        return f"<div>{escape(repr(self))}</div>{picture}"

    def __getstate__(self) -> dict[str, Any]:
        # Connections cannot be copied or sent to other processes.
        return {name: value for name, value in self.__dict__.items() if name != "_export"}
