// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/artifacts.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include "base/union_find.hpp"

namespace surfaced::boundary {
namespace {

class Finder {
 public:
  explicit Finder(const Walls& walls)
      : walls_(walls), complex_(walls.complex()), crowded_(complex_.points(), 0), parts_(complex_.points()) {}

  std::vector<Artifact> run() {
    mark_crowded_vertices();
    list_sides();
    connect();
    return collect();
  }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  /// u-valence above 1: more than two groups of cells around the vertex.
  void mark_crowded_vertices() {
    WalledStar star(complex_);
    for (std::size_t v = 0; v < crowded_.size(); ++v) {
      crowded_[v] = star.groups(walls_, VertexIndex(v)).size() > 2 ? 1 : 0;
    }
  }

  VertexIndex crowded_vertex_of(SideIndex s) const {
    for (const VertexIndex v : complex_.facet(s)) {
      if (crowded_[v] != 0) return v;
    }
    return {};
  }

  /// Hull sides at crowded vertices; crowded vertices of one triangle belong to one artifact.
  void list_sides() {
    number_of_.assign(4 * complex_.cells(), kNone);
    for (std::size_t s = 0; s < number_of_.size(); ++s) {
      if (!walls_.hull_side(SideIndex(s))) continue;
      const VertexIndex first = crowded_vertex_of(SideIndex(s));
      if (!first.valid()) continue;
      number_of_[s] = static_cast<std::uint32_t>(sides_.size());
      sides_.emplace_back(s);
      for (const VertexIndex v : complex_.facet(SideIndex(s))) {
        if (crowded_[v] != 0) parts_.unite(first, v);
      }
    }
  }

  /// Joins hull sides that follow one another on the hull; notes where they leave the artifact.
  void connect() {
    regions_ = UnionFind(sides_.size());
    for (std::size_t k = 0; k < sides_.size(); ++k) {
      const auto facet = complex_.facet(sides_[k]);
      for (std::size_t i = 0; i < 3; ++i) {
        const SideIndex next = next_hull_side(walls_, sides_[k], facet[i]);
        if (number_of_[next] != kNone) {
          regions_.unite(k, number_of_[next]);
        } else {
          boundary_.push_back({k, facet[(i + 1) % 3], facet[(i + 2) % 3]});
        }
      }
    }
  }

  std::vector<Artifact> collect() {
    std::map<std::uint32_t, Artifact> by_part;
    for (const SideIndex s : sides_) {
      Artifact& artifact = by_part[parts_.find(crowded_vertex_of(s))];
      for (const VertexIndex v : complex_.facet(s)) artifact.vertices.push_back(v);
    }
    std::vector<std::tuple<std::uint32_t, VertexIndex, VertexIndex, std::uint32_t>> crossings;
    for (const Crossing& c : boundary_) {
      crossings.emplace_back(regions_.find(c.side), std::min(c.a, c.b), std::max(c.a, c.b),
                             parts_.find(crowded_vertex_of(sides_[c.side])));
    }
    std::ranges::sort(crossings);
    for (std::size_t k = 0; k < crossings.size(); ++k) {
      Artifact& artifact = by_part[std::get<3>(crossings[k])];
      ++artifact.boundary_edges;
      if (k > 0 && crossings[k] == crossings[k - 1]) artifact.hull_hole = true;
    }
    std::vector<Artifact> artifacts;
    for (auto& [part, artifact] : by_part) {
      std::ranges::sort(artifact.vertices);
      artifact.vertices.erase(std::unique(artifact.vertices.begin(), artifact.vertices.end()), artifact.vertices.end());
      artifacts.push_back(std::move(artifact));
    }
    return artifacts;
  }

  struct Crossing {
    std::size_t side;
    VertexIndex a;
    VertexIndex b;
  };

  const Walls& walls_;
  const DelaunayComplex& complex_;
  std::vector<std::uint8_t> crowded_;
  UnionFind parts_;
  std::vector<std::uint32_t> number_of_;
  std::vector<SideIndex> sides_;
  UnionFind regions_{0};
  std::vector<Crossing> boundary_;
};

}  // namespace

std::vector<Artifact> find_artifacts(const Walls& walls) { return Finder(walls).run(); }

}  // namespace surfaced::boundary
