// SPDX-License-Identifier: GPL-3.0-or-later
// What is counted on a labelling: topology and the paper's energy.
#pragma once

#include <cstdint>
#include <vector>

#include "minimum_boundary/criterion.hpp"
#include "minimum_boundary/labelling.hpp"

namespace surfaced::boundary {

/// Counts of the surface of a labelling whose vertices are all good.
struct Measures {
  std::size_t facets = 0;
  /// Points on the surface; the others are interior.
  std::size_t vertices = 0;
  std::size_t interior = 0;
  std::size_t components = 0;
  /// Σλ in the criterion's units.
  std::int64_t energy = 0;
  double volume = 0;

  /// V - E + F of a closed surface, whose edges are 3F/2.
  std::int64_t euler() const { return static_cast<std::int64_t>(vertices) - static_cast<std::int64_t>(facets) / 2; }
  /// Handles of all components together.
  std::int64_t handles() const { return static_cast<std::int64_t>(components) - euler() / 2; }
};

/// @cost  O(cells).
Measures measure(const Labelling& labels, const Criterion& criterion);

/// Triangles whose longest edge is more than ten times the shortest surface edge at each of their vertices: sheets
/// over openings, or between objects, that the points do not determine.
struct Sheets {
  /// Share of the surface's area in sheets.
  double area_share = 0;
  /// Parts that only sheets connect, of at least a hundredth of the points each.
  std::size_t parts = 0;
  /// Vertices more than eight times as far from all their surface neighbours as any of those from its nearest.
  std::vector<VertexIndex> far;
};
/// Per triangle 1 if it is a sheet.
std::vector<std::uint8_t> mark_sheets(const std::vector<Point3>& positions, const std::vector<Triangle>& triangles);
Sheets sheets_of(const Labelling& labels);

}  // namespace surfaced::boundary
