#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sends many tiny jobs to a running server and says how many it takes and ends in a second.

usage: small_jobs.py [PORT [JOBS [CONNECTIONS]]]      defaults: 8080 500 4
"""
import http.client
import json
import math
import struct
import sys
import threading
import time

POINTS = 500
HEADER = (
    "ply\nformat binary_little_endian 1.0\nelement vertex %d\n"
    "property float x\nproperty float y\nproperty float z\nend_header\n" % POINTS
)


def sphere():
    """A Fibonacci spiral on the unit sphere, as binary PLY."""
    body = HEADER.encode()
    for i in range(POINTS):
        z = 1 - (2 * i + 1) / POINTS
        radius = math.sqrt(1 - z * z)
        angle = math.pi * (3 - math.sqrt(5)) * i
        body += struct.pack("<fff", radius * math.cos(angle), radius * math.sin(angle), z)
    return body


def submit(port, body, count, ids):
    connection = http.client.HTTPConnection("127.0.0.1", port)
    for _ in range(count):
        connection.request("POST", "/v1/jobs?method=advancing-front", body, {"Content-Type": "application/octet-stream"})
        answer = connection.getresponse()
        text = answer.read()
        if answer.status != 201:
            sys.exit(f"{answer.status} {text.decode()}")
        ids.append(json.loads(text)["id"])


def ended(connection, job):
    while True:
        connection.request("GET", f"/v1/jobs/{job}?wait=30")
        state = json.loads(connection.getresponse().read())
        if state["status"] not in ("accepted", "running"):
            return state["status"]


def main():
    port, jobs, connections = (int(value) for value in (sys.argv[1:] + ["8080", "500", "4"][len(sys.argv) - 1 :]))
    body, ids = sphere(), []
    start = time.monotonic()
    threads = [
        threading.Thread(target=submit, args=(port, body, jobs // connections, ids)) for _ in range(connections)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    submitted = time.monotonic()
    connection = http.client.HTTPConnection("127.0.0.1", port)
    statuses = [ended(connection, job) for job in ids]
    done = time.monotonic()
    print(
        f"{len(ids)} jobs of {POINTS} points: {len(ids) / (submitted - start):.1f} submissions/s, "
        f"{len(ids) / (done - start):.1f} jobs/s, {statuses.count('successful')} successful"
    )


if __name__ == "__main__":
    main()
