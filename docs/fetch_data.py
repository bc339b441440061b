#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fetches public models by the manifest data.json: address, SHA-256, licence, credit.

Models without a SHA-256 in the manifest are kept as they come, and their hash is told. Those in formats that surfaced does
not read as clouds (OFF) are written as text of points.
"""
import argparse
import hashlib
import json
import sys
import urllib.error
import urllib.request
from pathlib import Path

MOST = 1 << 30
SECONDS = 60


class Wrong(Exception):
    pass


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


def points_of_off(data):
    """The points of an OFF, a line each."""
    words = (word for line in data.decode("ascii").splitlines() for word in line.split("#")[0].split())
    if next(words, "") != "OFF":
        raise Wrong("the file does not begin with OFF")
    try:
        count = int(next(words))
        next(words), next(words)
        return "".join([f"{next(words)} {next(words)} {next(words)}\n" for _ in range(count)]).encode()
    except (ValueError, StopIteration) as wrong:
        raise Wrong("the file ends before its points do, or has no number of points; fetch it again") from wrong


def take(model, folder):
    path = folder / model["name"]
    data = path.read_bytes() if path.exists() else fetch(model["address"])
    digest = hashlib.sha256(data).hexdigest()
    if model["sha256"] is not None and digest != model["sha256"]:
        raise Wrong(f"{model['name']} has SHA-256 {digest}; the manifest says {model['sha256']}: it is not kept, and where it is on disk already, delete it")
    path.write_bytes(data)
    if path.suffix == ".off":
        path.with_suffix(".xyz").write_bytes(points_of_off(data))
    pinned = "as in the manifest" if model["sha256"] else f"not pinned by the manifest; SHA-256 {digest}"
    return f"{path}: {len(data)} bytes, {pinned}\n  {model['points']} points. {model['credit']}. {model['licence']}"


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
