// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "front/sewing.hpp"

namespace surfaced::front {

/// Rims of holes: closed chains of open edges, each with the hole to its left, beginning at the least vertex.
using Rim = std::vector<std::uint32_t>;

/// The rims through the given vertices, ascending by their edges; those longer than `longest` or that meet a
/// vertex twice are left out.
std::vector<Rim> rims_at(const Fans& fans, const Places& places, std::span<const std::uint32_t> vertices,
                         std::size_t longest);

struct ClosingLimits {
  std::size_t longest;
  double least_cosine;
};

/// Closes one hole with triangles between its corners if that leaves a manifold.
bool close_rim(Fans& fans, Places& places, const Rim& rim, double least_cosine);

/// Closes the holes at the given vertices. @return how many.
std::size_t close_holes(Fans& fans, Places& places, std::span<const std::uint32_t> vertices,
                        const ClosingLimits& limits);

/// Opens the surroundings of holes that could not be closed, a ring more each time, and closes them anew; what
/// does not end closed is put back.
/// @return  how many holes were closed, or cancelled.
Result<std::size_t> repair_holes(Fans& fans, Places& places, std::size_t longest, Context& context);

/// Takes away all but the largest fan of every vertex that has several. @return the number of faces removed.
std::size_t separate_fans(Fans& fans);

/// Puts unused points into the face over which they lie, where that bends the surface little.
/// @return  how many points were inserted.
std::size_t insert_leftovers(Fans& fans, Places& places);

}  // namespace surfaced::front
