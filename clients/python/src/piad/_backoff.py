"""Delays between retries."""

from __future__ import annotations

import random
from datetime import datetime, timezone
from email.utils import parsedate_to_datetime
from typing import Optional

import httpx

_FIRST = 0.25
_LONGEST = 30.0


def delay(failures: int, at_least: float = 0.0) -> float:
    """Seconds to wait after this number of consecutive failures (at least one). The delay doubles each time, with up to
    50% random jitter so that clients do not all reconnect at once.
    """
    doubled = min(max(at_least, _FIRST) * 2.0 ** (failures - 1), _LONGEST)
    return max(doubled, at_least) * random.uniform(1.0, 1.5)


def retry_after(response: httpx.Response) -> Optional[float]:
    """The seconds in the Retry-After header, which may be a date."""
    value = response.headers.get("retry-after")
    if value is None:
        return None
    if value.isdecimal():
        return float(value)
    try:
        until = parsedate_to_datetime(value)
    except ValueError:
        return None
    if until.tzinfo is None:
        until = until.replace(tzinfo=timezone.utc)
    return max(0.0, (until - datetime.now(timezone.utc)).total_seconds())
