"""Packages that are only needed by those who ask for them."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from ..errors import MissingPackage


def load(module: str, package: str) -> Any:
    """A module; without it, an error that says which package has it, or why that cannot be loaded."""
    try:
        return import_module(module)
    except ImportError as error:
        # Those that are there may lack a library of the system, such as libGL.so.1.
        why = None if isinstance(error, ModuleNotFoundError) else str(error)
        raise MissingPackage(module, package, why) from error
