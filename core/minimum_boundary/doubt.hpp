// SPDX-License-Identifier: GPL-3.0-or-later
// One probability that a result is wrong, from all that speaks against it.
#pragma once

#include "minimum_boundary/minimum_boundary.hpp"

namespace surfaced::boundary {

/// Results with more doubt are warned of: of right results on clean clouds about one in thirteen.
extern const double kDoubtful;

/// Probability that genus, number of components or volume (by more than a quarter) are wrong: a logistic regression on
/// the evidence, fitted to random parts of clouds, random points of meshes and bodies side by side
/// (tests/benchmarks/doubt_study.cpp and doubt_fit.py). Precondition: statistics have evidence and sampling.
double doubt_of(const MinimumBoundaryStatistics& statistics, std::size_t points);

}  // namespace surfaced::boundary
