"""Adapts the Caddyfiles of deploy/ to Debian's Caddy 2.6.2, which has another name for one setting.

The setting has no limit there: with one, that version reads beyond the end of the request."""

import pathlib

NEW, OLD = "request_buffers 1MiB", "buffer_requests"


def of_debian(path: pathlib.Path) -> str:
    text = path.read_text()
    assert NEW in text, f"there is no {NEW} in {path}"
    return text.replace(NEW, OLD)
