"""Tries an archive of `make dist`: its checksum, its files, and its program in a root that has nothing else.

    dist.py ARCHIVE [COMMIT]         # needs root, or namespaces of users
"""

import hashlib
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
from pathlib import Path

ARCHIVE = Path(sys.argv[1])
COMMIT = sys.argv[2] if len(sys.argv) > 2 else ""
POINTS = Path(__file__).parents[2] / "examples" / "naca2412.dat"
SHELLS = {f"completions/piad.{shell}" for shell in ("bash", "elvish", "fish", "powershell", "zsh")}
PAGES = {f"man/piad{command}.1" for command in ("", "-config", "-fit", "-health", "-serve", "-store", "-token")}
FILES = {"piad", "README.md", "CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT", *SHELLS, *PAGES}


def unpack(folder: str) -> Path:
    """The folder of the archive, whose files are complete."""
    said = ARCHIVE.with_name(f"{ARCHIVE.name}.sha256").read_text(encoding="utf-8")
    assert said == f"{hashlib.sha256(ARCHIVE.read_bytes()).hexdigest()}  {ARCHIVE.name}\n", said
    with tarfile.open(ARCHIVE) as archive:
        archive.extractall(folder, filter="data")
    (root,) = Path(folder).iterdir()
    assert root.name == ARCHIVE.name.removesuffix(".tar.gz"), root
    found = {str(path.relative_to(root)) for path in root.rglob("*") if path.is_file()}
    assert found == FILES, found ^ FILES
    assert all((root / name).stat().st_size > 500 for name in FILES)
    return root


def in_root(root: Path, *command: str) -> list[str]:
    """A command with this folder as the root: the file system has nothing else."""
    enter = [] if os.geteuid() == 0 else [shutil.which("unshare") or "unshare", "--user", "--map-root-user"]
    return ["env", "-i", *enter, shutil.which("chroot") or "/usr/sbin/chroot", str(root), *command]


def run(root: Path, *command: str) -> str:
    done = subprocess.run(in_root(root, *command), capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout


def serve(root: Path) -> float:
    """Seconds until a server is ready; it ends with its standard input."""
    place = "unix:/run/piad.sock"
    command = in_root(root, "/piad", "--listen", place, "--store", "/data", "--exit-with-stdin")
    started = time.monotonic()
    server = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL)
    while subprocess.run(in_root(root, "/piad", "health", "--listen", place), capture_output=True).returncode != 0:
        assert server.poll() is None and time.monotonic() < started + 30
        time.sleep(0.01)
    ready = time.monotonic() - started
    assert server.stdin
    server.stdin.close()
    assert server.wait(10) == 0
    return ready


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        root = unpack(folder)
        version = run(root, "/piad", "--version")
        assert version.startswith(f"piad {ARCHIVE.name.split('-')[1]}") and COMMIT in version, version
        shutil.copy(POINTS, root / "wing.dat")
        run(root, "/piad", "fit", "wing.dat", "-o", "wing.step")
        assert (root / "wing.step").read_text(encoding="utf-8").startswith("ISO-10303-21;")
        ready = serve(root)
        size = (root / "piad").stat().st_size
    print(f"{version.strip()}: {ARCHIVE.stat().st_size / 1e6:.1f} MB, the program {size / 1e6:.1f} MB, ready after {ready:.2f} s")


main()
