"""Fits the examples with `piad fit` and checks all exported files.

    command.py PROGRAM          # such as target/debug/piad

Needs the packages of requirements.txt.
"""

import glob
import json
import os
import shutil
import subprocess
import sys
import tempfile

from over_http import FORMATS, ROOT


def write_all(program: str, folder: str) -> None:
    """Fits every example, with all files at once."""
    for example in sorted(glob.glob(os.path.join(ROOT, "examples", "*.json"))):
        name = os.path.splitext(os.path.basename(example))[0]
        with open(example) as file:
            surface = "surface" in json.load(file)
        endings = [ending for format, ending in FORMATS.items() if format != "stl" or surface]
        shutil.copy(example, os.path.join(folder, f"{name}.job.json"))
        command = [program, "fit", example, "--quiet"]
        for ending in ["result.json", *endings]:
            command += ["-o", os.path.join(folder, f"{name}.{ending}")]
        status = subprocess.run(command).returncode
        # Status 1: the fit is not within the tolerance.
        assert status in (0, 1), (name, status)


def main() -> int:
    check = os.path.join(os.path.dirname(__file__), "export_check.py")
    with tempfile.TemporaryDirectory() as folder:
        write_all(sys.argv[1], folder)
        return subprocess.run([sys.executable, check, "--all", folder]).returncode


if __name__ == "__main__":
    sys.exit(main())
