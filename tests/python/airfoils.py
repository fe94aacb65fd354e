"""Fits all UIUC airfoils of the package aerosandbox with `piad fit`: counts and reasons.

    tests/python/airfoils.py PROGRAM    # such as target/release/piad

Each file is fitted, or rejected with its name, the line and the reason; anything else fails the
script. The wheel is downloaded and read as a zip file, without installing it. Needs pip.
"""

import collections
import io
import re
import subprocess
import sys
import tempfile
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

WHEEL = "aerosandbox==4.2.9"


def unpack(folder: Path) -> list[Path]:
    subprocess.run([sys.executable, "-m", "pip", "download", "-q", "--no-deps", "-d", folder, WHEEL], check=True)
    [wheel] = folder.glob("*.whl")
    archive = zipfile.ZipFile(io.BytesIO(wheel.read_bytes()))
    names = [name for name in archive.namelist() if name.endswith(".dat")]
    archive.extractall(folder, names)
    return sorted(folder / name for name in names)


def fit(program: str, file: Path) -> tuple[Path, int, str]:
    command = [program, "fit", file, "--format", "csv", "--quiet"]
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=60)
    return file, done.returncode, done.stderr.decode()


def main() -> None:
    program = sys.argv[1]
    reasons, wrong = collections.Counter(), []
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as pool:
        files = unpack(Path(folder))
        for file, status, output in pool.map(lambda file: fit(program, file), files):
            if status == 0:
                reasons["fitted"] += 1
            elif status == 1 and not output:
                reasons["fitted, not within the tolerance"] += 1
            elif status == 2 and re.match(re.escape(str(file)) + r":\d+: ", output):
                reason = output.splitlines()[0].split(": ", 1)[1]
                reasons["refused: " + re.sub(r'"[^"]*"|\d+', "…", reason)] += 1
                if "-v" in sys.argv:
                    print(f"{file.name}{output[len(str(file)):].rstrip()}")
            else:
                wrong.append(f"{file.name}: {status} {output}")
    print(f"{len(files)} files")
    for reason, count in reasons.most_common():
        print(f"{count:6} {reason}")
    if wrong:
        sys.exit("\n".join(wrong))


if __name__ == "__main__":
    main()
