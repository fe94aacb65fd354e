"""Measures replicas with one database: jobs per second, the database cost of a job, and the start
time of a stream at a replica that does not run the job; compared with a server with a file.

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
    """The result of a statement."""
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


def throughput(servers, body, elsewhere=False):
    """Completed jobs per second of all clients together, each watched at its replica or at the next
    one."""
    done = [0] * CLIENTS
    end = time.monotonic() + SECONDS

    def answer(connection, *request):
        connection.request(*request)
        answer = connection.getresponse()
        text = answer.read()
        assert answer.status in (200, 201), text
        return text

    def client(index):
        connection, other = (servers[(index + step) % len(servers)].connect() for step in (0, 1))
        headers = {"content-type": "application/json"} if elsewhere else {"content-type": "application/json", "prefer": "wait=30"}
        while time.monotonic() < end:
            text = answer(connection, "POST", "/v1/jobs", body, headers)
            if elsewhere:
                text = answer(other, "GET", json.loads(text)["links"]["self"] + "/events?view=errors")
            assert b'"state":"converged"' in text, text
            done[index] += 1

    clients = [threading.Thread(target=client, args=(index,)) for index in range(CLIENTS)]
    for thread in clients:
        thread.start()
    for thread in clients:
        thread.join()
    return sum(done) / SECONDS, sum(done)


def first_event(server, path, after):
    """Seconds until the first iteration of a stream."""
    connection = server.connect()
    begin = time.monotonic()
    connection.request("GET", path + "/events?view=errors", headers={"last-event-id": after} if after else {})
    answer = connection.getresponse()
    assert answer.status == 200
    while True:
        line = answer.readline()
        if line.startswith(b"event: iteration") or line.startswith(b"id: "):
            return time.monotonic() - begin


def processor(main):
    """Seconds of processor time that a process and its children have taken."""
    ticks = 0
    for pid in os.listdir("/proc"):
        try:
            with open(f"/proc/{pid}/stat") as file:
                fields = file.read().rsplit(") ", 1)[1].split()
        except (OSError, IndexError):
            continue
        # The parent process counts ended children.
        if pid == main:
            ticks += sum(map(int, fields[11:15]))
        elif fields[1] == main:
            ticks += sum(map(int, fields[11:13]))
    return ticks / os.sysconf("SC_CLK_TCK")


def postgres():
    with open(f"{CLUSTER}/data/postmaster.pid") as file:
        return processor(file.readline().strip())


def database():
    row = sql("SELECT xact_commit, (SELECT wal_bytes FROM pg_stat_wal) FROM pg_stat_database WHERE datname = 'postgres'")
    return [*(float(value) for value in row.split("|")), postgres()]


def streams(count):
    """Streams at the replica that runs a job, and at the other one."""
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


def several(replicas, body):
    """Replicas with and without load: the CPU milliseconds of a job."""
    schema = f"scale_{replicas}"
    sql(f"CREATE SCHEMA {schema}")
    servers = [Server(f"{URL}&options[search_path]={schema}") for _ in range(replicas)]
    throughput(servers, body)
    time.sleep(2)

    def counted():
        statements = sum(server.metric("piad_store_statements_total") for server in servers)
        own = sum(processor(str(server.process.pid)) for server in servers)
        return [*database(), statements, own, time.process_time()]

    def costs(action):
        before = counted()
        value = action()
        return value, [after - before for before, after in zip(before, counted())]

    def cost(elsewhere):
        (rate, jobs), (commits, wal, store, statements, own, clients) = costs(lambda: throughput(servers, body, elsewhere))
        cost = {"store": 1000 * store / jobs, "replica": 1000 * own / jobs, "client": 1000 * clients / jobs, "log": wal / jobs / 1024}
        print(f"{replicas} replicas, read at {'the next one' if elsewhere else 'their own'}: {rate:.0f} jobs/s; a job: "
              f"{statements / jobs:.2f} statements, {commits / jobs:.2f} commits, {cost['log']:.1f} KiB of log; milliseconds "
              f"of a processor: database {cost['store']:.2f}, replica {cost['replica']:.2f}, client {cost['client']:.2f}")
        return {"rate": rate, **cost}

    at_its_own = cost(elsewhere=False)
    if replicas > 1:
        cost(elsewhere=True)
    time.sleep(2)
    _, (_, _, store, statements, _, _) = costs(lambda: time.sleep(SECONDS))
    idle = 1000 * store / SECONDS / replicas
    print(f"    with nothing to do, a replica: {statements / SECONDS / replicas:.1f} statements/s, "
          f"{idle:.2f} ms/s of the database")
    for server in servers:
        server.stop()
    return {"replicas": replicas, "idle": idle, **at_its_own}


def model(measured):
    """A job that is read where it runs has a database cost independent of the number of replicas,
    which each add a little for polling."""
    first, last = measured[0], measured[-1]
    cost = sum(it["store"] for it in measured) / len(measured)
    # The prediction of the last measurement from the first.
    expected = 1000 * os.cpu_count() / (first["store"] + first["replica"] + first["client"])
    print(f"{last['replicas']} replicas, by what one costs: {expected:.0f} jobs/s here, measured {last['rate']:.0f}")
    for replicas in (3, 30, 300):
        computed = replicas * 4 * 1000 / last["replica"]
        stored = (8 * 1000 - replicas * last["idle"]) / cost
        print(f"{replicas} replicas of 4 cores, a database of 8: {computed:.0f} jobs/s are computed, {stored:.0f} stored, "
              f"{stored * last['log'] / 1024:.0f} MiB/s of log")


def main():
    body = job(100, relative_tolerance=1e-6, max_iterations=1000)
    print(f"{CLIENTS} clients, jobs of 100 points, {os.cpu_count()} cores for clients, replicas and database together")
    with tempfile.TemporaryDirectory() as directory:
        server = Server(directory)
        throughput([server], body)
        print(f"a file: {throughput([server], body)[0]:.0f} jobs/s")
        server.stop()
    measured = [several(replicas, body) for replicas in (1, 2, 3)]
    model(measured)
    for count in (100, 100_000):
        streams(count)


main()
