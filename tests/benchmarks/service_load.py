#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Starts a server and measures it under load, with everything durable: tiny jobs a second, the server's memory while a
large cloud is uploaded, and what the service adds to the command. Each figure stands beside its limit.

usage: service_load.py SURFACED [CLOUD.ply]      the cloud for the comparison with the command
"""
import array
import http.client
import json
import os
import random
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time

import small_jobs

JOBS, CONNECTIONS = 500, 4
LARGE = 10_000_000
RUNS = 5


class Server:
    def __init__(self, binary, data):
        command = [binary, "serve", "--listen", "127.0.0.1:0", "--data", data, "--log-level", "warning"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.port = int(re.search(r":(\d+)$", self.process.stdout.readline().strip()).group(1))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGTERM)
        self.process.wait()

    def peak_megabytes(self):
        with open(f"/proc/{self.process.pid}/status") as status:
            return int(re.search(r"VmHWM:\s*(\d+)", status.read()).group(1)) / 1000

    def connection(self):
        return http.client.HTTPConnection("127.0.0.1", self.port, timeout=600)


def tiny_jobs(server):
    body, ids = small_jobs.sphere(), []
    began = time.monotonic()
    threads = [
        threading.Thread(target=small_jobs.submit, args=(server.port, body, JOBS // CONNECTIONS, ids))
        for _ in range(CONNECTIONS)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    submitted = time.monotonic() - began
    connection = server.connection()
    good = [small_jobs.ended(connection, job) for job in ids].count("successful")
    rate = good / (time.monotonic() - began)
    print(f"{JOBS} jobs of {small_jobs.POINTS} points: {len(ids) / submitted:.0f} submissions/s, {rate:.1f} jobs/s "
          f"(limit 40: {rate / 40:.2f} of it), {good} successful, server peak {server.peak_megabytes():.0f} MB")


def points():
    """Blocks of random floats between 1 and 2, a million points each."""
    generator = random.Random(1)
    size = 12 * 1_000_000
    mantissa = int.from_bytes(b"\x00\x00\x7f\xff" * (size // 4), "big")
    exponent = int.from_bytes(b"\x3f\x80\x00\x00" * (size // 4), "big")
    for _ in range(LARGE // 1_000_000):
        bits = int.from_bytes(generator.randbytes(size), "big") & mantissa | exponent
        block = array.array("I", bits.to_bytes(size, "big"))
        block.byteswap()
        yield block.tobytes()


def large_upload(server):
    header = small_jobs.HEADER.replace(f" {small_jobs.POINTS}\n", f" {LARGE}\n").encode()
    connection = server.connection()
    connection.putrequest("POST", "/v1/clouds")
    connection.putheader("Content-Length", str(len(header) + 12 * LARGE))
    connection.endheaders()
    connection.send(header)
    spent = 0.0
    for block in points():
        began = time.monotonic()
        connection.send(block)
        spent += time.monotonic() - began
    began = time.monotonic()
    answer = connection.getresponse()
    cloud = json.loads(answer.read())
    spent += time.monotonic() - began
    if answer.status != 201:
        sys.exit(f"{answer.status} {cloud}")
    peak = server.peak_megabytes()
    while cloud["status"] == "inspecting":
        time.sleep(0.2)
        connection.request("GET", "/v1/clouds/" + cloud["id"])
        cloud = json.loads(connection.getresponse().read())
    peak = max(peak, server.peak_megabytes())
    print(f"upload of {cloud['points']:,} points ({cloud['bytes'] / 1e6:.0f} MB, {cloud['status']}): "
          f"{cloud['bytes'] / 1e6 / spent:.0f} MB/s, server peak {peak:.0f} MB (limit 50: {peak / 50:.2f} of it)")


def seconds_of(work):
    began = time.monotonic()
    work()
    return time.monotonic() - began


def against_the_command(server, binary, cloud, method, folder):
    with open(cloud, "rb") as file:
        body = file.read()
    mesh = os.path.join(folder, "mesh.glb")

    def command():
        subprocess.run([binary, "reconstruct", cloud, "-o", mesh, "--method", method], check=True)

    def service():
        connection = server.connection()
        connection.request("POST", f"/v1/reconstruct?method={method}", body)
        answer = connection.getresponse()
        served = answer.read()
        with open(mesh, "rb") as file:
            if answer.status != 200 or served != file.read():
                sys.exit(f"{answer.status}: the mesh is not that of the command")

    alone, served = [], []
    for _ in range(RUNS):  # by turns, so that both meet the same machine
        alone.append(seconds_of(command))
        served.append(seconds_of(service))
    a, s = statistics.median(alone), statistics.median(served)
    print(f"{os.path.basename(cloud)}, {method}: command {a:.3f} s, service {s:.3f} s; {(s / a - 1) * 100:+.0f} %, "
          f"{(s - a) * 1000:+.0f} ms (limit 30 % or 100 ms; medians of {RUNS})")


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    binary, cloud = os.path.abspath(sys.argv[1]), (sys.argv[2:] + [None])[0]
    with tempfile.TemporaryDirectory() as folder:
        with Server(binary, os.path.join(folder, "a")) as server:
            tiny_jobs(server)
        with Server(binary, os.path.join(folder, "b")) as server:
            large_upload(server)
        if cloud:
            with Server(binary, os.path.join(folder, "c")) as server:
                for method in ("advancing-front", "minimum-boundary"):
                    against_the_command(server, binary, cloud, method, folder)


if __name__ == "__main__":
    main()
