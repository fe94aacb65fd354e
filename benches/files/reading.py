"""How long it takes to read a million points of a CSV file, beside numpy, in turns.

    reading.py PROGRAM        # PROGRAM is target/release/piad

piad's time is that of a whole process that reads the file and then refuses the tolerance -1. Medians of seven.
"""

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROUNDS = 7


def seconds(action) -> float:
    begin = time.perf_counter()
    action()
    return time.perf_counter() - begin


def main() -> None:
    [program] = sys.argv[1:]
    t = np.linspace(0, 60, 1_000_000)
    points = np.c_[(1 + t / 10) * np.cos(t), (1 + t / 10) * np.sin(t), 0.3 * t]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "million.csv"
        np.savetxt(file, points, delimiter=",", header="x,y,z", comments="", fmt="%.17g")

        def refused() -> None:
            command = [program, "fit", file, "-q", "--tolerance", "-1", "-o", Path(folder) / "never.step"]
            done = subprocess.run(command, capture_output=True, text=True)
            assert done.returncode == 2 and "tolerance" in done.stderr, done

        numpy, piad = [], []
        for _ in range(ROUNDS):
            numpy.append(seconds(lambda: np.loadtxt(file, delimiter=",", skiprows=1)))
            piad.append(seconds(refused))
    numpy, piad = statistics.median(numpy), statistics.median(piad)
    print(f"numpy.loadtxt {numpy:.2f} s, piad {piad:.2f} s: {numpy / piad:.1f} times as fast")


if __name__ == "__main__":
    main()
