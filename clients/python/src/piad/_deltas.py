"""Decodes arrays that change by integer steps: `encoding="delta"` of streams."""

from __future__ import annotations

import base64
from typing import Any

from ._arrays import Array, as_array, as_lists, np
from .errors import ProtocolError

_BLOCK = 256


def moved(before: Array, step: float, text: str, dimension: int) -> Array:
    """Adds `step` times the packed integers to an array; `dimension` is the length of its last axis, 1 for weights.
    """
    packed = base64.b64decode(text, validate=True)
    if np is not None:
        whole = np.concatenate(_lanes(packed, before.size // dimension, dimension, _with_numpy))
        array: Array = before + step * whole.reshape(dimension, -1).T.reshape(before.shape)
        return array
    flat = _flat(as_lists(before))
    places = len(flat) // dimension
    lanes = _lanes(packed, places, dimension, _without_numpy)
    whole = [number for block in lanes for number in block]
    numbers = iter([x + step * whole[i % dimension * places + i // dimension] for i, x in enumerate(flat)])
    return as_array(_like(before, numbers))


def _lanes(packed: bytes, places: int, dimension: int, unpack: Any) -> list[Any]:
    """Decodes the blocks of all coordinates."""
    at, blocks = 0, []
    for _ in range(dimension):
        for start in range(0, places, _BLOCK):
            count = min(_BLOCK, places - start)
            width = packed[at] if at < len(packed) else 33
            end = at + 1 + (count * width + 7) // 8
            if width > 32 or end > len(packed):
                raise ProtocolError("the server sent packed numbers that are cut off or too wide")
            blocks.append(unpack(packed[at + 1 : end], width, count))
            at = end
    if at != len(packed):
        raise ProtocolError("the server sent more packed numbers than there are")
    return blocks


def _with_numpy(packed: bytes, width: int, count: int) -> Any:
    bits = np.unpackbits(np.frombuffer(packed, "u1"), bitorder="little")[: count * width]
    z = bits.reshape(count, width) @ (1 << np.arange(width, dtype="i8"))
    return (z >> 1) ^ -(z & 1)


def _without_numpy(packed: bytes, width: int, count: int) -> list[int]:
    word, mask = int.from_bytes(packed, "little"), (1 << width) - 1
    numbers = (word >> i * width & mask for i in range(count))
    return [(z >> 1) ^ -(z & 1) for z in numbers]


def _flat(values: Any) -> list[float]:
    return [x for value in values for x in _flat(value)] if isinstance(values, list) else [values]


def _like(values: Any, numbers: Any) -> Any:
    """Takes the next numbers, nested like these lists."""
    return [_like(value, numbers) if isinstance(value, list) else next(numbers) for value in values]
