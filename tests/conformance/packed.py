"""Decodes differences of numbers bit by bit, as specified in docs/reference/events.md."""

BLOCK = 256


def unpacked(packed: bytes, places: int, dimension: int) -> list[int]:
    """Decodes integers, coordinate by coordinate."""
    at, numbers = 0, []
    for _ in range(dimension):
        for start in range(0, places, BLOCK):
            count, width = min(BLOCK, places - start), packed[at]
            end = at + 1 + (count * width + 7) // 8
            bits = int.from_bytes(packed[at + 1 : end], "little")
            for i in range(count):
                z = bits >> i * width & (1 << width) - 1
                numbers.append(-(z >> 1) - 1 if z & 1 else z >> 1)
            at = end
    assert at == len(packed), "all bytes are read"
    return numbers


def moved(numbers: list[float], step: float, packed: bytes, dimension: int) -> list[float]:
    """Adds differences to numbers, point by point."""
    places = len(numbers) // dimension
    whole = unpacked(packed, places, dimension)
    return [x + step * whole[i % dimension * places + i // dimension] for i, x in enumerate(numbers)]
