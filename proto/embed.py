#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes files as a C++ source that holds their bytes.

usage: embed.py OUTPUT.cpp NAME=FILE...

NAME becomes a function of namespace surfaced::proto, declared in embedded.hpp.
"""
import sys
from pathlib import Path


def definition(name, data):
    lines = [", ".join(str(byte) for byte in data[i : i + 32]) for i in range(0, len(data), 32)]
    rows = ",\n".join(lines)
    return (
        f"namespace {{\nconstexpr unsigned char k_{name}[] = {{\n{rows}}};\n}}\n"
        f"std::string_view surfaced::proto::{name}() {{\n"
        f"  return {{reinterpret_cast<const char*>(k_{name}), sizeof k_{name}}};\n}}\n"
    )


def main():
    output, *pairs = sys.argv[1:]
    parts = ['#include "proto/embedded.hpp"\n']
    for pair in pairs:
        name, file = pair.split("=", 1)
        parts.append(definition(name, Path(file).read_bytes()))
    Path(output).write_text("\n".join(parts), encoding="utf-8")


if __name__ == "__main__":
    main()
