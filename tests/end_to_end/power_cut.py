#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cuts the power of a server at random moments while a client submits, stores, uploads, cancels, deletes and retries: starts
another server on what would be left of its data folder, and holds it to everything that was acknowledged before the cut.

  shadow   what is left is what was synced, by a library that is preloaded into the server (power_cut.cpp); at every other cut
           each file and folder that was changed since has, by the toss of a coin, its newer state. Needs no privilege.
  loop     the data folder lies on an ext4 of its own, whose image is copied while the server stands still. Needs mounts;
           ends with 77, "skipped", where they are impossible.

usage: power_cut.py SURFACED (shadow LIBRARY | loop) [--cuts N] [--seed N]      defaults: 4 cuts, seed 1
"""
import argparse
import contextlib
import fcntl
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

from mortal import Client, Judge, Server

SKIPPED = 77
IMAGE_BYTES = 96 << 20


class Shadow:
    """The folder as it was synced, and as it is."""

    def __init__(self, folder, library):
        self.data, self.shadow, self.library = folder / "data", folder / "shadow", library
        for each in (self.data, self.shadow / "files", self.shadow / "folders"):
            each.mkdir(parents=True)

    def environment(self):
        return {"LD_PRELOAD": str(self.library), "POWER_CUT_SHADOW": str(self.shadow)}

    @contextlib.contextmanager
    def held(self, _):
        """Nothing can be synced, and so nothing acknowledged, meanwhile."""
        with open(self.shadow / "lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield

    def leave(self, target, chance, number):
        """Makes what is left; to be called while it is held."""
        self.chance = chance if number % 2 else None
        root = next(each for each in (self.shadow / "folders").iterdir()
                    if each.name.startswith(f"{self.data.stat().st_ino}-"))
        self.make_folder(root.name, self.data, target)
        return contextlib.nullcontext(target)

    def newer(self):
        return self.chance is not None and self.chance.random() < 0.5

    def entries(self, key, now):
        """Name, kind and key of what a folder has, by what was synced; or as it is."""
        file = self.shadow / "folders" / key
        known = {name: (kind, each) for kind, each, name in
                 (line.split(" ", 2) for line in file.read_text().splitlines())} if file.exists() else {}
        if self.newer() and now.is_dir():
            names = {each.name for each in now.iterdir()}
            known = {name: each for name, each in known.items() if name in names}
            for name in names - set(known):
                known[name] = ("d" if (now / name).is_dir() else "f", "")
        return known

    def make_folder(self, key, now, target):
        target.mkdir(parents=True)
        for name, (kind, each) in self.entries(key, now).items():
            if kind == "d":
                self.make_folder(each or "none", now / name, target / name)
            else:
                self.make_file(each, now / name, target / name)

    def make_file(self, key, now, target):
        synced = self.shadow / "files" / key
        with contextlib.suppress(OSError):  # it may go while it is copied
            if self.newer():
                shutil.copyfile(now, target)
                return
        if key and synced.exists():
            shutil.copyfile(synced, target)
        else:
            target.touch()  # a name that was synced, of a file that was not


class Loop:
    """An ext4 of its own in a file."""

    def __init__(self, folder):
        self.folder, self.image, self.mounted = folder, folder / "image", []
        with open(self.image, "wb") as image:
            image.truncate(IMAGE_BYTES)
        self.run("mkfs.ext4", "-q", "-F", str(self.image))
        self.mount(self.image, folder / "disk")
        self.data = folder / "disk" / "data"
        device = self.run("findmnt", "-n", "-o", "SOURCE", str(folder / "disk")).strip()
        self.writes = pathlib.Path("/sys/block") / os.path.basename(device) / "stat"

    @staticmethod
    def run(*command):
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout

    def mount(self, image, where):
        where.mkdir()
        self.run("mount", "-o", "loop", str(image), str(where))
        self.mounted.append(where)

    def environment(self):
        return {}

    @contextlib.contextmanager
    def held(self, server):
        server.process.send_signal(signal.SIGSTOP)
        try:
            yield
        finally:
            server.process.send_signal(signal.SIGCONT)

    def leave(self, target, _chance, _number):
        """A copy during which the kernel wrote nothing: only such a one is a state of one moment."""
        target.mkdir()
        while True:
            before = self.writes.read_text().split()[4:9]
            self.run("cp", "--sparse=always", str(self.image), str(target / "image"))
            if self.writes.read_text().split()[4:9] == before:
                return self.opened(target)

    @contextlib.contextmanager
    def opened(self, target):
        self.mount(target / "image", target / "disk")
        try:
            yield target / "disk" / "data"
        finally:
            self.unmount(target / "disk")

    def unmount(self, where):
        subprocess.run(["umount", str(where)], check=False)
        self.mounted.remove(where)

    def close(self):
        for where in list(self.mounted):
            self.unmount(where)


def check(binary, data, snapshot, seed):
    """Starts a server on what was left, and another on its backup: that reads every file and compares it with its record."""
    with Server(binary, data) as server:
        client = Client(server, seed)
        Judge(server, client).check(snapshot)
        if server.end() != 0:
            client.wrong.append("the server on what was left did not end with 0")
    copy = pathlib.Path(f"{data}.backup")
    said = subprocess.run([binary, "backup", str(copy), "--data", str(data)], capture_output=True, text=True)
    if said.returncode != 0:
        client.wrong.append(f"what was left is not whole: {said.stderr}")
    shutil.rmtree(copy, ignore_errors=True)
    return client.wrong


def cut_again_and_again(binary, disk, folder, cuts, seed):
    chance, ended, left = random.Random(seed), threading.Event(), []
    with Server(binary, disk.data, environment=disk.environment()) as server:
        client = Client(server, seed, name="client")

        def work():
            while not ended.is_set():
                client.act()

        thread = threading.Thread(target=work)
        thread.start()
        for number in range(cuts):
            time.sleep(0.2 + chance.random() * 0.8)
            with disk.held(server):
                snapshot = client.promises.snapshot()
                left.append((disk.leave(folder / f"cut{number}", chance, number), snapshot))
        ended.set()
        thread.join()
        wrong = client.wrong + ([] if server.end() == 0 else ["the server did not end with 0"])
    counts = [0, 0, 0]
    for number, (remains, snapshot) in enumerate(left):
        with remains as data:
            wrong += [f"cut {number}: {each}" for each in check(binary, data, snapshot, seed)]
        counts = [count + len(part) for count, part in zip(counts, snapshot)]
    print(f"{cuts} cuts; held to {counts[0]} jobs, {counts[1]} clouds, {counts[2]} uploads; {len(wrong)} wrong")
    return wrong


def open_disk(options, folder):
    if options.kind == "shadow":
        return Shadow(folder, os.path.abspath(options.library))
    try:
        return Loop(folder)
    except (OSError, subprocess.CalledProcessError) as error:
        print(f"skipped: no file system can be mounted from a file here ({error})")
        sys.exit(SKIPPED)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("surfaced")
    parser.add_argument("kind", choices=("shadow", "loop"))
    parser.add_argument("library", nargs="?")
    parser.add_argument("--cuts", type=int, default=4)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        disk = open_disk(options, folder)
        try:
            wrong = cut_again_and_again(os.path.abspath(options.surfaced), disk, folder, options.cuts, options.seed)
        finally:
            if isinstance(disk, Loop):
                disk.close()
    for line in wrong[:40]:
        print(line, file=sys.stderr)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
