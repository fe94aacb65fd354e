"""Measures the memory for reading large files, and for files that only claim to be large.

    memory.py PROGRAM [--megabytes 100]        # PROGRAM is target/release/piad

Each file is read by `piad fit` in a separate process, which then rejects it: clouds because they
are unordered, all others because of the tolerance -1. The claims are files of some hundred bytes
whose headers announce thousands of millions of points. Needs the packages of ../requirements.txt.
"""

import argparse
import os
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterator

import numpy as np

BLOCK = 100_000
CLAIMED = 4_000_000_000
# The memory limit when rejecting a claim.
MOST_OF_CLAIMS = 64


def points(start: int, count: int = BLOCK) -> np.ndarray:
    """Some points of a long rippled spiral in space."""
    t = np.arange(start, start + count) * 1e-4
    return np.stack([(1 + t) * np.cos(t), (1 + t) * np.sin(t), 0.3 * t + 0.01 * np.sin(9 * t)], axis=1)


def rows(start: int, form: str) -> bytes:
    return ("\n".join(form.format(*point) for point in points(start).tolist()) + "\n").encode()


def blocks(size: int, begin: bytes, block, end: bytes = b"") -> Iterator[bytes]:
    """A file of about this size from blocks, each of which gets the number of preceding points."""
    written, start = len(begin), 0
    yield begin
    while written < size:
        part = block(start)
        yield part
        written, start = written + len(part), start + BLOCK
    yield end


def counted(size: int, each: int) -> int:
    """The number of points in full blocks of a binary file."""
    return -(-size // (BLOCK * each)) * BLOCK


def csv(size: int) -> Iterator[bytes]:
    return blocks(size, b"x,y,z\n", lambda start: rows(start, "{!r},{!r},{!r}"))


def ply(size: int) -> Iterator[bytes]:
    count = counted(size, 24)
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {count}\n"
    head += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
    return blocks(count * 24, head.encode(), lambda start: points(start).astype("<f8").tobytes())


def stl(size: int) -> Iterator[bytes]:
    """Strips of triangles along the spiral."""
    count = counted(size, 50)
    kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])

    def block(start: int) -> bytes:
        triangles = np.zeros(BLOCK, kind)
        line = points(start, BLOCK + 2)
        triangles["corners"] = np.stack([line[:-2], line[1:-1], line[2:]], axis=1)
        return triangles.tobytes()

    return blocks(84 + count * 50, b"\0" * 80 + struct.pack("<I", count), block)


def obj(size: int) -> Iterator[bytes]:
    return blocks(size, b"# a cloud\n", lambda start: rows(start, "v {!r} {!r} {!r}"))


def las(size: int, claimed: int | None = None) -> Iterator[bytes]:
    """Version 1.2, points of format 0."""
    count = counted(size, 20)
    numbers = claimed or count
    head = struct.pack("<4sHHIHH8sBB32s32sHHHIIBHI5I", b"LASF", 0, 0, 0, 0, 0, b"", 1, 2, b"", b"", 1, 2024, 227, 227, 0, 0, 20, numbers, numbers, 0, 0, 0, 0)
    head += struct.pack("<12d", 1e-3, 1e-3, 1e-3, 0, 0, 0, 1e5, -1e5, 1e5, -1e5, 1e5, -1e5)
    kind = np.dtype([("place", "<i4", 3), ("more", "u1", 8)])

    def block(start: int) -> bytes:
        records = np.zeros(BLOCK, kind)
        records["place"] = (points(start) * 1000).round()
        return records.tobytes()

    return blocks(227 + count * 20, head, block)


def pcd(size: int, claimed: int | None = None) -> Iterator[bytes]:
    count = counted(size, 12)
    head = "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
    head += f"WIDTH {claimed or count}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {claimed or count}\nDATA binary\n"
    return blocks(count * 12, head.encode(), lambda start: points(start).astype("<f4").tobytes())


def geojson(size: int) -> Iterator[bytes]:
    """Lines of 1000 points, with coordinates that are no degrees."""
    begin = b'{"type": "FeatureCollection", "features": ['
    line = '{{"type": "Feature", "properties": {{"name": "{}"}}, "geometry": {{"type": "LineString", "coordinates": {}}}}}'

    def block(start: int) -> bytes:
        all_ = (1000 + points(start)[:, :2]).tolist()
        lines = (line.format(start + i, all_[i : i + 1000]) for i in range(0, BLOCK, 1000))
        return ((", " if start else "") + ", ".join(lines)).encode()

    return blocks(size, begin, block, b"]}")


def dxf(size: int) -> Iterator[bytes]:
    def block(start: int) -> bytes:
        head = f"  0\nLWPOLYLINE\n  8\nlayer{start}\n 90\n{BLOCK}\n 70\n0\n"
        return head.encode() + rows(start, " 10\n{!r}\n 20\n{!r}")

    return blocks(size, b"  0\nSECTION\n  2\nENTITIES\n", block, b"  0\nENDSEC\n  0\nEOF\n")


def svg(size: int) -> Iterator[bytes]:
    begin = b'<svg xmlns="http://www.w3.org/2000/svg">\n'
    return blocks(size, begin, lambda start: b'<polyline points="' + rows(start, "{!r},{!r}") + b'"/>\n', b"</svg>\n")


def gcode(size: int) -> Iterator[bytes]:
    return blocks(size, b"G21 G90\nG0 X1 Y0\n", lambda start: rows(start, "G1 X{:.6f} Y{:.6f} Z{:.6f}"))


def esri(size: int) -> Iterator[bytes]:
    columns = 1000
    lines = size // (columns * 19)
    head = f"ncols {columns}\nnrows {lines}\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -9999\n"
    yield head.encode()
    for row in range(lines):
        heights = 100 + np.sin(np.arange(columns) / 50 + row / 70)
        yield (" ".join(map(repr, heights.tolist())) + "\n").encode()


def gpx(size: int) -> Iterator[bytes]:
    def block(start: int) -> bytes:
        degrees = [11, 48, 0] + points(start) * [1e-4, 1e-4, 1]
        text = "".join(f'<trkpt lat="{y!r}" lon="{x!r}"><ele>{z!r}</ele></trkpt>\n' for x, y, z in degrees.tolist())
        return f"<trk><name>{start}</name><trkseg>\n{text}</trkseg></trk>\n".encode()

    begin = b'<gpx version="1.1" creator="x" xmlns="http://www.topografix.com/GPX/1/1">\n'
    return blocks(size, begin, block, b"</gpx>\n")


FORMATS = {
    "csv": csv,
    "ply": ply,
    "stl": stl,
    "obj": obj,
    "las": las,
    "pcd": pcd,
    "geojson": geojson,
    "gpx": gpx,
    "dxf": dxf,
    "svg": svg,
    "nc": gcode,
    "asc": esri,
}

CLAIMS = {
    "ply": f"ply\nformat binary_little_endian 1.0\nelement vertex {CLAIMED}\nproperty double x\nproperty double y\nproperty double z\nend_header\n".encode() + bytes(240),
    "ply with lists": f"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\nelement face {CLAIMED}\nproperty list uint int vertex_indices\nend_header\n".encode() + bytes(72) + struct.pack("<I", CLAIMED),
    "stl": b"\0" * 80 + struct.pack("<I", CLAIMED) + bytes(100),
    "las": b"".join(las(1, CLAIMED))[:327],
    "pcd": b"".join(pcd(1, CLAIMED))[:300],
    "pcd, compressed": f"VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {CLAIMED}\nHEIGHT 1\nPOINTS {CLAIMED}\nDATA binary_compressed\n".encode() + struct.pack("<II", 40, CLAIMED) + bytes(40),
    "off": f"OFF\n{CLAIMED} {CLAIMED} 0\n0 0 0\n1 0 0\n0 1 0\n".encode(),
    "pts": f"{CLAIMED}\n0 0 0\n1 0 0\n0 1 0\n".encode(),
    "asc": f"ncols {CLAIMED}\nnrows {CLAIMED}\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n4 5 6\n".encode(),
    "dxf": f"  0\nSECTION\n  2\nENTITIES\n  0\nSPLINE\n 70\n8\n 71\n3\n 72\n{CLAIMED}\n 73\n{CLAIMED}\n 10\n0\n 20\n0\n  0\nENDSEC\n  0\nEOF\n".encode(),
}


# A process inherits the peak size of its parent: this one is small.
STARTER = """
import os, sys, time
begin = time.perf_counter()
process = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ)
_, status, used = os.wait4(process, 0)
print(time.perf_counter() - begin, used.ru_maxrss / 1024, os.waitstatus_to_exitcode(status))
"""


def read(program: str, path: str) -> tuple[float, float, int, str]:
    """Seconds, peak MiB, status and the last line of a process that reads a file."""
    command = [program, "fit", path, "-q", "--tolerance", "-1", "-o", f"{path}.step"]
    done = subprocess.run([sys.executable, "-S", "-E", "-c", STARTER, *command], capture_output=True, text=True, check=True)
    seconds, peak, status = done.stdout.split()
    lines = done.stderr.strip().splitlines()
    return float(seconds), float(peak), int(status), lines[-1] if lines else ""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("--megabytes", type=int, default=100)
    parser.add_argument("--only", nargs="+", default=list(FORMATS))
    given = parser.parse_args()
    print("| format | file, MB | peak, MiB | per byte of the file | s | ends with |\n|---|---|---|---|---|---|")
    for ending in given.only:
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, f"large.{ending}")
            with open(path, "wb") as file:
                for part in FORMATS[ending](given.megabytes * 1_000_000):
                    file.write(part)
            size = os.path.getsize(path)
            seconds, peak, status, line = read(given.program, path)
            # Each part of a file with several is rejected separately.
            assert status in (1, 2), (ending, status, line)
            print(f"| {ending} | {size / 1e6:.0f} | {peak:.0f} | {peak * 2**20 / size:.1f} | {seconds:.2f} | {line.removeprefix(path)[:90]} |", flush=True)
    print("\n| claims of | peak, MiB | s | ends with |\n|---|---|---|---|")
    for name, content in CLAIMS.items():
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, f"claim.{name.split(',')[0].split()[0]}")
            with open(path, "wb") as file:
                file.write(content)
            seconds, peak, status, line = read(given.program, path)
            print(f"| {name} | {peak:.0f} | {seconds:.2f} | {line.removeprefix(path)[:90]} |", flush=True)
            assert status in (1, 2) and peak < MOST_OF_CLAIMS, (name, status, peak)


if __name__ == "__main__":
    sys.exit(main())
