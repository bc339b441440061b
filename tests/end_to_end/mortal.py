# SPDX-License-Identifier: GPL-3.0-or-later
"""A service that is killed again and again, and a client that notes what was promised to it.

A promise is what an answer said. A request whose answer never came promises nothing: it may have been done or not.
"""
import hashlib
import http.client
import json
import os
import random
import re
import struct
import subprocess
import threading
import time
import zlib

PATIENCE = 120  # seconds, for what will happen
TUS = {"Tus-Resumable": "1.0.0"}
NO_CLOUD = b"this is no cloud"


def cloud(points, seed):
    """Binary PLY of points on a sphere."""
    chance = random.Random(seed)
    head = (f"ply\nformat binary_little_endian 1.0\nelement vertex {points}\n"
            "property float x\nproperty float y\nproperty float z\nend_header\n").encode()
    body = bytearray()
    for _ in range(points):
        point = [chance.gauss(0, 1) for _ in range(3)]
        length = sum(x * x for x in point) ** 0.5
        body += struct.pack("<3f", *(x / length for x in point))
    return head + bytes(body)


def eventually(condition, what):
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        if condition():
            return
        time.sleep(0.02)
    raise AssertionError(f"it never happened: {what}")


class Server:
    """`surfaced serve` on a folder, on a free port."""

    def __init__(self, binary, data, flags=(), environment=None):
        self.binary, self.data, self.flags = binary, str(data), list(flags)
        self.environment = {**os.environ, **(environment or {})}
        self.port, self.process = 0, None
        self.start()

    def spawn(self):
        command = [self.binary, "serve", "--listen", "127.0.0.1:0", "--data", self.data, "--workers", "2",
                   "--threads-per-job", "1", "--minimum-free", "1MiB", "--log-level", "error", *self.flags]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=None, text=True, env=self.environment)

    def start(self):
        self.process = self.spawn()
        line = self.process.stdout.readline().strip()
        if not re.search(r":\d+$", line):
            raise AssertionError(f"the server does not start on {self.data}: {line!r}, {self.process.wait()}")
        self.port = int(line.rsplit(":", 1)[1])

    def kill_while_it_starts(self, seconds):
        process = self.spawn()
        time.sleep(seconds)
        process.kill()
        process.wait()
        process.stdout.close()

    def end(self, kill=False):
        if kill:
            self.process.kill()
        else:
            self.process.terminate()
        code = self.process.wait(PATIENCE)
        self.process.stdout.close()
        return code

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.end(kill=True)

    def ask(self, method, target, body=None, headers=None):
        """Status, headers and body; status 0 if the server died under it."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        try:
            connection.request(method, target, body, headers or {})
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read()
        except (OSError, http.client.HTTPException):
            return 0, {}, b""
        finally:
            connection.close()


class Promises:
    """What one key was told. `jobs`, `clouds` and `uploads` by id, each with what is certain of it."""

    def __init__(self):
        self.jobs, self.clouds, self.uploads = {}, {}, {}
        self.lock = threading.Lock()

    def snapshot(self):
        with self.lock:
            return ({k: dict(v) for k, v in self.jobs.items()}, dict(self.clouds),
                    {k: dict(v) for k, v in self.uploads.items()})


class Client:
    """Does anything that a client may do, at random, and keeps the promises that it gets."""

    def __init__(self, server, seed, key=None, hook=None, name=""):
        self.server, self.random, self.hook, self.name = server, random.Random(seed), hook, name
        self.headers = {"Authorization": f"Bearer {key}"} if key else {}
        self.promises, self.wrong, self.counter, self.refused = Promises(), [], 0, 0
        self.contents = [cloud(60, 1), cloud(400, 2), cloud(1500, 3)]
        self.meshes = {}

    def ask(self, method, target, body=None, headers=None):
        return self.server.ask(method, target, body, {**self.headers, **(headers or {})})

    def act(self):
        """One thing, after a pause: what is submitted has to be worked off, too."""
        time.sleep(self.random.random() * 0.06)
        actions = (self.submit, self.submit, self.submit, self.submit_stored, self.upload, self.upload, self.delete_job,
                   self.delete_cloud, self.retry, self.render, self.look)
        self.random.choice(actions)()

    def expect(self, status, allowed, what, body=b""):
        if status not in (0, 429, 503, 507, *allowed):
            self.wrong.append(f"{self.name} {what}: {status} {body[:300]!r}")

    # jobs

    def submit(self, stored=None):
        """A job, with an Idempotency-Key; an answer that did not come is asked for again, and makes no second job."""
        self.counter += 1
        label = f"{self.name}-{self.counter}"
        bad = stored is None and self.random.random() < 0.15
        which = -1 if bad else self.random.randrange(len(self.contents))
        query = f"/v1/jobs?method=advancing-front&labels={label}"
        hook = self.hook and self.random.random() < 0.4
        if hook:
            query += "&webhook=" + self.hook
        headers = {"Idempotency-Key": label, "Content-Type": "application/octet-stream"}
        body = NO_CLOUD if bad else self.contents[which]
        if stored is not None:
            which, identity = stored
            query, headers["Content-Type"] = "/v1/jobs", "application/json"
            body = json.dumps({"method": "advancing-front", "cloud_id": identity, "labels": [label],
                               **({"webhook": self.hook} if hook else {})})
        for _ in range(self.random.choice((1, 3))):
            status, _, text = self.ask("POST", query, body, headers)
            if status != 0:
                break
            time.sleep(0.05)
        self.expect(status, (200, 201, 404, 409), "submit", text)
        if status in (200, 201):
            with self.promises.lock:
                self.promises.jobs[json.loads(text)["id"]] = {
                    "cloud": which, "hook": bool(hook), "label": label, "now": "natural", "sure": True, "again": False}

    def submit_stored(self):
        which = self.random.randrange(len(self.contents))
        body = self.contents[which]
        identity = hashlib.sha256(body).hexdigest()
        with self.promises.lock:
            if self.promises.clouds.get(identity) != "stored":
                self.promises.clouds[identity] = "unsure"
        status, _, text = self.ask("POST", "/v1/clouds", body)
        self.expect(status, (200, 201), "store a cloud", text)
        if status in (200, 201):
            with self.promises.lock:
                self.promises.clouds[identity] = "stored"
            self.submit((which, identity))

    def pick(self):
        with self.promises.lock:
            return self.random.choice(sorted(self.promises.jobs)) if self.promises.jobs else None

    def change(self, job, **what):
        with self.promises.lock:
            self.promises.jobs[job].update(what)

    def delete_job(self):
        if not (job := self.pick()):
            return
        before = self.promises.jobs[job]["now"]
        self.change(job, sure=False)
        status, _, text = self.ask("DELETE", f"/v1/jobs/{job}")
        self.expect(status, (200, 202, 410), "delete a job", text)
        if status in (200, 410):
            self.change(job, now="gone", sure=True)
        elif status == 202:
            self.change(job, now="dismissed", sure=True)
        elif status != 0:
            self.change(job, now=before, sure=True)

    def retry(self):
        if not (job := self.pick()) or not self.promises.jobs[job]["sure"]:
            return
        before = self.promises.jobs[job]["now"]
        self.change(job, sure=False, again=True)
        status, _, text = self.ask("POST", f"/v1/jobs/{job}/retry")
        self.expect(status, (202, 409, 410), "retry", text)
        if status == 202:
            self.change(job, now="natural", sure=True)
        elif status != 0:
            self.change(job, now=before, sure=True)

    def render(self):
        if job := self.pick():
            form = self.random.choice(("obj", "ply", "stl"))
            status, _, text = self.ask("GET", f"/v1/jobs/{job}/outputs/mesh.{form}")
            self.expect(status, (200, 404, 409, 410), "another format", text)

    def look(self):
        """What is seen to have ended has ended for good."""
        if not (job := self.pick()):
            return
        status, _, text = self.ask("GET", f"/v1/jobs/{job}")
        if status != 200:
            return
        seen = json.loads(text)["status"]
        with self.promises.lock:
            promise = self.promises.jobs[job]
            if seen == "successful" and promise["now"] == "natural" and promise["sure"]:
                promise["ended"] = True

    # clouds and uploads

    def delete_cloud(self):
        with self.promises.lock:
            known = sorted(self.promises.clouds)
        if not known:
            return
        identity = self.random.choice(known)
        before = self.promises.clouds[identity]
        with self.promises.lock:
            self.promises.clouds[identity] = "unsure"
        status, _, text = self.ask("DELETE", f"/v1/clouds/{identity}")
        self.expect(status, (204, 404, 409), "delete a cloud", text)
        if status != 0:
            with self.promises.lock:
                self.promises.clouds[identity] = "gone" if status in (204, 404) else before

    def upload(self):
        """Begins an upload, or goes on with one, by a part of it."""
        with self.promises.lock:
            going = sorted(i for i, each in self.promises.uploads.items() if each["now"] == "open")
        if not going or self.random.random() < 0.3:
            self.begin_upload()
        elif self.random.random() < 0.1:
            self.end_upload(self.random.choice(going))
        else:
            self.append(self.random.choice(going))

    def begin_upload(self):
        self.counter += 1
        # Clouds of its own, which nobody else deletes.
        body = cloud(80 + self.random.randrange(300), zlib.crc32(f"{self.name} {self.counter}".encode()))
        status, headers, text = self.ask("POST", "/v1/uploads", headers={**TUS, "Upload-Length": str(len(body))})
        self.expect(status, (201,), "begin an upload", text)
        if status == 201:
            identity = headers["Location"].rsplit("/", 1)[1]
            with self.promises.lock:
                self.promises.uploads[identity] = {"body": body, "offset": 0, "now": "open"}

    def append(self, identity):
        upload = self.promises.uploads[identity]
        status, headers, text = self.ask("HEAD", f"/v1/uploads/{identity}", headers=TUS)
        self.expect(status, (200,), "look at an upload", text)
        if status != 200:
            return
        offset = int(headers["Upload-Offset"])
        if offset < upload["offset"]:
            self.wrong.append(f"upload {identity} has {offset} bytes, {upload['offset']} were acknowledged")
        part = upload["body"][offset : offset + self.random.choice((500, 5000))]
        status, headers, text = self.ask("PATCH", f"/v1/uploads/{identity}", part, {
            **TUS, "Upload-Offset": str(offset), "Content-Type": "application/offset+octet-stream"})
        self.expect(status, (204, 409), "append", text)
        if status == 204:
            with self.promises.lock:
                upload["offset"] = int(headers["Upload-Offset"])
                if headers["Surfaced-Cloud-Id"]:
                    upload["now"] = "cloud"

    def end_upload(self, identity):
        with self.promises.lock:
            self.promises.uploads[identity]["now"] = "unsure"
        status, _, text = self.ask("DELETE", f"/v1/uploads/{identity}", headers=TUS)
        self.expect(status, (204, 410), "end an upload", text)
        if status != 0:
            with self.promises.lock:
                self.promises.uploads[identity]["now"] = "gone"


class Judge:
    """Compares what a server says with what was promised, once it has been left in peace."""

    def __init__(self, server, client):
        self.server, self.client, self.wrong, self.meshes = server, client, client.wrong, client.meshes

    def job(self, identity, wait=20):
        until = time.monotonic() + PATIENCE
        while True:
            status, _, text = self.client.ask("GET", f"/v1/jobs/{identity}?wait={wait}")
            job = json.loads(text) if status == 200 else {"status": str(status)}
            if job["status"] not in ("accepted", "running") or time.monotonic() > until:
                return job

    def check(self, snapshot):
        jobs, clouds, uploads = snapshot
        for identity, promise in jobs.items():
            self.check_job(identity, promise)
        for identity, state in clouds.items():
            status, _, _ = self.client.ask("GET", f"/v1/clouds/{identity}")
            if (state, status) in (("stored", 404), ("gone", 200)):
                self.wrong.append(f"cloud {identity} is {state}, but {status}")
        for identity, upload in uploads.items():
            self.check_upload(identity, upload)

    def check_job(self, identity, promise):
        if promise.get("ended") and promise["sure"] and promise["now"] == "natural":
            if (seen := self.job(identity, wait=0)["status"]) != "successful":
                self.wrong.append(f"job {identity} had ended, and is {seen}")
        job = self.job(identity)
        natural = "failed" if promise["cloud"] < 0 else "successful"
        expected = {"gone": ("410", "404"), "dismissed": ("dismissed",), "natural": (natural,)}[promise["now"]]
        if promise["sure"] and job["status"] not in expected:
            self.wrong.append(f"job {identity} is {job['status']}, not {expected[0]}: {json.dumps(job)[:500]}")
        if job["status"] == "successful":
            self.check_outputs(identity, promise, job)

    def check_outputs(self, identity, promise, job):
        if (done := sum(each["outcome"] == "done" for each in job["attempts"])) != 1:
            self.wrong.append(f"job {identity} ended {done} times")
        mesh = self.output(identity, "mesh.glb")
        if self.meshes.setdefault(promise["cloud"], mesh) != mesh:
            self.wrong.append(f"job {identity}: its cloud has given another mesh before")

    def output(self, identity, name):
        status, headers, body = self.client.ask("GET", f"/v1/jobs/{identity}/outputs/{name}")
        digest = hashlib.sha256(body).hexdigest()
        if status != 200 or headers["ETag"].strip('"') != digest:
            self.wrong.append(f"{name} of job {identity}: {status}, {headers.get('ETag')} for {digest}")
        return digest

    def check_upload(self, identity, upload):
        """What was acknowledged is there; what is whole becomes a cloud, whoever died in between."""
        status, headers, text = self.client.ask("HEAD", f"/v1/uploads/{identity}", headers=TUS)
        if upload["now"] == "unsure":
            return
        if status != (410 if upload["now"] == "gone" else 200):
            self.wrong.append(f"upload {identity} is {upload['now']}, but {status}")
        if status != 200:
            return
        offset = int(headers["Upload-Offset"])
        if offset < upload["offset"]:
            self.wrong.append(f"upload {identity} has {offset} bytes, {upload['offset']} were acknowledged")
        if offset == len(upload["body"]):
            self.check_whole(identity, upload)

    def check_whole(self, identity, upload):
        def cloud_of():
            return self.client.ask("HEAD", f"/v1/uploads/{identity}", headers=TUS)[1].get("Surfaced-Cloud-Id")
        eventually(cloud_of, f"the whole upload {identity} becomes a cloud")
        if cloud_of() != hashlib.sha256(upload["body"]).hexdigest():
            self.wrong.append(f"upload {identity} has become another cloud")
        status, _, _ = self.client.ask("GET", f"/v1/clouds/{cloud_of()}")
        if status != 200:
            self.wrong.append(f"the cloud of upload {identity}: {status}")

    def check_all_outputs(self):
        """Of every successful job that the server lists; returns how many outputs there are."""
        count, target = 0, "/v1/jobs?status=successful&limit=100"
        while target:
            status, _, text = self.client.ask("GET", target)
            if status != 200:
                self.wrong.append(f"{target}: {status} {text[:200]!r}")
                return count
            page = json.loads(text)
            for job in page["jobs"]:
                for link in job["links"]:
                    if "/outputs/" in link["href"]:
                        self.output(job["id"], link["href"].rsplit("/", 1)[1])
                        count += 1
            target = next((link["href"] for link in page["links"] if link["rel"] == "next"), None)
        return count
