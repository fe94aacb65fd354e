"""The wheel with the program, installed where nothing else is, and used as the README says."""

from __future__ import annotations

import os
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest
from conftest import PROGRAM, ROOT
from test_documentation import CLIENT, snippets
from test_local import is_running, within

import piad


class Environment:
    """A virtual environment with the wheel; programs run in it with nothing else in reach."""

    def __init__(self, folder: Path, wheel: Path):
        self.bin, self.home = folder / "venv" / "bin", folder / "home"
        self.home.mkdir()
        self._variables = {"PATH": "/usr/bin:/bin", "HOME": str(self.home), "TMPDIR": str(self.home)}
        self.run(sys.executable, "-m", "venv", str(folder / "venv"))
        # The registry is that of this machine.
        pip = {**os.environ, **self._variables}
        command = [self.bin / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", str(wheel)]
        subprocess.run(command, env=pip, check=True)

    def start(self, *command: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            command, cwd=self.home, env=self._variables, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def run(self, *command: str) -> str:
        started = self.start(*command)
        output, _ = started.communicate("", timeout=120)
        assert started.returncode == 0, command
        return output


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    script = ROOT / "clients/python/wheel"
    environment = {**os.environ, "PYTHON": sys.executable}
    made = subprocess.run([script, PROGRAM, str(folder)], capture_output=True, text=True, env=environment, check=False)
    assert made.returncode == 0, made.stderr
    return Path(made.stdout.strip())


@pytest.fixture(scope="module")
def environment(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Environment:
    return Environment(tmp_path_factory.mktemp("environment"), wheel)


def test_the_wheel_is_for_a_platform_and_has_the_program(wheel: Path) -> None:
    assert wheel.name.startswith(f"piad-{piad.__version__}-py3-none-linux_")
    names = zipfile.ZipFile(wheel).namelist()
    assert f"piad-{piad.__version__}.data/scripts/piad" in names
    assert {"piad/__init__.py", "piad/py.typed", "piad/LICENSE-MIT", "piad/LICENSE-APACHE"} <= set(names)
    assert not [name for name in names if "test" in name]


def test_one_installation_has_the_client_and_the_program(environment: Environment) -> None:
    assert environment.run(str(environment.bin / "piad"), "--version").startswith(f"piad {piad.__version__}")
    where = environment.run(str(environment.bin / "python"), "-c", "from piad._program import find_program as f; print(f())")
    assert Path(where.strip()) == environment.bin / "piad"
    assert environment.run(str(environment.bin / "python"), "-c", "import piad; print(piad.__version__)").strip() == piad.__version__


def test_the_first_lines_of_the_readme_work(environment: Environment) -> None:
    for page, section in (("README.md", "From Python and CAD"), (CLIENT, "Without a server")):
        output = environment.run(str(environment.bin / "python"), "-W", "error", "-c", snippets(page, section)[0])
        assert output
    assert (environment.home / "curve.step").read_text(encoding="utf-8").startswith("ISO-10303-21;")
    assert "<svg" in (environment.home / "curve.svg").read_text(encoding="utf-8")


def test_servers_end_with_their_programs(environment: Environment) -> None:
    code = "import sys, piad, piad._local as it; piad.fit([[0, 0], [1, 2], [3, 1], [4, 3]]); print(it._server._process.pid, flush=True); sys.stdin.read()"
    programs = [environment.start(str(environment.bin / "python"), "-c", code) for _ in range(2)]
    servers = [int((program.stdout or sys.stdin).readline()) for program in programs]
    assert servers[0] != servers[1]
    programs[0].kill()
    killed = time.monotonic()
    within(2, lambda: not is_running(servers[0]))
    print(f"ended {time.monotonic() - killed:.3f} s after it was killed")
    assert is_running(servers[1])
    programs[0].communicate()
    programs[1].communicate("", timeout=10)
    assert programs[1].returncode == 0
    within(2, lambda: not is_running(servers[1]))
    assert not list(environment.home.glob("piad-*"))
