"""Where the program `piad` is."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

from .errors import ServerNotStarted

_NAME = "piad.exe" if os.name == "nt" else "piad"

_MISSING = (
    "a fit without the URL of a server needs the program piad, which is neither in this environment nor in PATH: install "
    "the wheel of piad that contains it (`make wheel`), or the program alone (`cargo install --locked --path .`), or "
    "name the program in PIAD_PROGRAM; or give the URL of a server, as url=… or in PIAD_URL"
)


def find_program() -> str:
    """The path of the program: as PIAD_PROGRAM says, of this package, of the environment, or in PATH."""
    named = os.environ.get("PIAD_PROGRAM")
    if named:
        if not _is_program(Path(named)):
            raise ServerNotStarted(f"PIAD_PROGRAM is {named!r}, which is not a program")
        return named
    for path in _beside():
        if _is_program(path):
            return str(path)
    found = shutil.which(_NAME)
    if found is None:
        raise ServerNotStarted(_MISSING)
    return found


def _beside() -> Iterator[Path]:
    """Where installers put that of the wheel."""
    try:
        files = metadata.files("piad") or []
    except metadata.PackageNotFoundError:
        files = []
    yield from (Path(os.path.normpath(file.locate())) for file in files if file.name == _NAME)
    # `pip install --target` moves it, and does not record that.
    yield Path(__file__).parents[1] / "bin" / _NAME


def _is_program(path: Path) -> bool:
    return path.is_file() and os.access(path, os.X_OK)
