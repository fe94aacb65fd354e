"""The Python of the documentation, as a reader copies it."""

from __future__ import annotations

import base64
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from conftest import PROGRAM, ROOT, Server

import piad


def snippets(page: str, section: str) -> list[str]:
    text = (ROOT / page).read_text(encoding="utf-8")
    part = re.search(rf"^## {re.escape(section)}$(.*?)(?=^## |\Z)", text, re.M | re.S)
    assert part, f"{page} has no section {section}"
    return re.findall(r"```python\n(.*?)```", part[1], re.S)


CLIENT = "clients/python/README.md"
SECTIONS = ["Without a server", "Five minutes", "Many fits at once", "Without waiting", "While a point is dragged", "Derivatives", "Plots"]


PAGES = [
    ("README.md", "From Python and CAD"),
    ("docs/how-to/constraints-and-patches.md", "Patches that join"),
    ("docs/tutorials/stream-into-a-plug-in.md", "The program"),
    *((CLIENT, section) for section in SECTIONS),
]


@pytest.mark.parametrize(("page", "section"), PAGES)
def test_examples_run(page: str, section: str, server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.setenv("PIAD_PROGRAM", PROGRAM)
    code = snippets(page, section)[0].replace("http://127.0.0.1:8080", server.url)
    exec(compile(code, page, "exec"), {})


def test_differences_are_read_as_documented(server: Server, capsys: pytest.CaptureFixture[str]) -> None:
    code = snippets("docs/reference/events.md", "Differences")[0].replace("http://127.0.0.1:8080", server.url)
    program: dict[str, Any] = {}
    exec(compile(code, "docs/reference/events.md", "exec"), program)
    assert len(capsys.readouterr().out.splitlines()) > 3
    with piad.Client(server.url) as client:
        job = next(client.jobs())
        assert np.array_equal(program["points"], job.result().curve.control_points)
        url, deltas = f"{server.url}/v1/jobs/{job.id}/events?encoding=delta", 0
        lines = httpx.get(url, headers={"Accept": "application/x-ndjson"}).text.splitlines()
        events = [json.loads(line)["data"] for line in lines[1:-1]]
        for event, exact in zip(events, job.iterations()):
            assert exact.control_points is not None
            if event["encoding"] == "delta":
                points, deltas = program["moved"](points, event), deltas + 1
                assert np.abs(points - exact.control_points).max() <= event["step"] / 2 + 1e-15
            else:
                width = "<f4" if event["encoding"] == "base64_f32" else "<f8"
                raw = np.frombuffer(base64.b64decode(event["control_points"]), width)
                points = raw.astype(float).reshape(event["shape"])
        assert deltas == len(events) - 2


@pytest.mark.parametrize("section", ["Without a server", "Five minutes", "Many fits at once", "While a point is dragged"])
def test_examples_are_typed(section: str, tmp_path: Path) -> None:
    example = tmp_path / "example.py"
    example.write_text(snippets(CLIENT, section)[0], encoding="utf-8")
    mypy = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path), str(example)]
    environment = {**os.environ, "MYPYPATH": str(ROOT / "clients/python/src")}
    output = subprocess.run(mypy, capture_output=True, text=True, env=environment, cwd=tmp_path, check=False)
    wrong = [line for line in output.stdout.splitlines() if line.startswith(str(example))]
    assert not wrong and output.returncode in (0, 1), output.stdout + output.stderr


METHODS = sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / "docs/explanation/methods").glob("*.md"))
HOW_TO = [f"docs/how-to/{name}.md" for name in ("choose-a-fit", "scans-and-sections", "corners-and-polylines")]


@pytest.mark.parametrize("page", [*METHODS, *HOW_TO, "docs/reference/job.md", "docs/reference/events.md"])
def test_jobs_in_json_converge(page: str, server: Server) -> None:
    blocks = re.findall(r"```json\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.S)
    jobs = [job for job in map(json.loads, blocks) if "curve" in job or "surface" in job]
    assert jobs
    for job in jobs:
        answer = httpx.post(f"{server.url}/v1/jobs", json=job, headers={"Prefer": "wait=60"}, timeout=90)
        assert answer.status_code == 201 and answer.json()["state"] == "converged", answer.text
