# SPDX-License-Identifier: GPL-3.0-or-later
"""The rooms of server/ and their arrows: what the targets name, what the files include, what the compiler finds, and what
server/README.md draws are the same.   arrows_test.py SOURCE BUILD"""
import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

SOURCE, BUILD = (pathlib.Path(argument) for argument in sys.argv[1:3])
SERVER = SOURCE / "server"
# Generated or not rooms; what core/ offers to server/.
FOLDERS_BESIDE = {"proto", "web"}
CORE_OFFERS = {"base", "io", "reconstruction"}
TARGETS = {"surfaced::proto": "proto", "surfaced::viewer": "web"}


def named_by(text, kind):
    """The rooms behind PUBLIC or PRIVATE in a call of server_room."""
    words = re.search(rf"\b{kind}\b([^)]*?)(?:\b(?:PUBLIC|PRIVATE)\b|\))", text, re.DOTALL)
    names = words.group(1).split() if words else []
    rooms = {name for name in names if "::" not in name}
    rooms |= {name.removeprefix("surfaced::") for name in names if name.startswith("surfaced::") and name not in TARGETS}
    return rooms | {TARGETS[name] for name in names if name in TARGETS}


ROOMS = [line[17:-1] for line in (SERVER / "CMakeLists.txt").read_text().splitlines() if line.startswith("add_subdirectory(")]
ROOMS = [room for room in ROOMS if room not in ("web", "command")]
CALLS = {room: (SERVER / room / "CMakeLists.txt").read_text() for room in ROOMS}
PUBLIC = {room: named_by(CALLS[room], "PUBLIC") for room in ROOMS}
PRIVATE = {room: named_by(CALLS[room], "PRIVATE") for room in ROOMS}


def reached(room):
    """What the target of a room finds: what it names, and what that shows in its headers."""
    found, left = {room}, list(PUBLIC[room] | PRIVATE[room])
    while left:
        each = left.pop()
        if each not in found:
            found.add(each)
            left += PUBLIC.get(each, ())
    return found


def included(room, suffix):
    texts = [path.read_text() for path in (SERVER / room).rglob("*" + suffix)]
    return {folder for text in texts for folder in re.findall(r'^#include "([a-z_]+)/', text, re.MULTILINE)} - {room}


def command_of(room):
    """The compiler and its flags for the files of a room."""
    for entry in json.loads((BUILD / "compile_commands.json").read_text()):
        if f"/surfaced_server_{room}.dir/" in entry["command"]:
            words = shlex.split(entry["command"])
            if "ccache" in words[0]:
                words = words[1:]
            return words[:words.index("-o")], entry["directory"]
    raise AssertionError(f"compile_commands.json has no file of {room}")


class Arrows(unittest.TestCase):
    def test_every_include_has_an_arrow_of_its_own_and_every_arrow_an_include(self):
        for room in ROOMS:
            with self.subTest(room=room):
                headers, sources = included(room, ".hpp"), included(room, ".cpp")
                self.assertEqual(PUBLIC[room], headers, "PUBLIC in CMakeLists.txt, and what headers include")
                self.assertEqual(PRIVATE[room], sources - headers, "PRIVATE, and what only sources include")

    def test_no_arrow_runs_back(self):
        for at, room in enumerate(ROOMS):
            behind = set(ROOMS[at:]) & (PUBLIC[room] | PRIVATE[room])
            self.assertFalse(behind, f"{room} stands before what it uses")

    def test_of_core_only_what_it_offers_is_used(self):
        for room in [*ROOMS, "command"]:
            foreign = (included(room, ".hpp") | included(room, ".cpp")) - {*ROOMS, "command"} - FOLDERS_BESIDE
            self.assertLessEqual(foreign, CORE_OFFERS, room)

    def test_the_compiler_finds_no_room_that_no_arrow_leads_to(self):
        headers = {room: next((SERVER / room).glob("*.hpp")).name for room in ROOMS}
        with tempfile.TemporaryDirectory() as folder:
            probe = pathlib.Path(folder) / "probe.cpp"
            for room in ROOMS:
                lines = []
                for other in ROOMS:
                    wrong = "" if other not in reached(room) else "!"
                    lines += [f'#if {wrong}__has_include("{other}/{headers[other]}")', f"#error {room}: {other}", "#endif"]
                probe.write_text("\n".join(lines) + "\n")
                command, directory = command_of(room)
                run = subprocess.run([*command, "-E", "-o", "/dev/null", str(probe)], cwd=directory, capture_output=True, text=True)
                self.assertEqual(run.returncode, 0, run.stderr)

    def test_the_map_in_the_readme_is_that_of_the_targets(self):
        text = (SERVER / "README.md").read_text()
        drawn = dict(re.findall(r"^ *([a-z]+) +-> (.*)$", text, re.MULTILINE))
        for room in ROOMS:
            with self.subTest(room=room):
                self.assertIn(room, drawn)
                self.assertEqual(set(drawn[room].split()), PUBLIC[room] | PRIVATE[room])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
