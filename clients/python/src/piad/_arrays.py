"""Arrays of numbers: numpy arrays if numpy is installed, otherwise nested lists.

All array operations of the package are here, so other modules do not depend on which of the two is used.
"""

from __future__ import annotations

import base64
import struct
from collections.abc import Callable, Iterable, Sequence
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy
    from numpy.typing import NDArray

    Array = NDArray[numpy.float64]
else:
    Array = Any


def _import_numpy() -> ModuleType | None:
    try:
        import numpy
    except ImportError:
        return None
    return numpy


np: Any = _import_numpy()


def as_array(values: Any) -> Array:
    """An array, or nested lists of numbers. JSON null becomes NaN, which marks a missing number."""
    if np is not None:
        return _numpy_array(values)
    nested: Any = _map(lambda x: float("nan") if x is None else float(x), as_lists(values))
    return nested  # type: ignore[no-any-return]


def _numpy_array(values: Any) -> Array:
    array: Array = np.asarray(values, dtype="f8")
    return array


def from_base64(text: str, shape: Sequence[int], *, single: bool = False) -> Array:
    """Decodes little-endian 64-bit numbers (32-bit if `single`) in row-major order."""
    raw = base64.b64decode(text, validate=True)
    if np is not None:
        array: Array = np.frombuffer(raw, "<f4" if single else "<f8").astype("f8").reshape(tuple(shape))
        return array
    size, letter = (4, "f") if single else (8, "d")
    nested: Any = _fold(list(struct.unpack(f"<{len(raw) // size}{letter}", raw)), shape)
    return nested  # type: ignore[no-any-return]


def _fold(flat: list[Any], shape: Sequence[int]) -> Any:
    """A flat list as lists of lists."""
    for length in reversed(shape[1:]):
        flat = [flat[i : i + length] for i in range(0, len(flat), length)]
    return flat


def as_lists(values: Any) -> Any:
    """Converts an array, tuples or any other iterables to nested lists."""
    if hasattr(values, "tolist"):
        return values.tolist()
    if isinstance(values, Iterable) and not isinstance(values, (str, bytes)):
        return [as_lists(value) for value in values]
    return values


def size(values: Any) -> str:
    """The shape of an array as text, such as "40 × 3"."""
    lengths = list(getattr(values, "shape", ()))
    while isinstance(values, (list, tuple)):
        lengths.append(len(values))
        values = values[0] if values else None
    return " × ".join(map(str, lengths))


def depth(values: Any) -> int:
    """The number of dimensions: 0 for a number, and 1 more for each level of lists. Elements that are None are missing
    and are skipped.
    """
    if hasattr(values, "ndim"):
        return int(values.ndim)
    if not isinstance(values, Iterable) or isinstance(values, (str, bytes)):
        return 0
    return 1 + next((depth(value) for value in values if value is not None), 0)


def copy(values: Array) -> Array:
    """A writable copy."""
    if np is not None:
        return values.copy()
    nested: Any = _map(float, values)
    return nested  # type: ignore[no-any-return]


def _map(function: Callable[[Any], float], values: Any) -> Any:
    if isinstance(values, list):
        return [_map(function, value) for value in values]
    return function(values)


def mix(factors: Sequence[float], items: Any) -> Any:
    """The linear combination of items, which are numbers or lists of the same shape."""
    if isinstance(items[0], list):
        return [mix(factors, elements) for elements in zip(*items)]
    return sum(factor * item for factor, item in zip(factors, items))


def outer(u: Sequence[float], v: Sequence[float]) -> Array:
    """The outer product of two lists."""
    return as_array([[a * b for b in v] for a in u])
