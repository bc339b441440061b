# SPDX-License-Identifier: GPL-3.0-or-later
"""Breaks steps of core/minimum_boundary one at a time and counts which breaks the tests notice.

    python3 tests/minimum_boundary/mutants.py BUILD_FOLDER [NUMBER...]

Each mutant is an operator, a file, a piece of text that occurs in it once, what takes its place, and the step that
this breaks. Operators:
    omit      a step or a guard is left out
    turn      a comparison or a sign is turned around
    shift     a constant is moved so far that it no longer decides anything

The file is changed in place, minimum_boundary_test is built and run, and the file is restored. Needs a minute or two
for each; run it in a copy of the repository if you work in this one meanwhile, configured with SURFACED_JOINED=OFF so
that only the changed file is compiled. Survivors that stand in EXPECTED are argued there. Exit code 1 if another one
survives or a mutant is stale.
"""
import pathlib
import subprocess
import sys

ROOM = pathlib.Path(__file__).resolve().parents[2] / "core" / "minimum_boundary"
MUTANTS = [
    # The paper's steps.
    ("omit", "sculpturing.cpp", "if (removes_smallest(c, border) || ",
     "if ((c.value + 1 == 0 && removes_smallest(c, border)) || ", "the rule of §6.3"),
    ("omit", "artifacts.cpp", "if (regions_.find(c.from) == regions_.find(c.to)) artifact.hull_hole = true;",
     "(void)artifact;", "hull holes (§5.3)"),
    ("omit", "conforming.cpp", "  if (outside > static_cast<std::ptrdiff_t>(kSides)) return false;",
     "  if (outside >= 0) return true;", "conforming (§6.1)"),
    ("omit", "hole_covering.cpp", "for (const SideIndex s : first) covered.facets.insert(walls.complex(), s);",
     "if (count > lids.size()) return covered;", "lids (§5.4)"),
    # Descent and Theorem C.
    ("turn", "descent.cpp", "    return !vertex_touches(", "    return vertex_touches(", "Theorem C at a vertex"),
    ("omit", "descent.cpp", "  return !edge_touches(", "  return border != 0 || !edge_touches(",
     "Theorem C at an edge"),
    ("turn", "descent.cpp", "    if (shown == 1 && !labels_.in(c)) return false;",
     "    if (shown == 1 && labels_.in(c)) return false;", "exposing interior points"),
    ("turn", "descent.cpp", "return (shown == 1 || move.change < 0)", "return (shown == 1 || move.change > 0)",
     "flips that lower Σλ"),
    ("omit", "criterion.hpp", "return first != second ? first < second : complex_.facet(a) < complex_.facet(b);",
     "return first[0] != second[0] ? first[0] < second[0] : complex_.facet(a) < complex_.facet(b);",
     "ties by the second and third edge"),
    # Bodies, openings, flat input.
    ("shift", "bodies.cpp", "constexpr double kBridge = 1.5;", "constexpr double kBridge = 15;", "gaps between bodies"),
    ("shift", "bodies.cpp", "constexpr std::size_t kFewestPoints = 12;",
     "constexpr std::size_t kFewestPoints = 100000;",
     "counting bodies"),
    ("omit", "openings.cpp", "    if (gaps.size() < 2) return false;", "    if (gaps.size() < 200) return false;",
     "one fan at each vertex of an opening"),
    ("shift", "flatness.cpp", "constexpr double kFlatShare = 0.1;", "constexpr double kFlatShare = 1e-9;",
     "sheets with noise"),
    ("shift", "flatness.cpp", "constexpr double kRoundedSteps = 2;", "constexpr double kRoundedSteps = 0;",
     "sheets rounded to float32"),
    ("shift", "flatness.cpp", "constexpr double kFlatShareOfFew = 0x1p-20;", "constexpr double kFlatShareOfFew = 0.3;",
     "thin bodies of few points"),
    # Choosing, fusing, surgery.
    ("omit", "surgery.cpp", "|| adds_component(turned)", "|| (turned.empty() && adds_component(turned))",
     "surgery keeps components"),
    ("turn", "surgery.cpp", "    if (cost < price) {", "    if (cost > price) {", "the price of a handle in surgery"),
    ("omit", "candidates.cpp", "    if (2 * static_cast<std::size_t>(same) > candidates.size()) return",
     "    if (2 * static_cast<std::size_t>(same) > 9 * candidates.size()) return", "handles that most candidates have"),
    ("shift", "candidates.hpp", "kComponent = 0.05;", "kComponent = 1e9;", "a cage against an islet"),
    ("omit", "candidates.cpp", "return c.angles && c.angles->thin_share() > SolidAngles::kHollowShare;",
     "return c.angles && c.angles->thin_share() > 2 * SolidAngles::kHollowShare + 1;", "noticing cages"),
    ("omit", "minimum_boundary.cpp", "    recipes.push_back({Recipe::Kind::guided, 0, 0});\n", "",
     "the guided candidate"),
    ("omit", "fusing.cpp", "after <= before && gain", "gain", "fusing keeps components"),
    ("turn", "fusing.cpp", "gain < bounty", "gain > bounty", "fusing improves"),
    ("shift", "watershed.cpp", "constexpr double kGuardShare = 0.3;", "constexpr double kGuardShare = 3;",
     "the guard of the watershed"),
    ("shift", "repair.hpp", "  static constexpr int kOutside = 20;", "  static constexpr int kOutside = 0;",
     "repair keeps points"),
    ("omit", "bridging.cpp", "bridged.components > wanted && bridges", "bridged.components > wanted + 99 && bridges",
     "bridges"),
    ("shift", "min_cut.cpp", "constexpr std::array kSeedFactors{2.0, 4.0, 8.0};",
     "constexpr std::array kSeedFactors{8.0, 8.0, 8.0};", "seeds of the cut"),
    # What is measured and said.
    ("shift", "solid_angles.cpp", "constexpr double kThin = 0.1;", "constexpr double kThin = 1e-9;", "thin vertices"),
    ("shift", "solid_angles.cpp", "constexpr double kBuried = 0.8;", "constexpr double kBuried = 1.1;",
     "buried vertices"),
    ("shift", "warnings.cpp", "constexpr double kDoubtfulSheets = 0.02;", "constexpr double kDoubtfulSheets = 2;",
     "closure_uncertain"),
    ("shift", "warnings.cpp", "constexpr double kUndersampled = 0.4;", "constexpr double kUndersampled = 4;",
     "sampling_uncertain"),
    ("shift", "warnings.cpp", "constexpr double kFewInside = 0.005;", "constexpr double kFewInside = 5;",
     "points_inside"),
    ("omit", "warnings.cpp", "  if (s.outliers > 0) {", "  if (s.outliers > 1000000) {", "outliers_suspected"),
    ("omit", "warnings.cpp", "  if (s.joined_parts > s.components) {", "  if (s.joined_parts > 9 * s.components) {",
     "components_joined"),
    ("turn", "doubt.cpp", "      Term{7.892,", "      Term{-7.892,", "the doubt grows with ε"),
    ("turn", "evidence.cpp", "dot(normals[v], n) < 0", "dot(normals[v], n) > 0",
     "triangles against the guide's normals"),
    ("turn", "sampling.cpp", "std::min(", "std::max(", "the nearer pole"),
]
# Number of a survivor: why no test can tell, or need.
EXPECTED = {}


def run(command):
    return subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode == 0


def outcome(build, path, old, new):
    """What becomes of one mutant; the file is as before afterwards."""
    text = path.read_text(encoding="utf-8")
    if text.count(old) != 1:
        return "stale: its text occurs %d times" % text.count(old)
    try:
        path.write_text(text.replace(old, new), encoding="utf-8")
        if not run(["ninja", "-C", str(build), "-j1", "minimum_boundary_test"]):
            return "stale: does not compile"
        return "survives" if run([str(build / "minimum_boundary_test"), "--gtest_fail_fast"]) else "dies"
    finally:
        path.write_text(text, encoding="utf-8")


def main(arguments):
    build = pathlib.Path(arguments[0]).resolve()
    chosen = [int(a) for a in arguments[1:]] or range(1, len(MUTANTS) + 1)
    counts = {}
    bad = False
    for number in chosen:
        operator, file, old, new, step = MUTANTS[number - 1]
        what = outcome(build, ROOM / file, old, new)
        print("%2d %-6s%-22s%-44s%s" % (number, operator, file, step, what), flush=True)
        if what == "survives" and number in EXPECTED:
            print("   " + EXPECTED[number])
        elif what != "dies":
            bad = True
        counts[what.split(":")[0]] = counts.get(what.split(":")[0], 0) + 1
    print(", ".join("%d %s" % (count, what) for what, count in sorted(counts.items())))
    return 1 if bad else 0


sys.exit(main(sys.argv[1:]))
