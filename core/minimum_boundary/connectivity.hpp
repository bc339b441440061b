// SPDX-License-Identifier: GPL-3.0-or-later
// Connectedness of the surface, asked locally.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "minimum_boundary/labelling.hpp"

namespace surfaced::boundary {

/// Counts surface components by growing from all given vertices at once, until all have met or all but one
/// component is exhausted: cheap where the vertices are connected nearby.
class SurfaceSearch {
 public:
  explicit SurfaceSearch(const DelaunayComplex& complex) : source_(complex.points(), 0), epoch_(complex.points(), 0) {}

  /// Number of surface components that contain one of the vertices; those not on the surface do not count.
  std::size_t components(const Labelling& labels, std::span<const VertexIndex> vertices);

 private:
  std::vector<std::uint32_t> source_;
  std::vector<std::uint32_t> epoch_;
  std::uint32_t now_ = 0;
};

}  // namespace surfaced::boundary
