#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the documentation says holds: its links lead somewhere, its words are spelt, its commands run."""
import hashlib
import json
import os
import re
import shutil
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

    def test_every_figure_is_shown_and_every_commands_file_is_there(self):
        text = "\n".join(page.read_text() for page in PAGES)
        figures = [each.name for each in FILES if each.suffix == ".png" and "figures" in each.parts]
        self.assertEqual([each for each in figures if each not in text], [])

    def test_the_page_of_the_report_names_every_section_and_every_field_of_mesh_and_quality(self):
        page = (SOURCE / "docs/report.md").read_text()
        schema = json.loads((SOURCE / "proto/schema/report.json").read_text())["properties"]
        names = [*schema, *schema["mesh"]["properties"], *schema["quality"]["properties"]]
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

    def fetch(self, address, sha256, folder):
        manifest = Path(folder, "manifest.json")
        model = {"name": "points.off", "address": address, "sha256": sha256, "points": 2, "licence": "ours", "credit": "us"}
        manifest.write_text(json.dumps({"models": [model]}))
        return subprocess.run(["python3", SOURCE / "docs/fetch_data.py", Path(folder, "models"), "--manifest", manifest],
                              capture_output=True, text=True)

    def test_models_are_fetched_by_their_hash_and_others_refused_in_a_sentence(self):
        with tempfile.TemporaryDirectory() as folder:
            source = Path(folder, "there.off")
            source.write_text("OFF\n2 0 0\n0 0 1\n1 2 3\n")
            wrong = self.fetch(source.as_uri(), "0" * 64, folder)
            self.assertEqual(wrong.returncode, 1)
            self.assertRegex(wrong.stderr, "the manifest says 000.*it is not kept")
            self.assertEqual(list(Path(folder, "models").iterdir()), [])
            right = self.fetch(source.as_uri(), hashlib.sha256(source.read_bytes()).hexdigest(), folder)
            self.assertEqual(right.returncode, 0, right.stderr)
            self.assertEqual(Path(folder, "models/points.xyz").read_text(), "0 0 1\n1 2 3\n")
        with tempfile.TemporaryDirectory() as folder:
            gone = self.fetch(Path(folder, "nowhere").as_uri(), None, folder)
            self.assertRegex(gone.stderr, "cannot be fetched: .*; check the network")

    def test_the_manifest_names_address_licence_and_credit_of_every_model(self):
        for model in json.loads((SOURCE / "docs/data.json").read_text())["models"]:
            self.assertTrue(model["address"].startswith("https://") and model["licence"] and model["credit"], model)
            self.assertRegex(model["sha256"] or "0" * 64, "^[0-9a-f]{64}$")


if __name__ == "__main__":
    unittest.main()
