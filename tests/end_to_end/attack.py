#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Attacks a server by each of the ways below, one after the other and then all at once, while a bystander asks for small
things, and says what that cost: the longest wait of the bystander, the server's peak of memory, the memory of the kernel
for the server's ends of the connections and for both (what attackers do not read waits at their end, here the same
machine's), and the processor time of the server. Every attacker is a process of its own. The promises are 1 s, 300 MB
and 200 MB for the server's ends.

usage: attack.py SURFACED [--seconds N] [--only NAME] [--slack X]
defaults: half a second each, all of them; exit 1 where a wait is more than X (1) times what is promised, or memory is more
"""
import argparse
import http.client
import multiprocessing
import os
import pathlib
import re
import resource
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time

MEBIBYTE = 1 << 20
LONGEST_WAIT, MOST_MEMORY, MOST_KERNEL = 1.0, 300, 200
# A machine that others use keeps nobody's promises; this still tells a server that hangs.
LONGEST_WAIT_BESIDE_OTHERS = 20.0
HEAD = b"Host: 127.0.0.1\r\n"


def connect(port, receive=None):
    link = socket.socket()
    if receive:
        link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive)
    link.settimeout(10)
    link.connect(("127.0.0.1", port))
    return link


def post(path, kind, body):
    return (b"POST " + path.encode() + b" HTTP/1.1\r\n" + HEAD + b"Content-Type: " + kind.encode() +
            b"\r\nContent-Length: " + str(len(body)).encode() + b"\r\n\r\n" + body)


def chunked(path, kind, piece, total):
    one = b"%x\r\n" % len(piece) + piece + b"\r\n"
    return (b"POST " + path.encode() + b" HTTP/1.1\r\n" + HEAD + b"Content-Type: " + kind.encode() +
            b"\r\nTransfer-Encoding: chunked\r\n\r\n" + one * (total // len(one)) + b"0\r\n\r\n")


def crowd(port, size, request, receive=None):
    """As many connections as there are to be had, each with the request sent."""
    links = []
    for _ in range(size):
        try:
            link = connect(port, receive)
            link.sendall(request)
            links.append(link)
        except OSError:
            continue
    return links


def again_and_again(port, until, request, at_once=16):
    """The request on many connections at once, each with its answer read, until the time is over."""
    while time.monotonic() < until:
        links = crowd(port, at_once, request)
        for link in links:
            try:
                link.recv(1 << 16)
            except OSError:
                pass
            link.close()


def hold(links, until, poke=b""):
    while time.monotonic() < until:
        for link in links if poke else ():
            try:
                link.send(poke)
            except OSError:
                pass
        time.sleep(0.1)
    for link in links:
        link.close()


def json_of_many_members(port, until):
    body = b"{" + b",".join(b'"%d":0' % i for i in range(90_000)) + b"}"
    again_and_again(port, until, post("/v1/jobs", "application/json", body[:MEBIBYTE]))


def json_of_every_shape(port, until):
    shapes = [b"[" + b"[]," * 300_000 + b"0]", b"[" * MEBIBYTE, b'"' + b"\\u00e9" * 170_000 + b'"', b"[" + b"1," * 500_000 + b"1]",
              b'{"labels":[' + b'"a",' * 250_000 + b'"a"]}', b"9" * (MEBIBYTE - 1)]
    while time.monotonic() < until:
        for shape in shapes:
            again_and_again(port, min(until, time.monotonic() + 0.05), post("/v1/jobs", "application/json", shape), 4)


def forms(port, until):
    kind = "multipart/form-data; boundary=B"
    part = b"--B\r\nContent-Disposition: form-data; name=\"a\"\r\n\r\nx\r\n"
    almost = b"--B\r\nContent-Disposition: form-data; name=\"cloud\"; filename=\"c\"\r\n\r\n" + b"\r\n--A" * 200_000
    while time.monotonic() < until:
        for body in (part * 20_000, almost, b"--B\r\n" + b"X: y\r\n" * 170_000):
            again_and_again(port, min(until, time.monotonic() + 0.05), post("/v1/jobs", kind, body[:MEBIBYTE]), 4)


def chunks_of_one_byte(port, until):
    again_and_again(port, until, chunked("/v1/clouds", "application/octet-stream", b"x", MEBIBYTE), 8)


def queries_and_headers(port, until):
    requests = [b"GET /v1/jobs?" + b"a=&" * 2_600 + b" HTTP/1.1\r\n" + HEAD + b"\r\n",
                b"POST /v1/jobs?" + b"&".join(b"p%d=1" % i for i in range(190)) + b" HTTP/1.1\r\n" + HEAD + b"Content-Length: 1\r\n\r\nx",
                b"GET /v1/jobs HTTP/1.1\r\n" + HEAD + b"X-Forwarded-For: 1.1.1.1\r\n" * 90 + b"Accept: " + b"a/b," * 7_000 + b"\r\n\r\n"]
    while time.monotonic() < until:
        for request in requests:
            again_and_again(port, min(until, time.monotonic() + 0.05), request)


def heads_that_do_not_end(port, until):
    hold(crowd(port, 1_200, b"GET / HTTP/1.1\r\n" + HEAD + b"X: " + b"x" * 30_000), until, b"x")


def bodies_that_trickle(port, until):
    hold(crowd(port, 300, b"POST /v1/clouds HTTP/1.1\r\n" + HEAD + b"Content-Length: 1000000\r\n\r\n"), until, b"x")


def readers_that_take_nothing(port, until):
    request = b"GET /openapi.json HTTP/1.1\r\n" + HEAD + b"\r\n"
    hold(crowd(port, 900, request * 20), until)


def readers_of_meshes_that_take_nothing(port, until):
    hold(crowd(port, 900, b"GET " + os.environ["MESH"].encode() + b" HTTP/1.1\r\n" + HEAD + b"\r\n"), until)


def readers_of_lists_that_take_nothing(port, until):
    # Answers that are made in memory, as large as there are.
    hold(crowd(port, 900, b"GET /v1/methods HTTP/1.1\r\n" + HEAD + b"Connection: close\r\n\r\n", 4096), until)


def requests_behind_each_other(port, until):
    request = b"GET /v1/methods/poisson HTTP/1.1\r\n" + HEAD + b"\r\n"
    again_and_again(port, until, request * 200, 32)


def streams_and_polls(port, until):
    job = os.environ["JOB"].encode()
    links = crowd(port, 700, b"GET " + job + b"/events HTTP/1.1\r\n" + HEAD + b"\r\n")
    links += crowd(port, 300, b"GET " + job + b"?wait=20 HTTP/1.1\r\n" + HEAD + b"\r\n")
    hold(links, until)


def connections_that_come_and_go(port, until):
    at_once = struct.pack("ii", 1, 0)
    while time.monotonic() < until:
        for link in crowd(port, 200, b"GET /v1/methods HTTP/1.1\r\n" + HEAD + b"\r\n"):
            link.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, at_once)
            link.close()


ATTACKS = (json_of_many_members, json_of_every_shape, forms, chunks_of_one_byte, queries_and_headers, heads_that_do_not_end,
           bodies_that_trickle, readers_that_take_nothing, readers_of_meshes_that_take_nothing, readers_of_lists_that_take_nothing,
           requests_behind_each_other, streams_and_polls, connections_that_come_and_go)


def watch(port, until, waits):
    """Asks for something small all the time; the longest wait, and the longest time that the machine let nobody run."""
    longest = overslept = 0.0
    while time.monotonic() < until:
        for method, target, body in (("GET", "/healthz", None), ("GET", "/v1/jobs", None), ("POST", "/v1/clouds", b"x" * 100)):
            began = time.monotonic()
            link = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
            try:
                link.request(method, target, body)
                status = link.getresponse().status
                # Who has no place for a body is told to come back: that is an answer.
                if status not in (200, 201, 503):
                    longest = 1000.0
            except OSError:
                longest = 2000.0
            link.close()
            longest = max(longest, time.monotonic() - began)
            began = time.monotonic()
            time.sleep(0.01)
            overslept = max(overslept, time.monotonic() - began - 0.01)
    waits.send((longest, overslept))


def kernel_megabytes_of_server(port):
    """What the kernel holds for the connections of a port, as it tells through NETLINK_SOCK_DIAG: received, to be sent and
    reserved."""
    by_family, dump, memory, error, done = 20, 0x301, 7, 2, 3
    end = struct.Struct(">HH16s16s12x")
    total = 0
    with socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, 4) as link:
        asked = struct.pack("=BBBxI", socket.AF_INET, socket.IPPROTO_TCP, 1 << (memory - 1), 0xFFFFFFFF) + end.pack(port, 0, b"", b"")
        link.send(struct.pack("=IHHII", 16 + len(asked), by_family, dump, 1, 0) + asked)
        while True:
            answer, at = link.recv(1 << 20), 0
            while at + 16 <= len(answer):
                length, kind = struct.unpack_from("=IH", answer, at)
                if kind == done:
                    return total / 1e6
                if kind == error:
                    raise OSError("the kernel does not tell what connections hold")
                attribute = at + 16 + 72
                while attribute + 4 <= at + length:
                    size, name = struct.unpack_from("=HH", answer, attribute)
                    if name == memory:
                        received, _, _, _, reserved, queued, _, backlog = struct.unpack_from("=8I", answer, attribute + 4)
                        total += received + reserved + queued + backlog
                    attribute += (size + 3) & ~3
                at += (length + 3) & ~3


def kernel_megabytes():
    """What TCP holds on this machine."""
    pages = int(re.search(r"^TCP: .*\bmem (\d+)", pathlib.Path("/proc/net/sockstat").read_text(), re.M).group(1))
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def peak_megabytes(pid):
    return int(re.search(r"VmHWM:\s+(\d+)", pathlib.Path(f"/proc/{pid}/status").read_text()).group(1)) / 1000


def ticks(path, fields):
    words = pathlib.Path(path).read_text().rsplit(")", 1)[-1].split()
    return sum(int(words[i]) for i in fields)


class Machine:
    """How much of it others have: what is busy and belongs neither to the server nor to the attackers."""

    def __init__(self, pid):
        self.pid, self.begin = pid, None
        self.begin = self.now()

    def now(self):
        line = [int(word) for word in pathlib.Path("/proc/stat").read_text().splitlines()[0].split()[1:9]]
        ours = ticks(f"/proc/{self.pid}/stat", (11, 12, 13, 14)) + sum(os.times()[:4]) * os.sysconf("SC_CLK_TCK")
        return sum(line), sum(line) - line[3] - line[4], ours

    def others(self):
        (all0, busy0, ours0), (all1, busy1, ours1) = self.begin, self.now()
        return max(0.0, (busy1 - busy0) - (ours1 - ours0)) / max(1, all1 - all0)


class Server:
    def __init__(self, binary, folder):
        self.process = subprocess.Popen(
            [binary, "serve", "--listen", "127.0.0.1:0", "--data", os.path.join(folder, "data"), "--workers", "1", "--log-level", "error"],
            stdout=subprocess.PIPE, text=True)
        self.port = int(re.search(r":(\d+)$", self.process.stdout.readline().strip()).group(1))

    def call(self, method, target, body=None):
        link = http.client.HTTPConnection("127.0.0.1", self.port, timeout=120)
        link.request(method, target, body)
        return link.getresponse()

    def make_mesh(self):
        """A job, and a mesh of several megabytes."""
        points = b"".join(struct.pack("<3f", x / 150, y / 150, ((x * 7 + y * 3) % 11) / 3000) for x in range(150) for y in range(150))
        head = f"ply\nformat binary_little_endian 1.0\nelement vertex {150 * 150}\n".encode()
        head += b"property float x\nproperty float y\nproperty float z\nend_header\n"
        answer = self.call("POST", "/v1/jobs?method=advancing-front&outputs=mesh.stl", head + points)
        job = answer.headers["Location"]
        assert answer.status == 201, answer.read()
        while b'"successful"' not in self.call("GET", job + "?wait=20").read():
            pass
        os.environ["JOB"], os.environ["MESH"] = job, job + "/outputs/mesh.stl"


def run(server, attacks, seconds):
    """Returns what it cost; the bystander begins before the attackers and ends with them."""
    mine, its = multiprocessing.Pipe()
    machine, kernel, most_kernel, most_of_server = Machine(server.process.pid), kernel_megabytes(), 0.0, 0.0
    before = ticks(f"/proc/{server.process.pid}/stat", (11, 12))
    until = time.monotonic() + seconds
    workers = [multiprocessing.Process(target=watch, args=(server.port, until, its))]
    workers += [multiprocessing.Process(target=attack, args=(server.port, until)) for attack in attacks]
    for worker in workers:
        worker.start()
    while not select.select([mine], [], [], 0.05)[0]:
        most_kernel = max(most_kernel, kernel_megabytes() - kernel)
        most_of_server = max(most_of_server, kernel_megabytes_of_server(server.port))
    longest, overslept = mine.recv()
    for worker in workers:
        worker.join()
    spent = (ticks(f"/proc/{server.process.pid}/stat", (11, 12)) - before) / os.sysconf("SC_CLK_TCK")
    return max(0.0, longest - overslept), most_of_server, most_kernel, spent, machine.others()


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("surfaced")
    arguments.add_argument("--seconds", type=float, default=0.5)
    arguments.add_argument("--only", default="")
    arguments.add_argument("--slack", type=float, default=1)
    options = arguments.parse_args()
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    multiprocessing.set_start_method("fork")
    rounds = [([attack], options.seconds) for attack in ATTACKS if options.only in attack.__name__]
    if not options.only:
        rounds.append((ATTACKS, 6 * options.seconds))
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        server = Server(options.surfaced, folder)
        server.make_mesh()
        print("| attack | longest wait | server's peak | kernel, its ends | kernel, both ends | processor |\n|---|---|---|---|---|---|")
        for attacks, seconds in rounds:
            name = attacks[0].__name__.replace("_", " ") if len(attacks) == 1 else "all of these at once"
            waited, kernel, both, spent, others = run(server, attacks, seconds)
            peak = peak_megabytes(server.process.pid)
            print(f"| {name} | {waited * 1000:.0f} ms | {peak:.0f} MB | {kernel:.0f} MB | {both:.0f} MB | {spent:.1f} s |"
                  + (f" beside {others:.0%} of others" if others > 0.1 else ""), flush=True)
            # Attackers are on the machine, too: all at once take its processors from the bystander.
            if waited > options.slack * (LONGEST_WAIT_BESIDE_OTHERS if others > 0.1 else LONGEST_WAIT):
                wrong.append(f"{name}: another client waited for {waited:.2f} s")
            if peak > MOST_MEMORY or kernel > MOST_KERNEL:
                wrong.append(f"{name}: {peak:.0f} MB of the server, {kernel:.0f} MB of the kernel")
        server.process.send_signal(signal.SIGTERM)
        if server.process.wait(60) != 0:
            wrong.append("the server did not end as it should")
    for each in wrong:
        print("wrong:", each)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
