#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Drives a server by everything at once: jobs from raw clouds, forms and stored clouds, event streams that break off and
resume, long polls, other formats, ranges, cancels, retries, removals, uploads, probes, clients that vanish; with --tls over
TLS while the certificate is read again. Then stops it while streams are open. Every answer has to be one that is allowed,
every job has to end as it was told to, and the server has to end with 0. A server built by the preset tsan-server also
says what its threads race for.

usage: under_load.py SURFACED [--tls] [--jobs N] [--seed N]      defaults: 60 jobs, seed 1
"""
import argparse
import base64
import collections
import http.client
import json
import os
import pathlib
import random
import re
import signal
import ssl
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "benchmarks"))
import small_jobs  # noqa: E402

CLIENTS = 6
METHODS = ("advancing-front", "local-delaunay", "minimum-boundary", "alpha-wrap")
FORMATS = ("mesh.glb", "mesh.obj", "mesh.stl", "mesh.ply", "mesh.drc", "mesh.gltf", "mesh.3mf", "report.json", "log.txt")
SECONDS = 300  # until a job has ended, also under a sanitizer
RAW = {"Content-Type": "application/octet-stream"}
JSON = {"Content-Type": "application/json"}
TUS = {"Tus-Resumable": "1.0.0"}


def certificate(folder):
    key, pem = os.path.join(folder, "key.pem"), os.path.join(folder, "certificate.pem")
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "1",
         "-subj", "/CN=load", "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", key, "-out", pem],
        check=True, stderr=subprocess.DEVNULL)
    return key, pem


class Server:
    def __init__(self, binary, folder, tls):
        flags, self.context = [], None
        if tls:
            key, pem = certificate(folder)
            flags = ["--tls-certificate", pem, "--tls-key", key]
            self.context = ssl.create_default_context(cafile=pem)
        self.errors_path = os.path.join(folder, "errors")
        with open(self.errors_path, "wb") as errors:
            self.process = subprocess.Popen(
                # One thread a job: with more, TSan sees races in the children's TBB, which Debian does not instrument.
                [binary, "serve", "--listen", "127.0.0.1:0", "--data", os.path.join(folder, "data"), "--workers", "2",
                 "--threads-per-job", "1", "--drain-time", "1", "--rate-limit", "0", "--submission-rate-limit", "0",
                 *flags],
                stdout=subprocess.PIPE, stderr=errors, text=True)
        self.port = int(re.search(r":(\d+)$", self.process.stdout.readline().strip()).group(1))

    def connection(self):
        if self.context:
            return http.client.HTTPSConnection("127.0.0.1", self.port, timeout=SECONDS, context=self.context)
        return http.client.HTTPConnection("127.0.0.1", self.port, timeout=SECONDS)

    def errors(self):
        return pathlib.Path(self.errors_path).read_text(errors="replace")


class Client:
    """One thread's connection, and what it saw. `seen` counts what was done, `wrong` keeps what should not be."""

    def __init__(self, server, seed, seen, wrong):
        self.server, self.random, self.seen, self.wrong = server, random.Random(seed), seen, wrong
        self.connection = server.connection()

    def call(self, method, target, body=None, headers=None, allowed=(200,)):
        for again in (True, False):
            try:
                self.connection.request(method, target, body, headers or {})
                answer = self.connection.getresponse()
                text = answer.read()
                break
            except (http.client.RemoteDisconnected, BrokenPipeError, ConnectionResetError):
                # An idle connection may be closed at any time; what is safe to send twice is.
                self.connection.close()
                if not again or method == "POST":
                    raise
        self.seen[f"{method} {re.sub('[0-9a-f]{32,}', 'ID', target.split('?')[0])} {answer.status}"] += 1
        if answer.status not in allowed:
            self.wrong.append(f"{method} {target}: {answer.status} {text[:300]!r}")
        return answer, text

    def submit(self, cloud, stored):
        self.connection.close()  # a POST goes on a connection that is not about to be closed for its silence
        method = self.random.choice(METHODS)
        kind = self.random.randrange(3)
        if kind == 0:
            _, text = self.call("POST", f"/v1/jobs?method={method}", cloud, RAW, (201,))
        elif kind == 1:
            body = json.dumps({"method": method, "cloud_id": stored, "labels": ["load"]})
            _, text = self.call("POST", "/v1/jobs", body, JSON, (201,))
        else:
            form = (b"--B\r\nContent-Disposition: form-data; name=\"method\"\r\n\r\n" + method.encode() +
                    b"\r\n--B\r\nContent-Disposition: form-data; name=\"cloud\"; filename=\"c.ply\"\r\n\r\n" + cloud +
                    b"\r\n--B--\r\n")
            _, text = self.call("POST", "/v1/jobs", form, {"Content-Type": "multipart/form-data; boundary=B"}, (201,))
        return json.loads(text)["id"]

    def wait(self, job):
        until = time.monotonic() + SECONDS
        while time.monotonic() < until:
            _, text = self.call("GET", f"/v1/jobs/{job}?wait={self.random.choice((0, 1, 5))}")
            state = json.loads(text)["status"]
            if state not in ("accepted", "running"):
                return state
        return "never ended"

    def follow(self, job):
        """Reads the job's events to the end, on new connections after some of them."""
        position, until = None, time.monotonic() + SECONDS
        while time.monotonic() < until:
            connection = self.server.connection()
            try:
                headers = {"Last-Event-ID": position} if position else {}
                connection.request("GET", f"/v1/jobs/{job}/events", headers=headers)
                answer = connection.getresponse()
                if answer.status == 204:
                    return
                if answer.status != 200:
                    self.wrong.append(f"events of {job}: {answer.status}")
                    return
                lines = self.random.choice((4, 9, 1000))
                while lines > 0 and (line := answer.readline()):
                    lines -= 1
                    if line.startswith(b"id:"):
                        position = line[3:].strip().decode()
                    if line.startswith(b"event: done"):
                        self.seen["streams to the end"] += 1
                        answer.read()
                        return
                self.seen["streams that broke off"] += 1
            finally:
                connection.close()
        self.wrong.append(f"events of {job} never ended")

    def take_outputs(self, job):
        for name in self.random.sample(FORMATS, 4):
            path = f"/v1/jobs/{job}/outputs/{name}"
            answer, text = self.call("GET", path)
            etag = answer.headers["ETag"]
            self.call("GET", path, headers={"If-None-Match": etag}, allowed=(304,))
            _, part = self.call("GET", path, headers={"Range": "bytes=1-9", "If-Range": etag}, allowed=(206,))
            if part != text[1:10]:
                self.wrong.append(f"{path}: a range is not the file's")

    def cancel_and_retry(self, job):
        time.sleep(self.random.random() * 0.2)
        answer, _ = self.call("DELETE", f"/v1/jobs/{job}", allowed=(200, 202))
        if answer.status == 200:
            self.call("GET", f"/v1/jobs/{job}", allowed=(410,))
            return "removed"
        if self.random.random() < 0.5:
            return "dismissed"
        self.connection.close()
        self.call("POST", f"/v1/jobs/{job}/retry", allowed=(202,))
        return "successful"

    def run_job(self, cloud, stored):
        job = self.submit(cloud, stored)
        streams = [threading.Thread(target=self.twin().follow, args=(job,)) for _ in range(self.random.randrange(3))]
        for stream in streams:
            stream.start()
        expected = "successful"
        if self.random.random() < 0.3:
            for stream in streams:  # the end of a removed job's stream is the job's, not its own
                stream.join()
            streams = []
            job = self.submit(cloud, stored)
            expected = self.cancel_and_retry(job)
        if expected != "removed":
            state = self.wait(job)
            if state != expected:
                self.wrong.append(f"{job} is {state}, not {expected}")
            elif state == "successful":
                self.race_for_outputs(job)
        for stream in streams:
            stream.join()
        if expected != "removed" and self.random.random() < 0.5:
            self.call("DELETE", f"/v1/jobs/{job}")
        self.seen["jobs"] += 1

    def race_for_outputs(self, job):
        others = [threading.Thread(target=self.twin().take_outputs, args=(job,)) for _ in range(2)]
        for other in others:
            other.start()
        for other in others:
            other.join()

    def twin(self):
        return Client(self.server, self.random.random(), self.seen, self.wrong)

    def upload(self, cloud):
        self.connection.close()
        half = len(cloud) // 2
        answer, _ = self.call("POST", "/v1/uploads", headers={**TUS, "Upload-Length": str(len(cloud))}, allowed=(201,))
        path = re.sub("^https?://[^/]*", "", answer.headers["Location"])
        for offset, part in ((0, cloud[:half]), (half, cloud[half:])):
            self.call("HEAD", path, headers=TUS)
            self.call("PATCH", path, part, {**TUS, "Upload-Offset": str(offset),
                                            "Content-Type": "application/offset+octet-stream"}, (204,))
        self.call("DELETE", path, headers=TUS, allowed=(204, 404, 409, 410))

    def look_around(self, cloud):
        for path in ("/v1/jobs?limit=5", "/v1/jobs?status=running,successful", "/metrics", "/readyz", "/healthz",
                     "/v1/methods", "/openapi.json", "/jobs?limit=3"):
            self.call("GET", path)
        self.call("GET", "/v1/jobs/" + base64.b16encode(os.urandom(16)).decode().lower(), allowed=(404,))
        self.upload(cloud)

    def vanish(self, stored):
        """Ends a connection in the middle of its head, its body, or before the answer."""
        connection = self.server.connection()
        try:
            connection.connect()
            connection.sock.sendall(self.random.choice((
                b"GET /v1/jo", b"POST /v1/clouds HTTP/1.1\r\nHost: x\r\nContent-Length: 100000\r\n\r\nply\n",
                b"GET /v1/clouds/" + stored.encode() + b" HTTP/1.1\r\nHost: x\r\n\r\n",
                b"GET /metrics HTTP/1.1\r\nHost: x\r\n\r\nGET /openapi.json HTTP/1.1\r\nHost: x\r\n\r\n")))
            self.seen["clients that vanished"] += 1
        finally:
            connection.close()


def guarded(client, work):
    """What ends a thread is told, and ends the test."""
    def run():
        try:
            work(client)
        except Exception as error:  # every kind: the thread has nobody else to tell
            client.wrong.append(f"{type(error).__name__}: {error}")
    return threading.Thread(target=run)


def load(server, jobs, seed):
    seen, wrong, ended = collections.Counter(), [], threading.Event()
    cloud = small_jobs.sphere()
    first = Client(server, seed, seen, wrong)
    _, text = first.call("POST", "/v1/clouds", cloud, RAW, (200, 201))
    stored = json.loads(text)["id"]

    def work(client):
        for _ in range(jobs // CLIENTS):
            client.run_job(cloud, stored)

    def disturb(client):
        while not ended.wait(0.05):
            client.look_around(cloud)
            client.vanish(stored)
            if server.context:
                server.process.send_signal(signal.SIGHUP)

    clients = [Client(server, seed * 100 + i, seen, wrong) for i in range(CLIENTS + 2)]
    workers = [guarded(client, work) for client in clients[:CLIENTS]]
    disturbers = [guarded(client, disturb) for client in clients[CLIENTS:]]
    for thread in workers + disturbers:
        thread.start()
    for thread in workers:
        thread.join()
    ended.set()
    for thread in disturbers:
        thread.join()
    return seen, wrong


def stop_with_streams(server, seed):
    """Stops the server while jobs run, streams and long polls are open; returns what it ended with."""
    client = Client(server, seed, collections.Counter(), [])
    cloud, held = small_jobs.sphere(), []
    for i in range(8):
        _, text = client.call("POST", "/v1/jobs?method=minimum-boundary", cloud, RAW, (201,))
        job = json.loads(text)["id"]
        held.append(server.connection())
        held[-1].request("GET", f"/v1/jobs/{job}" + ("/events" if i % 2 else "?wait=60"))
    server.process.send_signal(signal.SIGTERM)
    try:
        code = server.process.wait(240)
    except subprocess.TimeoutExpired:
        server.process.kill()
        code = "no end within 240 s"
    for connection in held:
        connection.close()
    return code, client.wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("surfaced")
    parser.add_argument("--tls", action="store_true")
    parser.add_argument("--jobs", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print(f"seed {options.seed}")
    with tempfile.TemporaryDirectory() as folder:
        server = Server(os.path.abspath(options.surfaced), folder, options.tls)
        began = time.monotonic()
        try:
            seen, wrong = load(server, options.jobs, options.seed)
            code, late = stop_with_streams(server, options.seed)
        finally:
            server.process.kill()
            server.process.wait()
        wrong += late
        if code != 0:
            wrong.append(f"the server ended with {code}")
        log = server.errors()
        wrong += [line for line in log.splitlines() if "WARNING: ThreadSanitizer" in line or "internal_error" in line]
        for what, count in sorted(seen.items()):
            print(f"{count:6} {what}")
        print(f"{seen['jobs']} jobs, {sum(seen.values())} things in {time.monotonic() - began:.1f} s, {len(wrong)} wrong")
        for line in wrong[:40]:
            print(line, file=sys.stderr)
        report = log.find("WARNING: ThreadSanitizer")
        if report >= 0:
            print(log[report : report + 40_000], file=sys.stderr)
        if wrong:
            sys.exit(1)


if __name__ == "__main__":
    main()
