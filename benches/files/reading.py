"""Measures reading a million points of a table and a binary PLY file, compared with numpy and
trimesh, interleaved.

    reading.py PROGRAM        # PROGRAM is target/release/piad

piad's time is that of a whole process that reads the file and then rejects it: the table because of
the tolerance -1, the cloud because it is unordered, which is checked for all points. The others are
called in a process that has loaded them. Medians of seven, with minimum and maximum. Needs the
packages of ../requirements.txt.
"""

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import trimesh

ROUNDS = 7


def seconds(action) -> float:
    begin = time.perf_counter()
    action()
    return time.perf_counter() - begin


def refused(program: str, file: Path, why: str) -> None:
    command = [program, "fit", file, "-q", "--tolerance", "-1", "-o", file.with_suffix(".step")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2 and why in done.stderr, done


def report(name: str, readers: dict) -> None:
    taken: dict[str, list[float]] = {reader: [] for reader in readers}
    for _ in range(ROUNDS):
        for reader, action in readers.items():
            taken[reader].append(seconds(action))
    piad = statistics.median(taken["piad"])
    for reader, each in taken.items():
        middle = statistics.median(each)
        print(f"| {name} | {reader} | {middle:.2f} ({min(each):.2f}–{max(each):.2f}) | {middle / piad:.1f} |", flush=True)


def main() -> None:
    [program] = sys.argv[1:]
    t = np.linspace(0, 60, 1_000_000)
    points = np.c_[(1 + t / 10) * np.cos(t), (1 + t / 10) * np.sin(t), 0.3 * t]
    print("| file | read by | s | of piad's |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "million.csv"
        np.savetxt(table, points, delimiter=",", header="x,y,z", comments="", fmt="%.17g")
        report("table", {
            "numpy.loadtxt": lambda: np.loadtxt(table, delimiter=",", skiprows=1),
            "numpy.genfromtxt": lambda: np.genfromtxt(table, delimiter=",", skip_header=1),
            "piad": lambda: refused(program, table, "tolerance"),
        })
        cloud = Path(folder) / "million.ply"
        mixed = np.random.default_rng(1).permutation(points)
        head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(mixed)}\n"
        head += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
        cloud.write_bytes(head.encode() + mixed.astype("<f8").tobytes())
        report("PLY", {
            "trimesh.load": lambda: trimesh.load(cloud),
            "piad": lambda: refused(program, cloud, "order"),
        })


if __name__ == "__main__":
    main()
