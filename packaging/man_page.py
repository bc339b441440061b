#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the manual page: the template, with every setting of the service as the program itself lists them.

usage: man_page.py TEMPLATE SURFACED OUTPUT       the line `.\\" SETTINGS` of TEMPLATE is replaced
"""
import json
import subprocess
import sys
from pathlib import Path

MARK = '.\\" SETTINGS\n'


def roff(text):
    """Text in which dashes stay dashes, and no line begins with what troff takes for a request."""
    return text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq").replace("`", "\\(ga")


def entry(setting):
    name = setting["name"]
    value = setting["value"] or "none"
    return (f".TP\n.BR \\-\\-{roff(name)} \" \\fI{roff(setting['allowed'])}\\fR\"\n{roff(setting['description'])}. "
            f"Default: {roff(value)}. Variable: SURFACED_{name.upper().replace('-', '_')}.\n")


def main():
    template, program, output = sys.argv[1:]
    # Without --data it says so and ends with 2; the list is whole all the same. No variable of this machine counts.
    listed = subprocess.run([program, "check-config", "--json"], capture_output=True, text=True, env={})
    settings = json.loads(listed.stdout)["settings"]
    text = Path(template).read_text(encoding="utf-8")
    if MARK not in text:
        sys.exit(f"{template} has no line {MARK.strip()}")
    Path(output).write_text(text.replace(MARK, "".join(map(entry, settings))), encoding="utf-8")


if __name__ == "__main__":
    main()
