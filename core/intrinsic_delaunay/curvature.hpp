// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "base/base.hpp"
#include "mesh/mesh.hpp"

namespace surfaced::idt {

/// Which vertices share a triangle with each: those of v are neighbours[first[v]] .. neighbours[first[v+1]], each once,
/// ascending.
struct Adjacency {
  std::vector<std::uint32_t> first;
  std::vector<std::uint32_t> neighbours;
  std::span<const std::uint32_t> of(std::uint32_t v) const {
    return {neighbours.data() + first[v], neighbours.data() + first[v + 1]};
  }
};
Adjacency adjacency_of(std::span<const Triangle> triangles, std::size_t vertices);

/// Per vertex the largest absolute principal curvature of the quadric through its rings (a jet of degree 2), or, where
/// that is more, how fast the unit normals turn from it to a neighbour, if they turn far; in 1/unit; negative where too
/// few vertices lie around it.
/// @cost  O(V), in parallel.
std::vector<double> curvatures(std::span<const Point3> positions, std::span<const Point3> normals,
                               const Adjacency& adjacency, Context& context);

}  // namespace surfaced::idt
