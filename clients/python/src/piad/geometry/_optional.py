"""Optional packages."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from ..errors import MissingPackage


def load(module: str, package: str) -> Any:
    """Imports a module; the error names the package that is missing, or why it cannot be loaded."""
    try:
        return import_module(module)
    except ImportError as error:
        # An installed package may lack a system library, such as libGL.so.1.
        why = None if isinstance(error, ModuleNotFoundError) else str(error)
        raise MissingPackage(module, package, why) from error
