// SPDX-License-Identifier: GPL-3.0-or-later
// What the statistics of a run give reason to doubt.
#pragma once

#include <string>
#include <vector>

#include "minimum_boundary/minimum_boundary.hpp"

namespace surfaced::boundary {

/// Warnings as docs/methods/minimum-boundary.md explains them.
/// @param points  of the cloud.
std::vector<std::string> warnings_of(const MinimumBoundaryStatistics& statistics,
                                     const MinimumBoundaryParameters& parameters, std::size_t points);

}  // namespace surfaced::boundary
