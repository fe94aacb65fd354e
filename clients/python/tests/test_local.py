"""Fits without the URL of a server: one is started for the process, and ends with it."""

from __future__ import annotations

import asyncio
import inspect
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import PROGRAM, ROOT, Server
from shapes import CURVE, SURFACE

import piad
from piad import _local

POINTS = [[i, (i % 20) ** 2] for i in range(60)]

# What each program begins with: a fit, and the process of its server.
BEGIN = """
import os, sys, time, piad
from piad import _local
result = piad.fit([[0, 0], [1, 2], [3, 1], [4, 3]])
assert result.state == "converged"
print(_local._server._process.pid, flush=True)
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The folder of the sockets, in which nothing is left."""
    for name in ("PIAD_URL", "PIAD_TOKEN"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("PIAD_PROGRAM", PROGRAM)
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    monkeypatch.setenv("TMPDIR", str(folder))
    yield folder
    _local._stop()
    within(2, lambda: not list(folder.iterdir()))


def within(seconds: float, is_so: Callable[[], bool]) -> None:
    end = time.monotonic() + seconds
    while not is_so():
        assert time.monotonic() < end, f"not within {seconds} s"
        time.sleep(0.01)


def start(program: str, **more: str) -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "clients/python/src"), **more}
    command = [sys.executable, "-W", "error", "-c", program]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stdin=subprocess.PIPE, text=True, env=environment)


def line(program: subprocess.Popen[str]) -> str:
    assert program.stdout is not None
    return program.stdout.readline().strip()


def is_running(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def test_a_server_is_started_once_and_shared() -> None:
    started = time.monotonic()
    result = piad.fit(POINTS, tolerance=20, control_points="auto", corners="auto", degree=3, method="least_squares")
    print(f"the first fit: {time.monotonic() - started:.3f} s")
    assert result.state == "converged" and len(result.curve.control_points) < 60
    server = _local._server
    assert piad.fit(SURFACE).surface.dimension == 3 and _local._server is server
    with piad.Client() as client:
        job = client.create(CURVE)
        assert [it.number for it in job.iterations()][:2] == [0, 1]
        assert _local._server is server

    async def count() -> int:
        async with piad.AsyncClient() as client:
            return len(list((await client.fit(CURVE)).curve.knots))

    assert asyncio.run(count()) == len(piad.fit(CURVE).curve.knots)


def test_it_starts_quickly() -> None:
    """Fastest of five. The program of the suite is a debug build."""
    times = []
    for _ in range(5):
        started = time.monotonic()
        _local.local_socket()
        times.append(time.monotonic() - started)
        _local._stop()
    print("started in", [f"{seconds:.3f}" for seconds in times])
    assert min(times) < 0.5


def test_files(tmp_path: Path) -> None:
    file = tmp_path / "wing.dat"
    file.write_text("NACA 2412\n1 0.0013\n0.5 0.0724\n0 0\n0.5 -0.0334\n1 -0.0013\n", encoding="utf-8")
    for where in (file, str(file), file.read_bytes(), file.read_text(encoding="utf-8")):
        assert (piad.read(where).name, len(piad.read(where).points)) == ("NACA 2412", 5)
    assert piad.fit_file(str(file), tolerance=1e-9, degree=2).curve.degree == 2
    assert piad.read("[[0, 0], [1, 1], [2, 0]]").points.tolist() == [[0, 0], [1, 1], [2, 0]]
    with pytest.raises(FileNotFoundError, match="nowhere.dat"):
        piad.read("nowhere.dat")


def test_errors_name_what_was_called() -> None:
    unknown: Any = {"degre": 3}
    for call, name in ((piad.fit, "fit"), (piad.fit_file, "fit_file"), (piad.read, "read")):
        with pytest.raises(TypeError, match=rf"^{name}\(\) got an unexpected keyword argument 'degre'"):
            call(CURVE, **unknown)
    with pytest.raises(piad.ApiError, match="422"):
        piad.fit([[0, 0], [1, 1], [1, 1], [2, 0]])
    with pytest.warns(piad.NotConverged) as caught:
        piad.fit(POINTS, tolerance=1e-12, max_iterations=1, method="global")
    assert caught[0].filename == __file__


def test_results_are_shown_and_written(tmp_path: Path) -> None:
    result = piad.fit(CURVE)
    for shown in (result, result.curve, piad.fit(SURFACE).surface, piad.fit([[0.0], [1.0], [4.0]]).curve):
        html = shown._repr_html_()
        assert html.startswith("<div>&lt;piad.") and "<polyline points=" in html and html.endswith("</svg>")
        assert "nan" not in html and len(html) < 60_000
    step = result.curve.to_step(tmp_path / "a.step", units="m")
    assert step.read_text(encoding="utf-8").startswith("ISO-10303-21;")
    assert "<svg" in result.curve.to_svg(tmp_path / "a.svg").read_text(encoding="utf-8")
    copied = pickle.loads(pickle.dumps(result)).curve
    assert np.array_equal(copied.control_points, result.curve.control_points)
    for other in (copied, result.curve.derivative()):
        with pytest.raises(ValueError, match=r"job\.download"):
            other.to_step(tmp_path / "b.step")
    assert result.curve.plot(net=False, color="red").lines


def test_other_servers(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    with piad.Client(server.url) as client:
        for fit in (lambda: piad.fit(CURVE, url=server.url), lambda: piad.Client().fit(CURVE)):
            assert client.job(fit().id).status.state == "converged"
            monkeypatch.setenv("PIAD_URL", server.url)
        assert client.job(piad.fit(CURVE).id).id
    assert _local._server is None
    # The token is that of another server.
    monkeypatch.delenv("PIAD_URL")
    monkeypatch.setenv("PIAD_TOKEN", "x")
    assert piad.fit(CURVE).state == "converged"


def test_a_server_that_has_ended_is_replaced() -> None:
    piad.fit(CURVE)
    assert _local._server is not None
    ended = _local._server
    os.kill(ended._process.pid, signal.SIGKILL)
    ended._process.wait()
    assert piad.fit(CURVE).state == "converged" and _local._server is not ended


@pytest.mark.parametrize("way", ["end", "kill", "busy"])
def test_it_ends_with_its_program(way: str, folder: Path) -> None:
    more = "piad.Client().create([[i, i * i % 7] for i in range(20000)], max_iterations=1000000, tolerance=1e-300)\n"
    program = start(BEGIN + (more if way == "busy" else "") + "print('ready', flush=True)\nsys.stdin.read()\n")
    process = int(line(program))
    assert line(program) == "ready" and is_running(process)
    assert [it.stat().st_mode & 0o777 for it in folder.iterdir()] == [0o700]
    if way == "end":
        program.communicate("", timeout=10)
        assert program.returncode == 0
    else:
        program.kill()
        program.communicate()
    killed = time.monotonic()
    within(2, lambda: not is_running(process))
    print(f"{way}: the server has ended after {time.monotonic() - killed:.3f} s")


def test_two_programs_have_a_server_each() -> None:
    programs = [start(BEGIN + "sys.stdin.read()\nassert piad.fit([[0, 0], [1, 1]], degree=1).state\n") for _ in range(2)]
    first, second = (int(line(program)) for program in programs)
    assert first != second
    programs[0].kill()
    programs[0].communicate()
    within(2, lambda: not is_running(first))
    assert is_running(second)
    programs[1].communicate("", timeout=10)
    assert programs[1].returncode == 0


def test_a_forked_process_starts_its_own() -> None:
    forking = """
import warnings
child = os.fork()
if child == 0:
    assert piad.fit([[0, 0], [1, 1], [2, 4]]).state == "converged"
    print(_local._server._process.pid, flush=True)
    sys.stdin.read()
    os._exit(0)
line = os.read(0, 1)
assert piad.fit([[0, 0], [1, 1], [2, 4]]).state == "converged"
print("parent", flush=True)
os.kill(os.getpid(), 9)
"""
    program = start(BEGIN + forking)
    first, second = int(line(program)), int(line(program))
    assert first != second
    assert program.stdin is not None
    program.stdin.write("x")
    program.stdin.flush()
    assert line(program) == "parent"
    # The child holds nothing of the first server.
    within(2, lambda: not is_running(first))
    assert is_running(second)
    program.stdin.close()
    within(2, lambda: not is_running(second))
    program.wait()


def test_interrupts_of_the_terminal_do_not_end_it() -> None:
    program = start(BEGIN + "sys.stdin.read()\n")
    process = int(line(program))
    assert os.getsid(process) != os.getsid(program.pid)
    program.communicate("", timeout=10)


@pytest.mark.parametrize(
    ("variable", "expected"), [("", "make wheel.*PIAD_PROGRAM.*PIAD_URL"), ("/nowhere", "PIAD_PROGRAM is '/nowhere'")]
)
def test_without_the_program(variable: str, expected: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PIAD_PROGRAM", variable)
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(piad.ServerNotStarted, match=expected):
        piad.fit(CURVE)


def test_a_program_that_does_not_start_is_quoted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = tmp_path / "piad"
    script.write_text("#!/bin/sh\necho 'too old' >&2\nexit 2\n", encoding="utf-8")
    script.chmod(0o700)
    monkeypatch.setenv("PIAD_PROGRAM", "")
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    with pytest.raises(piad.ServerNotStarted, match=f"{script} has not started a server: too old"):
        piad.fit(CURVE)


def test_completions_have_public_names_only() -> None:
    assert dir(piad) == sorted(piad.__all__)
    assert "degree" in str(inspect.signature(piad.fit))
