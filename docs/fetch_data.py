#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fetches the public models that the tests look for, by the manifest data.json: address, SHA-256, licence, credit.

What is fetched and what is made of it are pinned by hash; a file that is there already, as it should be, is not fetched
again. Clouds come as PLY, binary, float32, in the order of their source; where that is a mesh, it is reference/NAME.ply.
"""
import argparse
import hashlib
import json
import shutil
import subprocess
import sys
import tempfile
import urllib.error
import urllib.request
from pathlib import Path

import model_files

MOST = 1 << 30
SECONDS = 60


class Wrong(Exception):
    pass


def sha256(data):
    return hashlib.sha256(data).hexdigest()


def fetch(address):
    try:
        with urllib.request.urlopen(address, timeout=SECONDS) as answer:
            data = answer.read(MOST + 1)
    except (urllib.error.URLError, OSError) as failure:
        reason = getattr(failure, "reason", failure)
        raise Wrong(f"{address} cannot be fetched: {reason}; check the network, or put the file there by hand") from None
    if len(data) > MOST:
        raise Wrong(f"{address} has more than {MOST} bytes")
    return data


def pinned(what, data, digest):
    if sha256(data) != digest:
        raise Wrong(f"{what} has SHA-256 {sha256(data)}; the manifest says {digest}: it is not kept")
    return data


def wanted_files(model, folder):
    """Where the files of a model are to be, and their hashes."""
    wanted = {folder / model["name"]: model["sha256"]}
    if "reference_sha256" in model:
        wanted[folder / "reference" / model["name"]] = model["reference_sha256"]
    return wanted


def is_there(path, digest):
    return path.is_file() and sha256(path.read_bytes()) == digest


def encoded(model, folder):
    """A Draco file, made of a cloud that the manifest has too."""
    tool = shutil.which("draco_encoder")
    if tool is None:
        raise Wrong(f"{model['name']} is made by draco_encoder 1.5, which is not here; Debian's package draco brings it")
    with tempfile.TemporaryDirectory() as scratch:
        out = Path(scratch, "out.drc")
        ran = subprocess.run([tool, "-point_cloud", "-i", folder / model["encoded_from"], "-o", out, *model["arguments"]], capture_output=True, text=True)
        if ran.returncode != 0:
            raise Wrong(f"{model['name']}: draco_encoder failed: {ran.stdout}{ran.stderr}")
        return [out.read_bytes()]


def made(model):
    """The contents of the model's files, from its source."""
    source = pinned(model["address"], fetch(model["address"]), model["source_sha256"])
    suffix = Path(model["address"]).suffix
    if suffix == Path(model["name"]).suffix == ".drc":
        return [source]
    try:
        cloud = model_files.READERS[suffix](source)
    except (ValueError, IndexError, KeyError, StopIteration) as wrong:
        raise Wrong(f"{model['address']} cannot be read: {wrong!r}") from None
    return [model_files.cloud_bytes(cloud)] + ([model_files.mesh_bytes(cloud)] if "reference_sha256" in model else [])


def take(model, folder):
    wanted = wanted_files(model, folder)
    state = "was there"
    if not all(is_there(path, digest) for path, digest in wanted.items()):
        contents = encoded(model, folder) if "encoded_from" in model else made(model)
        for (path, digest), data in zip(wanted.items(), contents):
            pinned(str(path), data, digest)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        state = "fetched"
    return f"{folder / model['name']}: {state}, {model['points']} points. {model['credit']}. {model['licence']}"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=Path("build/models"))
    parser.add_argument("names", nargs="*", help="models to fetch; all without one")
    parser.add_argument("--manifest", type=Path, default=Path(__file__).with_name("data.json"))
    options = parser.parse_intermixed_args()
    models = json.loads(options.manifest.read_text(encoding="utf-8"))["models"]
    known = [model["name"] for model in models]
    failed = [f"{name} is unknown; there are: {', '.join(known)}" for name in options.names if name not in known]
    options.folder.mkdir(parents=True, exist_ok=True)
    for model in models:
        if options.names and model["name"] not in options.names:
            continue
        try:
            print(take(model, options.folder), flush=True)
        except Wrong as wrong:
            failed.append(str(wrong))
    for each in failed:
        print(f"dev data: {each}", file=sys.stderr)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
