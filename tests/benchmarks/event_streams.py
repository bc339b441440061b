#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Follows one long job with many event streams and says what pace submissions keep beside them.

usage: event_streams.py SURFACED [STREAMS [SUBMISSIONS]]      defaults: 1000 300

Starts `SURFACED serve` with one worker of one thread, so that the submissions wait behind the followed job and only the service is
measured; takes the pace without streams, with them, and without them again.
"""
import http.client
import json
import math
import random
import selectors
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time

FOLLOWED_POINTS = 400_000
SMALL_POINTS = 50


def cloud(points, seed):
    """Random points on a bumpy sphere, as binary PLY."""
    chance = random.Random(seed)
    body = bytearray(
        (
            "ply\nformat binary_little_endian 1.0\nelement vertex %d\n"
            "property float x\nproperty float y\nproperty float z\nend_header\n" % points
        ).encode()
    )
    for _ in range(points):
        z, angle = chance.uniform(-1, 1), chance.uniform(0, 2 * math.pi)
        radius, flat = 1 + 0.1 * math.sin(9 * angle), math.sqrt(1 - z * z)
        body += struct.pack("<fff", radius * flat * math.cos(angle), radius * flat * math.sin(angle), radius * z)
    return bytes(body)


class Streams(threading.Thread):
    """All streams in one thread; counts their events and notes when each ended with `done`."""

    def __init__(self, port, job, count):
        super().__init__()
        self.port, self.job, self.count = port, job, count
        self.tails, self.events, self.done_at, self.open = {}, {}, [], 0

    def run(self):
        selector = selectors.DefaultSelector()
        for number in range(self.count):
            stream = socket.create_connection(("127.0.0.1", self.port))
            stream.sendall(f"GET /v1/jobs/{self.job}/events HTTP/1.1\r\nHost: h\r\n\r\n".encode())
            stream.setblocking(False)
            self.tails[number], self.events[number] = b"", 0
            selector.register(stream, selectors.EVENT_READ, number)
            self.open += 1
        while self.open:
            for key, _ in selector.select():
                piece = key.fileobj.recv(1 << 16)
                number = key.data
                self.events[number] += piece.count(b"event: ")
                self.tails[number] = (self.tails[number] + piece)[-4096:]
                if not piece:
                    selector.unregister(key.fileobj)
                    key.fileobj.close()
                    self.open -= 1
                    if b"event: done" in self.tails[number]:
                        self.done_at.append(time.monotonic())


def pace(port, body, count):
    """Submissions a second on one connection, and their times in milliseconds, sorted."""
    connection = http.client.HTTPConnection("127.0.0.1", port)
    times = []
    start = time.monotonic()
    for _ in range(count):
        began = time.monotonic()
        connection.request("POST", "/v1/jobs?method=advancing-front", body, {"Content-Type": "application/octet-stream"})
        answer = connection.getresponse()
        text = answer.read()
        if answer.status != 201:
            sys.exit(f"{answer.status} {text.decode()}")
        times.append((time.monotonic() - began) * 1000)
    return count / (time.monotonic() - start), sorted(times)


def call(port, method, target, body=None):
    connection = http.client.HTTPConnection("127.0.0.1", port)
    connection.request(method, target, body)
    answer = connection.getresponse()
    return json.loads(answer.read())


def measure(port, streams, submissions):
    followed = call(port, "POST", "/v1/jobs?method=minimum-boundary", cloud(FOLLOWED_POINTS, 1))["id"]
    while call(port, "GET", f"/v1/jobs/{followed}")["status"] == "accepted":
        time.sleep(0.05)
    body = cloud(SMALL_POINTS, 2)
    pace(port, body, 20)

    def tell(what):
        rate, times = pace(port, body, submissions)
        median, late = times[len(times) // 2], times[len(times) * 95 // 100]
        print(f"{what}: {rate:.0f} submissions/s, median {median:.1f} ms, 95 of 100 within {late:.1f} ms", flush=True)

    tell("without streams")
    crowd = Streams(port, followed, streams)
    crowd.start()
    while crowd.open < streams and crowd.is_alive():
        time.sleep(0.05)
    time.sleep(1)
    before = sum(crowd.events.values())
    began = time.monotonic()
    tell(f"beside {streams} streams")
    told = (sum(crowd.events.values()) - before) / (time.monotonic() - began)
    ended = time.monotonic()
    state = call(port, "GET", f"/v1/jobs/{followed}")["status"]
    if state != "running":
        sys.exit(f"the followed job is {state}: it ended before the measurement did")
    call(port, "DELETE", f"/v1/jobs/{followed}")
    crowd.join()
    print(
        f"{told:.0f} events/s to all streams; {len(crowd.done_at)} of {streams} were told the end, "
        f"the last {max(crowd.done_at) - ended:.2f} s after it; fewest events of a stream: {min(crowd.events.values())}"
    )
    tell("without streams again")


def main():
    surfaced = sys.argv[1]
    streams, submissions = (int(value) for value in (sys.argv[2:] + ["1000", "300"][len(sys.argv) - 2 :]))
    with tempfile.TemporaryDirectory(prefix="surfaced-streams-") as data:
        flags = ["--listen", "127.0.0.1:0", "--data", data, "--workers", "1", "--threads-per-job", "1", "--queue-limit", "100000"]
        flags += ["--requests-per-connection", "1000000", "--drain-time", "0", "--log-level", "warning"]
        server = subprocess.Popen([surfaced, "serve", *flags], stdout=subprocess.PIPE, text=True)
        try:
            port = int(server.stdout.readline().rsplit(":", 1)[1])
            measure(port, streams, submissions)
        finally:
            server.terminate()
            server.wait()


if __name__ == "__main__":
    main()
