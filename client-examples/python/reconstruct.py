#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns a point cloud into a mesh with a surfaced server. Needs nothing but Python 3.9 or newer."""
import argparse
import http.client
import json
import os
import shutil
import sys
import time
import urllib.parse
import uuid

TRIES = 5


class Refused(Exception):
    """The server's answer is no, and would be no again."""


class Upload:
    """A file that tells how much of it has been sent."""

    def __init__(self, path):
        self.file, self.size, self.told = open(path, "rb"), os.path.getsize(path), -1

    def read(self, size=1 << 16):
        data, before = self.file.read(size), self.told
        self.told = 100 * self.file.tell() // max(self.size, 1)
        show(f"upload {self.told} %") if self.told != before else None
        return data


class Server:
    def __init__(self, url, key):
        self.url = urllib.parse.urlsplit(url)
        self.headers = {"Authorization": f"Bearer {key}"} if key else {}

    def send(self, method, path, cloud=None, headers=None):
        kind = http.client.HTTPSConnection if self.url.scheme == "https" else http.client.HTTPConnection
        connection = kind(self.url.netloc, timeout=60)
        body = Upload(cloud) if cloud else None
        length = {"Content-Length": str(body.size), "Content-Type": "application/octet-stream"} if body else {}
        try:
            connection.request(method, self.url.path.rstrip("/") + path, body, {**self.headers, **length, **(headers or {})})
        except BrokenPipeError:
            pass  # the server has answered before it had the whole cloud: the answer says why
        return connection.getresponse()

    def request(self, method, path, cloud=None, headers=None):
        """Tries again what may pass: no connection, a lost answer, 429 and 503."""
        for attempt in range(TRIES):
            try:
                answer = self.send(method, path, cloud, headers)
                if answer.status < 400:
                    return answer
                reason = said(answer)
                if answer.status not in (429, 502, 503, 504):
                    raise Refused(reason)
                pause = int(answer.headers.get("Retry-After", 1))
            except (OSError, http.client.HTTPException) as failure:
                reason, pause = str(failure) or type(failure).__name__, 2 ** attempt / 2
            show(f"{reason}; trying again in {pause} s\n")
            time.sleep(pause)
        raise Refused(f"given up after {TRIES} tries; the last said: {reason}")

    def events(self, path):
        """Events of a job until `done`; where the stream breaks off, a new one goes on."""
        last, event, data = {}, "", ""
        while event != "done":
            try:
                for line in self.request("GET", path, headers=last):
                    name, _, value = line.decode().rstrip("\n").partition(": ")
                    if name == "event":
                        event = value
                    elif name == "id":
                        last = {"Last-Event-ID": value}
                    elif name == "data":
                        data = value
                    elif not name and data:
                        yield event, json.loads(data)
                        data = ""
            except (OSError, http.client.HTTPException) as failure:
                show(f"{failure}; following on\n")
            time.sleep(0.1)


def said(answer):
    """A problem in words; what does not speak JSON is a proxy in between."""
    try:
        problem = json.load(answer)
        return f"{problem['title']}: {problem['detail']}. {problem['hint']}"
    except ValueError:
        return f"{answer.status} {answer.reason}"


def show(text):
    print(f"\r\033[K{text}" if sys.stderr.isatty() else text.rstrip("\n") + "\n", end="", file=sys.stderr, flush=True)


def reconstruct(server, cloud, mesh, parameters):
    # With this key a submission whose answer was lost can be repeated: it makes no second job.
    once = {"Idempotency-Key": str(uuid.uuid4())}
    job = json.load(server.request("POST", "/v1/jobs?" + urllib.parse.urlencode(parameters), cloud, once))
    show(f"job {job['id']}\n")
    for event, data in server.events(f"/v1/jobs/{job['id']}/events"):
        if event == "progress":
            show(f"{data['phase'] or 'waiting'} {100 * data['progress']:.0f} %")
        job = data if event == "done" else job
    if job["status"] != "successful":
        problem = job.get("error") or {"detail": "the job was removed"}
        raise Refused(f"{job['status']}: {problem['detail']}. {problem.get('hint', '')}")
    outputs = f"/v1/jobs/{job['id']}/outputs"
    with server.request("GET", outputs + "/mesh.glb") as answer, open(mesh + ".part", "wb") as file:
        shutil.copyfileobj(answer, file)
    os.replace(mesh + ".part", mesh)
    return json.load(server.request("GET", outputs + "/report.json"))


def print_quality(report):
    mesh, quality = report["mesh"], report["quality"]
    shape = quality["shortest_edge_to_circumradius"]
    whole = ", ".join(word for word in ("closed", "edge_manifold", "vertex_manifold", "oriented") if mesh[word])
    print(f"{mesh['vertices']} vertices, {mesh['triangles']} triangles, genus {mesh['genus']}: {whole}")
    print(f"shortest edge / circumradius: min {shape['min']:.3f}, mean {shape['mean']:.3f} (equilateral: 1.732)")
    print(f"unused points: {quality['unused_points']}")
    print(*(f"warning: {warning}" for warning in report["warnings"]), sep="\n", end="")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cloud", help="PLY, Draco, LAS, PCD, glTF, OBJ, STL or text")
    parser.add_argument("mesh", help="the GLB to write")
    parser.add_argument("parameters", nargs="*", metavar="name=value", help="method=ID and the method's parameters")
    parser.add_argument("--url", default=os.environ.get("SURFACED_URL", "http://127.0.0.1:8080"))
    options = parser.parse_args()
    parameters = [tuple(each.split("=", 1)) for each in options.parameters]
    if any(len(each) < 2 for each in parameters):
        parser.error(f"parameters are name=value, not {options.parameters}")
    if not os.path.isfile(options.cloud):
        parser.error(f"there is no file {options.cloud}")
    try:
        print_quality(reconstruct(Server(options.url, os.environ.get("SURFACED_KEY")), options.cloud, options.mesh, parameters))
    except (Refused, OSError) as failure:
        sys.exit(f"reconstruct.py: {failure}")


if __name__ == "__main__":
    main()
