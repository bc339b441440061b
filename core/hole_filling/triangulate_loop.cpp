// SPDX-License-Identifier: GPL-3.0-or-later
// Source: G. Barequet, M. Sharir, "Filling gaps in the boundary of a polyhedron", CAGD 12 (1995); P. Liepa,
// "Filling holes in meshes", SGP 2003.
#include <limits>

#include "hole_filling/hole_filling.hpp"

namespace surfaced {
namespace {

constexpr double kImpossible = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kNoSplit = 0xFFFFFFFFU;

class Triangulation {
 public:
  Triangulation(const Loop& loop, const LoopLimits& limits)
      : loop_(loop), limits_(limits), n_(loop.corners.size()), area_(n_ * n_, kImpossible), split_(n_ * n_, kNoSplit) {}

  std::optional<std::vector<std::array<std::uint32_t, 3>>> operator()() {
    if (n_ < 3) return std::nullopt;
    for (std::size_t i = 0; i + 1 < n_; ++i) area_[at(i, i + 1)] = 0;
    for (std::size_t length = 2; length < n_; ++length) {
      for (std::size_t i = 0; i + length < n_; ++i) solve(i, i + length);
    }
    if (split_[at(0, n_ - 1)] == kNoSplit) return std::nullopt;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    collect(0, n_ - 1, triangles);
    return triangles;
  }

 private:
  std::size_t at(std::size_t i, std::size_t j) const { return i * n_ + j; }

  Point3 normal(std::size_t i, std::size_t j, std::size_t k) const {
    const Point3& a = loop_.corners[i];
    return cross(loop_.corners[j] - a, loop_.corners[k] - a);
  }

  bool bends_too_much(const Point3& a, const Point3& b) const {
    const double lengths = norm(a) * norm(b);
    return !(dot(a, b) >= limits_.least_cosine * lengths) || !(lengths > 0);
  }

  /// Normal of the face across the edge i -> j of the sub-polygon i..j: the loop's neighbour or a triangle
  /// already chosen.
  Point3 across(std::size_t i, std::size_t j) const {
    if (j == i + 1) {
      const Point3& b = loop_.corners[j];
      return cross(loop_.corners[i] - b, loop_.beyond[i] - b);
    }
    return normal(i, split_[at(i, j)], j);
  }

  void solve(std::size_t i, std::size_t j) {
    const bool last = i == 0 && j == n_ - 1;
    if (!last && limits_.may_join && !limits_.may_join(i, j)) return;
    for (std::size_t k = i + 1; k < j; ++k) {
      if (area_[at(i, k)] == kImpossible || area_[at(k, j)] == kImpossible) continue;
      const Point3 n = normal(i, k, j);
      const double area = area_[at(i, k)] + area_[at(k, j)] + norm(n);
      if (!(area < area_[at(i, j)])) continue;
      if (bends_too_much(n, across(i, k)) || bends_too_much(n, across(k, j))) continue;
      if (last && bends_too_much(n, closing_normal())) continue;
      area_[at(i, j)] = area;
      split_[at(i, j)] = static_cast<std::uint32_t>(k);
    }
  }

  /// Normal beyond the loop's last edge, from corner n-1 to corner 0.
  Point3 closing_normal() const {
    const Point3& a = loop_.corners[0];
    return cross(loop_.corners[n_ - 1] - a, loop_.beyond[n_ - 1] - a);
  }

  void collect(std::size_t i, std::size_t j, std::vector<std::array<std::uint32_t, 3>>& triangles) const {
    if (j == i + 1) return;
    const std::uint32_t k = split_[at(i, j)];
    triangles.push_back({static_cast<std::uint32_t>(i), k, static_cast<std::uint32_t>(j)});
    collect(i, k, triangles);
    collect(k, j, triangles);
  }

  const Loop& loop_;
  const LoopLimits& limits_;
  std::size_t n_;
  std::vector<double> area_;
  std::vector<std::uint32_t> split_;
};

}  // namespace

std::optional<std::vector<std::array<std::uint32_t, 3>>> triangulate_loop(const Loop& loop, const LoopLimits& limits) {
  return Triangulation(loop, limits)();
}

}  // namespace surfaced
