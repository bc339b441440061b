# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits the doubt of minimum-boundary to what doubt_study wrote, and checks it on other seeds.

    doubt_study 11 14 > fit.csv && doubt_study 1 3 > check.csv && python3 doubt_fit.py fit.csv check.csv

Logistic regression with a small ridge, by Newton's steps. Prints the coefficients for core/minimum_boundary/doubt.cpp,
the limit that warns of one right result in twenty, and how often wrong and right results are warned of: in the fit, with
each model left out of it in turn, and on the other seeds.
"""
import csv
import math
import sys

RIDGE = 0.01
RIGHT_WARNED = 0.05
# Bodies with noise of half a spacing are so often wrong and so unlike all else that they spoil the fit for clean clouds.
KINDS = ("part", "mesh", "vertices", "several")
FEATURES = ["one", "more", "fewer", "guide", "unshared", "opposed", "above", "margin", "thin", "buried", "handles", "apart"]
STEPS = (0, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1)


def features(row):
    """As doubt.cpp has them."""
    points = float(row["points"])
    return [1.0,
            float(row["more"]),
            float(row["fewer"]),
            1 - float(row["guide"]),
            1 - float(row["shared"]),
            math.sqrt(float(row["opposed"])),
            math.sqrt(float(row["above"])),
            math.exp(-float(row["margin"]) / 10),
            math.sqrt(min(0.12, float(row["thin"]))),
            math.sqrt(float(row["buried"])),
            math.sqrt(max(0.0, float(row["genus"])) / points),
            max(0.0, 1 - float(row["agreeing"]) - float(row["more"]) - float(row["fewer"]))]


def solve(matrix, right):
    size = len(right)
    rows = [list(m) + [r] for m, r in zip(matrix, right)]
    for i in range(size):
        pivot = max(range(i, size), key=lambda k: abs(rows[k][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for k in range(i + 1, size):
            factor = rows[k][i] / rows[i][i]
            for j in range(i, size + 1):
                rows[k][j] -= factor * rows[i][j]
    answer = [0.0] * size
    for i in reversed(range(size)):
        answer[i] = (rows[i][size] - sum(rows[i][j] * answer[j] for j in range(i + 1, size))) / rows[i][i]
    return answer


def probability(weights, x):
    z = sum(w * v for w, v in zip(weights, x))
    return 1 / (1 + math.exp(-max(-40.0, min(40.0, z))))


def fit(data):
    size = len(data[0][0])
    weights = [0.0] * size
    for _ in range(30):
        gradient = [-RIDGE * w if i else 0.0 for i, w in enumerate(weights)]
        hessian = [[RIDGE if i == j and i else 1e-9 if i == j else 0.0 for j in range(size)] for i in range(size)]
        for x, wrong in data:
            p = probability(weights, x)
            curvature = p * (1 - p)
            for i in range(size):
                gradient[i] += (wrong - p) * x[i]
                for j in range(size):
                    hessian[i][j] += curvature * x[i] * x[j]
        step = solve(hessian, gradient)
        weights = [w + s for w, s in zip(weights, step)]
        if max(abs(s) for s in step) < 1e-6:
            break
    return weights


def limit_of(doubts):
    """The least limit that at most RIGHT_WARNED of the right results exceed."""
    right = sorted((d for d, wrong in doubts if not wrong), reverse=True)
    return right[min(len(right) - 1, int(RIGHT_WARNED * len(right)))]


def shares(doubts, limit):
    wrong = [d for d, w in doubts if w]
    right = [d for d, w in doubts if not w]
    return "%d of %d wrong warned (%.0f %%), %d of %d right (%.1f %%)" % (
        sum(d > limit for d in wrong), len(wrong), 100 * sum(d > limit for d in wrong) / max(1, len(wrong)),
        sum(d > limit for d in right), len(right), 100 * sum(d > limit for d in right) / max(1, len(right)))


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        return [row for row in csv.DictReader(file) if row["warnings"] is not None]


def examples(rows):
    return [(features(row), 0 if row["right"] == "1" else 1) for row in rows]


def main(paths):
    rows = [row for row in read(paths[0]) if row["kind"] in KINDS]
    data = examples(rows)
    weights = fit(data)
    for name, weight in zip(FEATURES, weights):
        print("%-14s %8.3f" % (name, weight))
    doubts = [(probability(weights, x), wrong) for x, wrong in data]
    limit = limit_of(doubts)
    print("limit %.3f\nfit:      %s" % (limit, shares(doubts, limit)))
    left_out = []
    for name in sorted({row["name"] for row in rows}):
        others = fit(examples([row for row in rows if row["name"] != name]))
        left_out += [(probability(others, x), wrong) for x, wrong in examples([r for r in rows if r["name"] == name])]
    print("left out: %s" % shares(left_out, limit))
    for path in paths[1:]:
        other = read(path)
        for kind in sorted({row["kind"] for row in other}) + ["all"]:
            some = [row for row in other if kind in (row["kind"], "all")]
            print("%s, %s: %s" % (path, kind, shares([(probability(weights, x), w) for x, w in examples(some)], limit)))
        for low, high in zip(STEPS, STEPS[1:]):
            here = [w for x, w in examples(other) if low <= probability(weights, x) < high]
            if here:
                print("doubt %.2f to %.2f: %d results, %.0f %% wrong" % (low, high, len(here), 100 * sum(here) / len(here)))


main(sys.argv[1:])
