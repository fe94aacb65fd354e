"""Packages that are only needed by those who ask for them."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from ..errors import MissingPackage


def load(module: str, package: str) -> Any:
    """A module; without it, an error that says which package has it."""
    try:
        return import_module(module)
    except ImportError as error:
        raise MissingPackage(module, package) from error
