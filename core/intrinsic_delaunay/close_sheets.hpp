// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: whether a surface comes near to itself.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "base/base.hpp"
#include "intrinsic_delaunay/curvature.hpp"

namespace surfaced::idt {

/// Two vertices within 2ε whose normals differ by more than 90° and that are farther apart on the mesh than a surface
/// of curvature 1/(8ε) needs to turn that far; the least such pair of all.
/// @param normals     of the vertices, of any length; a zero faces away from none.
/// @param most_steps  so many pairs and steps of paths are looked at; beyond that none is found.
/// @cost  O(V log V) where normals turn by less than a right angle within some ε; elsewhere all pairs within 2ε.
std::optional<std::array<std::uint32_t, 2>> close_sheets(std::span<const Point3> positions,
                                                         std::span<const Point3> normals, const Adjacency& adjacency,
                                                         double epsilon, std::size_t most_steps);

}  // namespace surfaced::idt
