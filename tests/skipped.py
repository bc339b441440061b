#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts and names the tests that were skipped, with their reasons, so that nothing is left out in silence.

usage: skipped.py JUNIT      what `ctest --output-junit JUNIT --test-output-size-passed 1000000` wrote
"""
import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

# What Node's runner says of a test within a file, in its two ways of reporting.
NODE = (re.compile(r"^\s*ok \d+ - (.*?) # SKIP ?(.*)$", re.M), re.compile(r"^\s*﹣ (.*?) \([\d.]+ms\) # (.*)$", re.M))


def reason_of(output):
    """GoogleTest writes the reason between the place and its own line; scripts write `skipped: reason`."""
    found = re.search(r"Skipped\n(.*?)\n+(?:\[|$)", output, re.S) or re.search(r"^skipped: (.*)$", output, re.M)
    return found[1].strip() if found else "no reason is given"


def skipped_in(junit):
    """How many tests there are, and name and reason of each that was skipped."""
    cases = ElementTree.parse(junit).getroot().findall("testcase")
    skipped = []
    for case in cases:
        output = case.findtext("system-out") or ""
        if case.find("skipped") is not None or case.get("status") == "notrun":
            skipped.append((case.get("name"), reason_of(output)))
        for way in NODE:
            skipped += [(f"{case.get('name')}: {name}", reason or "no reason is given") for name, reason in way.findall(output)]
    return len(cases), skipped


def main():
    junit = Path(sys.argv[1])
    if not junit.is_file():
        sys.exit(f"dev: {junit} is missing; the tests did not get so far")
    count, skipped = skipped_in(junit)
    if not skipped:
        print(f"dev: none of {count} tests was skipped")
        return
    print(f"dev: {len(skipped)} tests were skipped, of {count}:")
    for reason in sorted({reason for _, reason in skipped}):
        print(f"dev:   {reason}")
        for name in sorted(name for name, why in skipped if why == reason):
            print(f"dev:     {name}")


if __name__ == "__main__":
    main()
