#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the documentation says holds: its links lead somewhere, its words are spelt, its commands run."""
import hashlib
import json
import os
import re
import shutil
import struct
import subprocess
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(os.environ["SURFACED_SOURCE"]).resolve()
LISTED = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=SOURCE, check=True,
                        capture_output=True, text=True).stdout.split("\n")
FILES = [SOURCE / each for each in LISTED if each and (SOURCE / each).is_file()]
PAGES = [each for each in FILES if each.suffix == ".md"]


def prose(page):
    """The text without code."""
    return re.sub(r"`[^`\n]*`", "", re.sub(r"^```.*?^```", "", page.read_text(), flags=re.S | re.M))


def anchors(page):
    """What the headings of a page are called in links, as forges do it."""
    headings = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```", "", page.read_text(), flags=re.S | re.M), flags=re.M)
    return {re.sub(r"[^\w\- ]", "", re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", each).lower()).replace(" ", "-") for each in headings}


class Documentation(unittest.TestCase):
    def test_every_link_within_the_repository_leads_somewhere(self):
        broken = []
        for page in PAGES:
            for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
                if re.match(r"[a-z]+:", target):
                    continue
                path, _, anchor = target.partition("#")
                place = (page.parent / path).resolve() if path else page
                if not place.exists() or SOURCE not in [place, *place.parents]:
                    broken.append(f"{page.relative_to(SOURCE)}: {target}")
                elif anchor and place.suffix == ".md" and anchor not in anchors(place):
                    broken.append(f"{page.relative_to(SOURCE)}: {target}, no such heading")
        self.assertEqual(broken, [])

    def test_every_test_that_the_threat_model_names_exists(self):
        tests = "\n".join(each.read_text() for each in FILES
                          if each.is_relative_to(SOURCE / "tests") and each.suffix in (".cpp", ".mjs", ".hpp"))
        missing = []
        for page in ("threat-model.md", "known-vulnerabilities.md"):
            rows = [line for line in (SOURCE / "docs" / page).read_text().splitlines() if line.startswith("| ")]
            named = [name for row in rows for name in re.findall(r"`([^`]+)`", row.rstrip("| ").rsplit("|", 1)[1])]
            self.assertGreater(len(named), 10, page)
            missing += [f"{page}: {name}" for name in named if not re.search(rf"[ '`]{re.escape(name)}[)'`\\\\]", tests)]
        self.assertEqual(missing, [])

    def test_every_page_can_be_reached_from_the_readme(self):
        seen, ahead = set(), [SOURCE / "README.md"]
        while ahead:
            page = ahead.pop()
            if page in seen:
                continue
            seen.add(page)
            for target in re.findall(r"\]\(([^)#\s]+)", prose(page)):
                place = (page.parent / target).resolve()
                place = place / "README.md" if place.is_dir() else place
                if place.suffix == ".md" and place.is_file():
                    ahead.append(place)
        lost = [str(page.relative_to(SOURCE)) for page in PAGES if page not in seen and page.parts[len(SOURCE.parts)] in ("docs", "docker", "packaging", "client-examples")]
        self.assertEqual(lost, [])

    def test_every_source_file_names_its_licence_at_its_top(self):
        sources = (".cpp", ".hpp", ".py", ".sh", ".ts", ".js", ".mjs", ".css", ".cmake")
        named = [each for each in FILES if each.suffix in sources or each.name in ("CMakeLists.txt", "dev", "run", "Dockerfile")]
        self.assertGreater(len(named), 600)
        bare = [str(each.relative_to(SOURCE)) for each in named
                if "SPDX-License-Identifier: GPL-3.0-or-later" not in "\n".join(each.read_text().split("\n")[:3])]
        self.assertEqual(bare, [])

    def notice(self, source, *arguments):
        return subprocess.run(["python3", SOURCE / "packaging/notice.py", "--source", source, *arguments], capture_output=True, text=True)

    def test_the_notice_names_what_is_compiled_in_linked_and_bundled(self):
        made = self.notice(SOURCE, "--check", "--binary", os.environ["SURFACED_BIN"])
        self.assertEqual((made.returncode, made.stderr), (0, ""))
        text = (SOURCE / "NOTICE").read_text()
        for each in ("CGAL", "GMP", "Draco decoder (WebAssembly)", "meshoptimizer decoder", "three 0.", "url-parse", "lodash.throttle"):
            self.assertIn(each, text)

    def test_the_notice_is_not_made_where_something_is_missing(self):
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder)
            for each in ("packages.txt", "NOTICE", "packaging/licences.json", "server/web/package-lock.json"):
                (copy / each).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(SOURCE / each, copy / each)
            (copy / "server/web/src").mkdir()
            (copy / "server/web/src/a.ts").write_text("import x from 'three/examples/jsm/libs/rhino3dm.module.js';\n")
            lock = json.loads((copy / "server/web/package-lock.json").read_text())
            lock["packages"]["node_modules/nameless"] = {"version": "1.0.0"}
            (copy / "server/web/package-lock.json").write_text(json.dumps(lock))
            text = (copy / "packages.txt").read_text()
            (copy / "packages.txt").write_text(text.replace("[build]\n", "[build]\nlibvtk9-dev\n", 1))
            made = self.notice(copy)
            self.assertEqual(made.returncode, 1)
            for each in ("packages.txt has libvtk9-dev", "nameless without a licence", "imports three/examples/jsm/libs/rhino3dm"):
                self.assertIn(each, made.stderr)
            self.assertEqual((copy / "NOTICE").read_text(), (SOURCE / "NOTICE").read_text(), "and NOTICE stays as it was")

    def test_every_figure_is_shown_and_every_commands_file_is_there(self):
        text = "\n".join(page.read_text() for page in PAGES)
        figures = [each.name for each in FILES if each.suffix == ".png" and "figures" in each.parts]
        self.assertEqual([each for each in figures if each not in text], [])

    def test_the_page_of_the_report_names_every_section_and_every_field_of_mesh_and_quality(self):
        page = (SOURCE / "docs/report.md").read_text()
        report = json.loads((SOURCE / "proto/schema/report.json").read_text())
        schema = report["properties"]
        names = [*schema, *report["$defs"]["topology"]["properties"], *schema["quality"]["properties"]]
        self.assertEqual([each for each in names if not re.search(rf"`(\w+\.)?{each}`", page)], [])

    def test_words_are_spelt(self):
        read = (".md", ".hpp", ".yaml", ".html", ".sh", ".py", ".1")
        written = [str(each) for each in FILES if each.suffix in read or each.name in ("dev", "packages.txt", "Dockerfile", "NOTICE", "errors.json")
                   or SOURCE / "client-examples" in each.parents and each.suffix in (".ts", ".js", ".cpp")]
        found = subprocess.run(["codespell", *written], capture_output=True, text=True)
        self.assertEqual(found.stdout.replace(str(SOURCE) + "/", ""), "")

    def test_dev_knows_every_command_that_is_named(self):
        known = set(re.findall(r"^  ([a-z]+)(?: \|[^)]*)?\) ", (SOURCE / "dev").read_text(), flags=re.M))
        named = {command for page in PAGES for command in re.findall(r"\./dev ([a-z]+)", page.read_text())}
        self.assertEqual(named - known, set())
        usage = subprocess.run([SOURCE / "dev", "help"], capture_output=True, text=True, check=True).stdout
        self.assertEqual({each for each in known if f"./dev {each}" not in usage}, set())

    def test_the_commands_of_the_tutorial_run(self):
        blocks = re.findall(r"^```sh\n(.*?)^```", (SOURCE / "docs/tutorial.md").read_text(), flags=re.S | re.M)
        self.assertGreaterEqual(len(blocks), 4)
        with tempfile.TemporaryDirectory() as folder:
            shutil.copy(SOURCE / "client-examples/samples/knot.ply", Path(folder, "scan.ply"))
            path = f"{Path(os.environ['SURFACED_BIN']).parent}:{os.environ['PATH']}"
            ran = subprocess.run(["bash", "-c", "set -euo pipefail\n" + "\n".join(blocks)], cwd=folder, capture_output=True, text=True,
                                 env={**os.environ, "PATH": path})
            self.assertEqual(ran.returncode, 0, ran.stderr)
            self.assertTrue(Path(folder, "part.3mf").read_bytes().startswith(b"PK"))

    def fetch(self, folder, **model):
        manifest = Path(folder, "manifest.json")
        manifest.write_text(json.dumps({"models": [{"name": "m.ply", "points": 4, "licence": "ours", "credit": "us", **model}]}))
        return subprocess.run(["python3", SOURCE / "docs/fetch_data.py", Path(folder, "models"), "--manifest", manifest],
                              capture_output=True, text=True)

    def test_models_are_fetched_by_their_hash_converted_and_others_refused_in_a_sentence(self):
        inwards = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 3 1\n3 0 2 3\n3 1 3 2\n"
        numbers = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1)
        head = b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        cloud = head + b"end_header\n" + numbers
        faces = b"".join(struct.pack("<B3i", 3, *each) for each in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)))
        mesh = head + b"element face 4\nproperty list uchar int vertex_indices\nend_header\n" + numbers + faces
        of = lambda data: hashlib.sha256(data).hexdigest()
        with tempfile.TemporaryDirectory() as folder:
            source = Path(folder, "there.off")
            source.write_text(inwards)
            right = {"address": source.as_uri(), "source_sha256": of(inwards.encode()), "sha256": of(cloud), "reference_sha256": of(mesh)}
            for wrong in ("source_sha256", "sha256", "reference_sha256"):
                ran = self.fetch(folder, **{**right, wrong: "0" * 64})
                self.assertEqual(ran.returncode, 1)
                self.assertRegex(ran.stderr, "the manifest says 000.*it is not kept")
            ran = self.fetch(folder, **right)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            self.assertEqual(Path(folder, "models/m.ply").read_bytes(), cloud)
            self.assertEqual(Path(folder, "models/reference/m.ply").read_bytes(), mesh, "turned outwards")
            source.unlink()
            self.assertIn("was there", self.fetch(folder, **right).stdout)
            Path(folder, "models/m.ply").unlink()
            self.assertRegex(self.fetch(folder, **right).stderr, "cannot be fetched: .*; check the network")

    def test_the_manifest_pins_every_model_and_names_address_licence_and_credit(self):
        models = json.loads((SOURCE / "docs/data.json").read_text())["models"]
        names = {model["name"] for model in models}
        for model in models:
            self.assertTrue(model["licence"] and model["credit"] and model["points"], model)
            self.assertRegex(model["sha256"] + model.get("reference_sha256", "0" * 64), "^[0-9a-f]{128}$")
            if "encoded_from" in model:
                self.assertIn(model["encoded_from"], names)
            else:
                self.assertRegex(model["address"], r"^https://raw\.githubusercontent\.com/[^/]+/[^/]+/[0-9a-f]{40}/")
                self.assertRegex(model["source_sha256"], "^[0-9a-f]{64}$")

    def test_the_manifest_has_every_cloud_that_a_test_names(self):
        names = {model["name"] for model in json.loads((SOURCE / "docs/data.json").read_text())["models"]}
        there = Path(os.environ["SURFACED_TEST_DATA"])
        if there.is_dir():
            self.assertEqual({each.name for each in there.iterdir() if each.suffix in (".ply", ".drc")} - names, set())

    def test_skipped_tests_are_counted_and_named(self):
        cases = [("A.ran", "run", "fine"), ("B.lacks", "notrun", "x_test.cpp:7: Skipped\n./dev data fetches it\n\n[  SKIPPED ] B.lacks (0 ms)"),
                 ("readers", "run", "ok 1 - reads\nok 2 - are there # SKIP nothing is there\n"), ("packaging", "notrun", "skipped: a build with sanitizers\n")]
        rows = "".join(f'<testcase name="{name}" status="{status}">{"<skipped/>" if status == "notrun" else ""}<system-out>{output}</system-out></testcase>'
                       for name, status, output in cases)
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "tests.xml").write_text(f"<testsuite>{rows}</testsuite>")
            said = subprocess.run(["python3", SOURCE / "tests/skipped.py", Path(folder, "tests.xml")], capture_output=True, text=True, check=True).stdout
        self.assertIn("3 tests were skipped, of 4", said)
        for each in ("./dev data fetches it\ndev:     B.lacks", "nothing is there\ndev:     readers: are there", "a build with sanitizers\ndev:     packaging"):
            self.assertIn(each, said)


if __name__ == "__main__":
    unittest.main()
