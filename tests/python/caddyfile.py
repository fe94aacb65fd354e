"""The Caddyfiles of deploy/ as Debian's Caddy reads them: version 2.6.2, which has another name for one setting.

There it has no limit: with one, that version reads the request again behind its end."""

import pathlib

NEW, OLD = "request_buffers 1MiB", "buffer_requests"


def of_debian(path: pathlib.Path) -> str:
    text = path.read_text()
    assert NEW in text, f"there is no {NEW} in {path}"
    return text.replace(NEW, OLD)
