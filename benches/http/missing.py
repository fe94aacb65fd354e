"""Measures if the time of a 404 reveals a job of another tenant: requests unknown ids, a recently
ended job of another tenant, and one that is only in the file, interleaved.

    missing.py PROGRAM [--rounds N]      # PROGRAM is target/release/piad
"""

import argparse
import os
import statistics
import subprocess
import tempfile
import time
import uuid

from tenants import Client, curve, started, token


def jobs(client: Client, count: int) -> list[str]:
    """The ids of jobs that have ended."""
    headers, ids = {**client.headers, "Prefer": "wait=10"}, []
    for _ in range(count):
        client.connection.request("POST", "/v1/jobs", curve(100, relative_tolerance=1e-6), headers)
        answer = client.connection.getresponse()
        answer.read()
        assert answer.status in (200, 201), answer.status
        ids.append(answer.headers["Location"].rsplit("/", 1)[1])
    return ids


def like(id: str) -> str:
    """An id with the same time and other random bits."""
    return id[:15] + str(uuid.uuid4())[15:]


def seconds(client: Client, id: str) -> float:
    begin = time.perf_counter()
    client.connection.request("GET", f"/v1/jobs/{id}", headers=client.headers)
    answer = client.connection.getresponse()
    answer.read()
    end = time.perf_counter()
    assert answer.status == 404, answer.status
    return end - begin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("--rounds", type=int, default=2000)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "tokens.toml")
        own, other = (token(arguments.program, file, tenant) for tenant in ("curious", "other"))
        with started(arguments.program, folder, file) as address:
            stored = jobs(Client(address, other), arguments.rounds)
        with started(arguments.program, folder, file) as address:
            recent = jobs(Client(address, other), arguments.rounds)
            client = Client(address, own)
            times: dict[str, list[float]] = {"unknown": [], "another's, recent": [], "another's, in the file": []}
            for ids in zip(map(like, recent), recent, stored):
                for name, id in zip(times, ids):
                    times[name].append(seconds(client, id))
        print("| id | median | p90 | p99 |")
        print("|---|---|---|---|")
        for name, all_ in times.items():
            cuts = statistics.quantiles(all_, n=100)
            print(f"| {name} | {statistics.median(all_) * 1e6:.0f} µs | {cuts[89] * 1e6:.0f} µs | {cuts[98] * 1e6:.0f} µs |")


if __name__ == "__main__":
    main()
