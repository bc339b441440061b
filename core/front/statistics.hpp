// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace surfaced::front {

/// What the steps that papers 2 and 3 share count.
struct Statistics {
  /// Triangles on which the local triangulations of all three vertices agree.
  std::size_t agreed_faces = 0;
  /// Of those, dropped because they would make the surface one-sided.
  std::size_t one_sided_faces = 0;
  /// Seeds set where there was nothing to begin with.
  std::size_t seeds = 0;
  /// Faces the front added.
  std::size_t sewn_faces = 0;
  std::size_t holes_closed = 0;
  /// Holes closed after their surroundings were opened and sewn anew.
  std::size_t holes_repaired = 0;
  std::size_t points_inserted = 0;
  /// Faces removed where several fans met in a vertex.
  std::size_t separated_faces = 0;
  std::size_t open_edges = 0;
};

}  // namespace surfaced::front
