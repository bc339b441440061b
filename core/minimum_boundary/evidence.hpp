// SPDX-License-Identifier: GPL-3.0-or-later
// What speaks for and against a result: how far ways that have nothing in common agree with it.
#pragma once

#include <vector>

#include "minimum_boundary/candidates.hpp"
#include "minimum_boundary/minimum_boundary.hpp"

namespace surfaced::boundary {

/// Before anything is fused: the candidates, of which one was chosen, against the chosen one.
MinimumBoundaryEvidence compare_candidates(const std::vector<Candidate>& candidates, std::size_t chosen,
                                           std::size_t bodies);

/// Adds what the guiding surface says of the final labels: how many of their triangles it shares, whether it has the
/// same topology, and how many triangles face against the guide's normals at their corners, as where two sheets that
/// pass each other are webbed together.
/// @cost  O(cells) and a search of a star for each triangle of the guide.
void compare_guide(const Labelling& labels, const Measures& measures, const GuidingSurface& guide,
                   MinimumBoundaryEvidence& evidence);

}  // namespace surfaced::boundary
