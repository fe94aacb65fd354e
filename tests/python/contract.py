"""Tests a real server against the description of its API, with requests that schemathesis makes up.

    contract.py PROGRAM [OPTION …]    # the server to start, such as target/debug/piad; options of schemathesis

Needs the packages of requirements.txt; schemathesis.toml says what is tested and how.
"""

import json
import os
import subprocess
import sys
import tempfile

from over_http import fetch, server

HERE = os.path.dirname(os.path.abspath(__file__))
CONFIG = os.path.join(HERE, "schemathesis.toml")

# A job that has all that jobs may have: a result, a limit, a stream of its own.
JOB = {
    "curve": {"points": [[0, 0], [1, 2], [3, 1], [4, 3], [6, 2]]},
    "method": {"kind": "local", "indices": [1, 2]},
}


def main(program: str, *options: str) -> int:
    # Fits that do not converge end soon, so that answers that wait for them come.
    with server(program, "--max-iterations", "1000", "--heartbeat", "1") as base:
        job = json.loads(fetch(f"{base}/v1/jobs", json.dumps(JOB).encode()))
        command = [sys.executable, "-m", "schemathesis.cli", "--config-file", CONFIG, "run", f"{base}/openapi.json", *options]
        # For contract_hooks.py.
        environment = {**os.environ, "PIAD_JOB": job["id"], "PYTHONPATH": HERE}
        with tempfile.TemporaryDirectory() as folder:
            return subprocess.run(command, cwd=folder, env=environment).returncode


if __name__ == "__main__":
    raise SystemExit(main(*sys.argv[1:]))
