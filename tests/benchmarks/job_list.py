#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""job_list.py SURFACED [JOBS]: what a page of jobs costs beside many others, by filter, and the look at a key's quota."""
import hashlib
import http.client
import re
import sqlite3
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SURFACED = sys.argv[1]
JOBS = int(sys.argv[2]) if len(sys.argv) > 2 else 200_000
METHODS = ["minimum-boundary", "local-delaunay", "intrinsic-delaunay", "advancing-front", "scale-space", "alpha-wrap"]


def serve(folder):
    server = subprocess.Popen([SURFACED, "serve", "--listen", "127.0.0.1:0", "--data", folder / "data", "--log-level", "error",
                               "--keys", folder / "keys"], stdout=subprocess.PIPE, text=True)
    return server, int(re.search(r":(\d+)", server.stdout.readline().split("//")[1])[1])


def stop(server):
    server.terminate()
    server.wait()


def fill(database, key):
    """One job in ten is the key's; one waits, one has a label of its own, one in 25 has failed."""
    jobs, outputs = [], []
    for i in range(JOBS):
        name = hashlib.md5(str(i).encode()).hexdigest()
        status = "accepted" if i == JOBS // 20 else "failed" if i % 25 == 0 else "successful"
        labels = '["once"]' if i == JOBS // 20 else f'["project:{i % 50}","user:{i % 7}"]'
        at = time.strftime("%Y-%m-%dT%H:%M:%S.000Z", time.gmtime(1.79e9 + i))
        digest = hashlib.sha256(name.encode()).hexdigest()
        jobs.append((name, METHODS[i % len(METHODS)], '{"components":"one","lids":"watershed","variant":"best"}', status, name, digest,
                     '["mesh.glb","report.json","log.txt"]', "r" + name, at, at, None if status == "accepted" else at,
                     "2999-01-01T00:00:00.000Z", key if i % 10 == 0 else f"other{i % 9}", labels))
        outputs += [(name, output, 1, 50_000, digest) for output in ("mesh.glb", "report.json", "log.txt")]
    with sqlite3.connect(database) as store:
        store.executemany("INSERT INTO jobs (id, method, parameters, status, attempt, input_key, input_bytes, input_sha256, wanted, request_id,"
                          " ttl_seconds, created_at, started_at, finished_at, expires_at, owner, labels)"
                          " VALUES (?, ?, ?, ?, 1, ?, 120000, ?, ?, ?, 86400, ?, ?, ?, ?, ?, ?)", jobs)
        store.executemany("INSERT INTO outputs VALUES (?, ?, ?, ?, ?)", outputs)
    store.close()


def milliseconds(port, key, method, target, body=None):
    times = []
    for _ in range(7):
        connection = http.client.HTTPConnection("127.0.0.1", port)
        began = time.perf_counter()
        connection.request(method, target, body, {"Authorization": f"Bearer {key}", "Content-Type": "application/octet-stream"})
        answer = connection.getresponse()
        text = answer.read()
        times.append(time.perf_counter() - began)
        assert answer.status in (200, 201), (target, answer.status, text)
    return 1000 * statistics.median(times)


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        add = [SURFACED, "keys", "add", folder / "keys", "--name"]
        admin = subprocess.run([*add, "admin", "--scopes", "admin"], check=True, capture_output=True, text=True).stdout.strip()
        one = subprocess.run([*add, "one", "--stored-bytes", str(2**50)], check=True, capture_output=True, text=True).stdout.strip()
        server, _ = serve(folder)
        stop(server)
        fill(folder / "data/jobs.sqlite", one.split("_")[1])
        server, port = serve(folder)
        try:
            for query in ["", "status=accepted", "status=failed", "status=accepted,running", "method=poisson",
                          "method=advancing-front&status=accepted", "labels=once", "labels=project:3"]:
                print(f"| `/v1/jobs?{query}` | {milliseconds(port, admin, 'GET', '/v1/jobs?limit=50&' + query):.1f} ms |")
            for query in ["minDuration=900", "datetime=2099-01-01T00:00:00Z/.."]:
                print(f"| `/jobs?{query}` | {milliseconds(port, admin, 'GET', '/jobs?limit=50&' + query):.1f} ms |")
            for query in ["", "status=accepted,running", "labels=once"]:
                print(f"| `/v1/jobs?{query}`, a key with a tenth of the jobs | {milliseconds(port, one, 'GET', '/v1/jobs?limit=50&' + query):.1f} ms |")
            print(f"| a small cloud sent with that key, of which the bytes are limited | {milliseconds(port, one, 'POST', '/v1/clouds', b'x' * 100):.1f} ms |")
        finally:
            stop(server)


main()
