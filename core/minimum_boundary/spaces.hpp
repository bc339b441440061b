// SPDX-License-Identifier: GPL-3.0-or-later
// The polyhedra inside H(BC) without triangles of BC in their interior (§5.5): one is the inside hull I(BC), all others
// are slivers.
#pragma once

#include <cstdint>
#include <vector>

#include "minimum_boundary/walled_star.hpp"

namespace surfaced::boundary {

struct Spaces {
  static constexpr std::uint32_t kOutside = 0xFFFFFFFFU;
  /// Per cell its space, 0..count-1: IN cells that are connected without crossing a wall.
  std::vector<std::uint32_t> of_cell;
  std::uint32_t count = 0;
  /// Per space 1 if it lies across the single umbrella of a vertex that also meets the outside.
  std::vector<std::uint8_t> inside;
};

/// @cost  O(cells).
Spaces find_spaces(const Walls& walls);

}  // namespace surfaced::boundary
