// SPDX-License-Identifier: GPL-3.0-or-later
// Slow, plain checks of a closed surface that share no code with the methods: maps, solid angles and
// CGAL's exact predicates.
#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Exact_rational.h>
#include <CGAL/intersections.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mesh/mesh.hpp"

namespace surfaced::testing {

namespace brute_force {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

inline Kernel::Point_3 point(const TriangleMesh& mesh, VertexIndex v) {
  const Point3& p = mesh.positions[v];
  return {p[0], p[1], p[2]};
}

/// Every directed edge once, and its opposite once.
inline std::string edges_problem(const TriangleMesh& mesh) {
  std::map<std::pair<std::size_t, std::size_t>, int> uses;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++uses[{t[i], t[(i + 1) % 3]}];
  }
  for (const auto& [edge, count] : uses) {
    const auto back = uses.find({edge.second, edge.first});
    if (count != 1) return "a directed edge is used " + std::to_string(count) + " times";
    if (back == uses.end()) return "an edge has one triangle or two of opposite orientation";
  }
  return {};
}

/// The link of every vertex is one cycle.
inline std::string links_problem(const TriangleMesh& mesh) {
  std::map<std::size_t, std::map<std::size_t, std::size_t>> links;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (!links[t[i]].emplace(t[(i + 1) % 3], t[(i + 2) % 3]).second) return "two triangles leave a vertex alike";
    }
  }
  for (const auto& [vertex, next] : links) {
    std::size_t steps = 0;
    std::size_t at = next.begin()->first;
    do {
      const auto found = next.find(at);
      if (found == next.end()) return "the link of vertex " + std::to_string(vertex) + " is open";
      at = found->second;
    } while (++steps <= next.size() && at != next.begin()->first);
    if (steps != next.size()) return "vertex " + std::to_string(vertex) + " has more than one umbrella";
  }
  return {};
}

/// Whether two triangles have a point in common that is no common vertex and on no common edge.
inline bool cross_each_other(const TriangleMesh& mesh, const Triangle& s, const Triangle& t) {
  std::vector<VertexIndex> common;
  std::vector<VertexIndex> only_s;
  std::vector<VertexIndex> only_t;
  for (const VertexIndex v : s) (std::ranges::count(t, v) > 0 ? common : only_s).push_back(v);
  for (const VertexIndex v : t) {
    if (std::ranges::count(s, v) == 0) only_t.push_back(v);
  }
  const auto at = [&](VertexIndex v) { return point(mesh, v); };
  const Kernel::Triangle_3 ts(at(s[0]), at(s[1]), at(s[2]));
  const Kernel::Triangle_3 tt(at(t[0]), at(t[1]), at(t[2]));
  if (common.empty()) return CGAL::do_intersect(ts, tt);
  if (common.size() == 1) {
    return CGAL::do_intersect(ts, Kernel::Segment_3(at(only_t[0]), at(only_t[1]))) ||
           CGAL::do_intersect(tt, Kernel::Segment_3(at(only_s[0]), at(only_s[1])));
  }
  if (common.size() == 3) return true;
  if (CGAL::orientation(at(common[0]), at(common[1]), at(only_s[0]), at(only_t[0])) != CGAL::COPLANAR) return false;
  return CGAL::coplanar_orientation(at(common[0]), at(common[1]), at(only_s[0]), at(only_t[0])) != CGAL::NEGATIVE;
}

inline std::string intersections_problem(const TriangleMesh& mesh) {
  const auto apart = [&](const Triangle& s, const Triangle& t) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto less = [&](VertexIndex a, VertexIndex b) { return mesh.positions[a][axis] < mesh.positions[b][axis]; };
      const auto [s_low, s_high] = std::ranges::minmax(s, less);
      const auto [t_low, t_high] = std::ranges::minmax(t, less);
      if (less(s_high, t_low) || less(t_high, s_low)) return true;
    }
    return false;
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (std::size_t j = i + 1; j < mesh.triangles.size(); ++j) {
      const Triangle& s = mesh.triangles[i];
      const Triangle& t = mesh.triangles[j];
      if (!apart(s, t) && cross_each_other(mesh, s, t)) {
        return "triangles " + std::to_string(i) + " and " + std::to_string(j) + " intersect";
      }
    }
  }
  return {};
}

/// How often the surface winds around a point that is not on it, by the sum of solid angles.
inline double winding_number(const TriangleMesh& mesh, const Point3& p) {
  long double sum = 0;
  for (const Triangle& t : mesh.triangles) {
    std::array<std::array<long double, 3>, 3> e{};
    std::array<long double, 3> l{};
    for (std::size_t i = 0; i < 3; ++i) {
      long double square = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        e[i][k] = static_cast<long double>(mesh.positions[t[i]][k]) - static_cast<long double>(p[k]);
        square += e[i][k] * e[i][k];
      }
      l[i] = std::sqrt(square);
    }
    const auto scalar = [&](std::size_t a, std::size_t b) {
      return e[a][0] * e[b][0] + e[a][1] * e[b][1] + e[a][2] * e[b][2];
    };
    const long double triple = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                               e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                               e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
    sum += 2 * std::atan2(triple, l[0] * l[1] * l[2] + scalar(0, 1) * l[2] + scalar(0, 2) * l[1] + scalar(1, 2) * l[0]);
  }
  return static_cast<double>(sum / (4 * std::numbers::pi_v<long double>));
}

inline std::string points_problem(const TriangleMesh& mesh) {
  std::set<std::size_t> used;
  for (const Triangle& t : mesh.triangles) used.insert(t.begin(), t.end());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (used.contains(v)) continue;
    const double winding = winding_number(mesh, mesh.positions[v]);
    if (std::abs(winding - 1) > 0.01) {
      return "point " + std::to_string(v) + " is neither on the surface nor inside: winding number " +
             std::to_string(winding);
    }
  }
  return {};
}

/// Exact sign of the enclosed volume: the rounded volume of a flat body may have any sign.
inline std::string volume_problem(const TriangleMesh& mesh) {
  using Number = CGAL::Exact_rational;
  Number six_volumes = 0;
  for (const Triangle& t : mesh.triangles) {
    const auto at = [&](std::size_t i, std::size_t k) { return Number(mesh.positions[t[i]][k]); };
    six_volumes += at(0, 0) * (at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1)) -
                   at(0, 1) * (at(1, 0) * at(2, 2) - at(1, 2) * at(2, 0)) +
                   at(0, 2) * (at(1, 0) * at(2, 1) - at(1, 1) * at(2, 0));
  }
  return six_volumes > 0 ? std::string() : "the volume is not positive";
}

}  // namespace brute_force

/// What keeps the mesh from being a closed, oriented, embedded manifold with every one of its positions on it
/// or inside it; empty if nothing does.
inline std::string surface_problem(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return "no triangles";
  for (const auto check : {brute_force::edges_problem, brute_force::links_problem, brute_force::intersections_problem,
                           brute_force::points_problem, brute_force::volume_problem}) {
    if (std::string problem = check(mesh); !problem.empty()) return problem;
  }
  return {};
}

}  // namespace surfaced::testing
