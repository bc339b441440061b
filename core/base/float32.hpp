// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <vector>

#include "base/geometry.hpp"

namespace surfaced {

/// True if float32 holds every coordinate exactly.
inline bool fits_float32(const std::vector<Point3>& positions) {
  return std::ranges::all_of(positions, [](const Point3& p) {
    return std::ranges::all_of(p, [](double x) { return static_cast<double>(static_cast<float>(x)) == x; });
  });
}

}  // namespace surfaced
