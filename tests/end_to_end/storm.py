#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kills a server with SIGKILL again and again while clients of three keys submit, store, upload, cancel, delete, retry and ask
for other formats, webhooks are sent and backups are made, some of which are killed, too. In the end every acknowledged job has
ended once, as it was promised; every upload that was whole is a cloud; every webhook has come; every backup that said done
verifies, has what was acknowledged before it began, and serves every successful output with its hash; and the data folder
holds what its records refer to and not a file more, with the counters of all keys right.

usage: storm.py SURFACED [--kills N] [--seed N]      defaults: 8 kills, seed 1; the long form: ./dev storm 200
"""
import argparse
import collections
import http.server
import json
import os
import pathlib
import random
import re
import shutil
import sqlite3
import ssl
import subprocess
import sys
import tempfile
import threading
import time

from mortal import PATIENCE, Client, Judge, Server, eventually

CLIENTS = 3


def certificate(folder):
    key, pem = folder / "key.pem", folder / "certificate.pem"
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "1",
         "-subj", "/CN=storm", "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", key, "-out", pem],
        check=True, stderr=subprocess.DEVNULL)
    return key, pem


class Receiver:
    """Takes webhooks and notes of which jobs."""

    def __init__(self, key, pem):
        self.jobs = collections.Counter()

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(handler):  # noqa: N802, N805
                body = handler.rfile.read(int(handler.headers["Content-Length"]))
                self.jobs[json.loads(body)["data"]["id"]] += 1
                handler.send_response(204)
                handler.end_headers()

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(pem, key)
        self.server.socket = context.wrap_socket(self.server.socket, server_side=True, do_handshake_on_connect=False)
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        self.url = f"https://127.0.0.1:{self.server.server_port}/hook"


class Backups:
    """Makes one backup after the other; some are killed on their way."""

    def __init__(self, binary, data, folder, clients, seed):
        self.binary, self.data, self.folder, self.clients = binary, data, folder, clients
        self.random, self.wrong = random.Random(seed), []
        self.done, self.killed, self.outputs = 0, 0, 0

    def run(self, ended):
        number = 0
        while not ended.is_set():
            number += 1
            target = self.folder / f"backup{number}"
            try:
                self.make(target)
            except Exception as error:  # every kind: the thread has nobody else to tell
                self.wrong.append(f"backup {number}: {type(error).__name__}: {error}")
            shutil.rmtree(target, ignore_errors=True)

    def make(self, target):
        before = [client.promises.snapshot() for client in self.clients]
        command = [self.binary, "backup", str(target), "--data", str(self.data)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if self.random.random() < 0.25:
            time.sleep(self.random.random() * 0.1)
            process.kill()
        said = process.communicate(timeout=PATIENCE)[0]
        if process.returncode == -9:
            self.killed += 1
            if (target / "backup.json").exists():
                return  # killed after it was done
            if subprocess.run([self.binary, "backup", "--verify", str(target)], capture_output=True).returncode == 0:
                self.wrong.append("a backup that was killed verifies")
            return
        if process.returncode != 0:
            self.wrong.append(f"a backup failed: {said}")
            return
        self.check(target, before)

    def check(self, target, before):
        """A copy that said done is served; what was promised before it began, and still is, is in it."""
        verified = subprocess.run([self.binary, "backup", "--verify", str(target)], capture_output=True, text=True)
        if verified.returncode != 0:
            self.wrong.append(f"a backup does not verify: {verified.stderr}")
        after = [client.promises.snapshot() for client in self.clients]
        with Server(self.binary, target) as copy:
            client = Client(copy, 0, name="backup")
            self.outputs += Judge(copy, client).check_all_outputs()
            for (jobs, _, uploads), (now, _, later) in zip(before, after):
                for identity, promise in jobs.items():
                    if promise == now[identity] and promise["sure"] and promise["now"] != "gone":
                        status, _, _ = client.ask("GET", f"/v1/jobs/{identity}")
                        client.expect(status, (200,), f"job {identity} in a backup")
                for identity, upload in uploads.items():
                    if upload["now"] == "open" and later[identity]["now"] == "open":
                        status, headers, _ = client.ask("HEAD", f"/v1/uploads/{identity}", headers={"Tus-Resumable": "1.0.0"})
                        if status != 200 or int(headers["Upload-Offset"]) < upload["offset"]:
                            self.wrong.append(f"upload {identity} in a backup: {status}")
            copy.end()
        self.wrong += client.wrong
        self.done += 1


def make_key(binary, file, name):
    said = subprocess.run([binary, "keys", "add", str(file), "--name", name, "--scopes", "read,submit",
                           "--requests-per-minute", "0", "--submissions-per-minute", "0"],
                          check=True, capture_output=True, text=True).stdout
    return re.search(r"sfd_\w+", said).group(0)


def come_and_go(client, ended):
    while not ended.is_set():
        try:
            client.act()
        except Exception as error:  # every kind: the thread has nobody else to tell
            client.wrong.append(f"{client.name}: {type(error).__name__}: {error}")


def kill_again_and_again(server, kills, seed):
    chance = random.Random(seed)
    done = 0
    while done < kills:
        time.sleep(0.05 + chance.random() * 0.6)
        server.end(kill=True)
        done += 1
        if chance.random() < 0.25:
            server.kill_while_it_starts(chance.random() * 0.06)
            done += 1
        server.start()


def strays(data):
    """Files of the data folder that no record refers to, and files that records refer to and that are not there."""
    database = sqlite3.connect(f"file:{data / 'jobs.sqlite'}?mode=ro", uri=True)
    known = {f"inputs/{key}" for (key,) in database.execute(
        "SELECT input_key FROM jobs WHERE removed_at IS NULL UNION SELECT id FROM clouds")}
    known |= {f"outputs/{job}-{attempt}/{name}" for job, attempt, name in database.execute(
        "SELECT job, attempt, name FROM outputs")}
    known |= {f"partial/{identity}.bytes" for (identity,) in database.execute(
        "SELECT id FROM uploads WHERE cloud = '' AND gone = 0 AND offset > 0")}
    begun = {f"partial/{identity}.bytes" for (identity,) in database.execute(
        "SELECT id FROM uploads WHERE cloud = '' AND gone = 0 AND offset = 0")}
    columns = "owner, active_jobs, bytes"
    drift = database.execute(
        f"SELECT * FROM (SELECT {columns} FROM holdings WHERE bytes <> 0 OR active_jobs <> 0 EXCEPT SELECT {columns} FROM held) "
        f"UNION ALL SELECT * FROM (SELECT {columns} FROM held WHERE bytes <> 0 OR active_jobs <> 0 EXCEPT SELECT {columns} "
        "FROM holdings)").fetchall()
    database.close()
    there = set()
    for room in ("inputs", "outputs", "partial", "uploads", "attempts"):
        there |= {str(each.relative_to(data)) for each in (data / room).rglob("*") if not each.is_dir()}
        there |= {str(each.relative_to(data)) for each in (data / room).rglob("*") if each.is_dir() and not any(each.iterdir())}
    return ([f"{each} has no record" for each in there - known - begun] + [f"{each} is missing" for each in known - there] +
            [f"counted wrong: {each}" for each in drift])


def check_doubles(clients, wrong):
    """No submission has made two jobs, however often it was sent."""
    for client in clients:
        labels, target = collections.Counter(), "/v1/jobs?limit=100"
        while target:
            page = json.loads(client.ask("GET", target)[2])
            for job in page["jobs"]:
                if job["labels"][0].startswith(client.name + "-"):
                    labels[job["labels"][0]] += 1
            target = next((link["href"] for link in page["links"] if link["rel"] == "next"), None)
        wrong += [f"{label} has made {count} jobs" for label, count in labels.items() if count > 1]


def judge(server, clients, receiver):
    wrong = []
    for client in clients:
        Judge(server, client).check(client.promises.snapshot())
        told = {identity for identity, each in client.promises.jobs.items()
                if each["hook"] and each["sure"] and each["now"] == "natural"}
        eventually(lambda missing=told: all(receiver.jobs[each] for each in missing), "every webhook comes")
        wrong += client.wrong
    check_doubles(clients, wrong)
    return wrong


def storm(binary, folder, kills, seed):
    key, pem = certificate(folder)
    receiver = Receiver(key, pem)
    (folder / "secret").write_text("a secret of more than sixteen characters\n")
    # A key each: what one deletes stays promised to the others, who have sent the same clouds.
    keys = [make_key(binary, folder / "keys.json", f"key {i}") for i in range(CLIENTS)]
    flags = ["--keys", folder / "keys.json", "--webhook-secret", folder / "secret", "--webhook-private", "yes",
             "--webhook-certificates", pem]
    ended = threading.Event()
    with Server(binary, folder / "data", map(str, flags)) as server:
        clients = [Client(server, seed * 100 + i, keys[i], receiver.url, f"client{i}") for i in range(CLIENTS)]
        backups = Backups(binary, folder / "data", folder, clients, seed)
        threads = [threading.Thread(target=come_and_go, args=(client, ended)) for client in clients]
        threads.append(threading.Thread(target=backups.run, args=(ended,)))
        for thread in threads:
            thread.start()
        kill_again_and_again(server, kills, seed)
        ended.set()
        for thread in threads:
            thread.join()
        wrong = backups.wrong + judge(server, clients, receiver)
        if server.end() != 0:
            wrong.append("the server did not end with 0")
        server.start()
        server.end()
        wrong += strays(folder / "data")
    promises = [client.promises for client in clients]
    print(f"{kills} kills; acknowledged: {sum(len(each.jobs) for each in promises)} jobs, "
          f"{sum(len(each.uploads) for each in promises)} uploads; {sum(receiver.jobs.values())} webhooks; "
          f"{backups.done} backups served with {backups.outputs} outputs, {backups.killed} killed; {len(wrong)} wrong")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("surfaced")
    parser.add_argument("--kills", type=int, default=8)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        wrong = storm(os.path.abspath(options.surfaced), pathlib.Path(folder), options.kills, options.seed)
    for line in wrong[:40]:
        print(line, file=sys.stderr)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
