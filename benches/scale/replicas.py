"""Replicas with one database: jobs a second, what a job costs the database, and how soon a stream begins at a replica
that does not run the job; beside a server with a file of its own.

    PIAD_TEST_FSYNC=on tests/postgres python benches/scale/replicas.py target/release/piad
"""

import http.client
import json
import math
import os
import subprocess
import sys
import tempfile
import threading
import time

PROGRAM = sys.argv[1]
CLUSTER = os.environ["PIAD_TEST_CLUSTER"]
URL = os.environ["PIAD_TEST_DATABASE"]
CLIENTS = 16
SECONDS = 8


def sql(statement):
    """What a statement says."""
    command = ["psql", "-h", CLUSTER, "-U", "piad", "-d", "postgres", "-q", "-t", "-A", "-c", statement]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def job(count, **stop):
    points = [[i / 10, math.sin(i / 10), math.cos(i / 7)] for i in range(count)]
    return json.dumps({"curve": {"points": points}, "stop": stop}).encode()


class Server:
    """A server on a free port."""

    def __init__(self, store):
        command = [PROGRAM, "--listen", "127.0.0.1:0", "--store", store, "--log-format", "json"]
        command += ["--max-jobs-per-peer", "10000", "--max-iterations", "1000000000"]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        for line in self.process.stderr:
            if "listening on" in line:
                self.port = int(line.split("http://127.0.0.1:")[1].split('"')[0])
                break
        threading.Thread(target=self.process.stderr.read, daemon=True).start()

    def connect(self):
        return http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)

    def metric(self, name):
        connection = self.connect()
        connection.request("GET", "/metrics")
        lines = connection.getresponse().read().decode().splitlines()
        return sum(float(line.split()[-1]) for line in lines if line.startswith(name + " "))

    def stop(self):
        self.process.terminate()
        self.process.wait()


def throughput(servers, body):
    """Jobs a second that all clients together see the end of."""
    done = [0] * CLIENTS
    end = time.monotonic() + SECONDS

    def client(index):
        connection = servers[index % len(servers)].connect()
        headers = {"content-type": "application/json", "prefer": "wait=30"}
        while time.monotonic() < end:
            connection.request("POST", "/v1/jobs", body, headers)
            answer = connection.getresponse()
            text = answer.read()
            assert answer.status == 201, text
            assert json.loads(text)["state"] == "converged", text
            done[index] += 1

    clients = [threading.Thread(target=client, args=(index,)) for index in range(CLIENTS)]
    for thread in clients:
        thread.start()
    for thread in clients:
        thread.join()
    return sum(done) / SECONDS, sum(done)


def first_event(server, path, after):
    """Seconds until the first iteration of a stream is there."""
    connection = server.connect()
    begin = time.monotonic()
    connection.request("GET", path + "/events?view=errors", headers={"last-event-id": after} if after else {})
    answer = connection.getresponse()
    assert answer.status == 200
    while True:
        line = answer.readline()
        if line.startswith(b"event: iteration") or line.startswith(b"id: "):
            return time.monotonic() - begin


def processor():
    """Seconds of processor time that the database has taken."""
    with open(f"{CLUSTER}/data/postmaster.pid") as file:
        main = file.readline().strip()
    ticks = 0
    for pid in os.listdir("/proc"):
        try:
            with open(f"/proc/{pid}/stat") as file:
                fields = file.read().rsplit(") ", 1)[1].split()
        except (OSError, IndexError):
            continue
        # Of children that have ended the first process knows.
        ticks += sum(map(int, fields[11:15])) if pid == main else sum(map(int, fields[11:13])) if fields[1] == main else 0
    return ticks / os.sysconf("SC_CLK_TCK")


def database():
    row = sql("SELECT xact_commit, (SELECT wal_bytes FROM pg_stat_wal) FROM pg_stat_database WHERE datname = 'postgres'")
    return [*(float(value) for value in row.split("|")), processor()]


def streams(count):
    """A stream at the replica that runs a job, and at the other one."""
    sql("DROP SCHEMA IF EXISTS streams CASCADE; CREATE SCHEMA streams")
    servers = [Server(f"{URL}&options[search_path]=streams") for _ in range(2)]
    here, there = [], []
    for _ in range(10):
        connection = servers[0].connect()
        connection.request("POST", "/v1/jobs", job(count, tolerance=0, max_iterations=1_000_000_000),
                           {"content-type": "application/json"})
        path = json.loads(connection.getresponse().read())["links"]["self"]
        there.append(first_event(servers[1], path, None))
        here.append(first_event(servers[0], path, None))
        connection.request("DELETE", path)
        connection.getresponse().read()
    for server in servers:
        server.stop()
    median = lambda times: 1000 * sorted(times)[len(times) // 2]
    print(f"first iteration of {count} points: {median(here):.1f} ms at its replica, {median(there):.1f} ms at another")


def main():
    body = job(100, relative_tolerance=1e-6, max_iterations=1000)
    print(f"{CLIENTS} clients, jobs of 100 points, {os.cpu_count()} cores for clients, replicas and database together")
    with tempfile.TemporaryDirectory() as directory:
        server = Server(directory)
        throughput([server], body)
        print(f"a file: {throughput([server], body)[0]:.0f} jobs/s")
        server.stop()
    for replicas in (1, 2, 3):
        schema = f"scale_{replicas}"
        sql(f"CREATE SCHEMA {schema}")
        servers = [Server(f"{URL}&options[search_path]={schema}") for _ in range(replicas)]
        throughput(servers, body)
        time.sleep(2)
        counted = lambda: [*database(), sum(server.metric("piad_store_statements_total") for server in servers)]
        before = counted()
        rate, jobs = throughput(servers, body)
        time.sleep(2)
        commits, wal, seconds, statements = (b - a for a, b in zip(before, counted()))
        print(f"{replicas} replicas: {rate:.0f} jobs/s; a job: {statements / jobs:.2f} statements, {commits / jobs:.2f} commits, "
              f"{wal / jobs / 1024:.1f} KiB of log, {1000 * seconds / jobs:.2f} ms of processor time of the database")
        before = counted()
        time.sleep(SECONDS)
        commits, wal, seconds, statements = (b - a for a, b in zip(before, counted()))
        each = SECONDS * replicas
        print(f"    with nothing to do, a replica: {statements / each:.1f} statements/s, {1000 * seconds / each:.2f} ms/s of the database")
        for server in servers:
            server.stop()
    for count in (100, 100_000):
        streams(count)


main()
