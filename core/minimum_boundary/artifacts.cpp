// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/artifacts.hpp"

#include <algorithm>

#include "base/union_find.hpp"

namespace surfaced::boundary {
namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFFU;

/// Per cell the artifact whose sliver it belongs to; kNone for the outside and the inside hull.
std::vector<std::uint32_t> sliver_sets(const Walls& walls, const Spaces& spaces, std::size_t& count) {
  const DelaunayComplex& complex = walls.complex();
  const auto sliver = [&](std::size_t c) {
    return spaces.of_cell[c] != Spaces::kOutside && spaces.inside[spaces.of_cell[c]] == 0;
  };
  UnionFind sets(spaces.count);
  for (std::size_t s = 0; s < 4 * complex.cells(); ++s) {
    const CellIndex beyond = complex.neighbour(SideIndex(s));
    if (sliver(s / 4) && sliver(beyond)) sets.unite(spaces.of_cell[s / 4], spaces.of_cell[beyond]);
  }
  std::vector<std::uint32_t> number_of_set(spaces.count, kNone);
  std::vector<std::uint32_t> artifact_of(complex.cells(), kNone);
  for (std::size_t c = 0; c < artifact_of.size(); ++c) {
    if (!sliver(c)) continue;
    std::uint32_t& number = number_of_set[sets.find(spaces.of_cell[c])];
    if (number == kNone) number = static_cast<std::uint32_t>(count++);
    artifact_of[c] = number;
  }
  return artifact_of;
}

class Finder {
 public:
  explicit Finder(const Walls& walls) : walls_(walls), complex_(walls.complex()) {
    std::size_t count = 0;
    artifact_of_ = sliver_sets(walls, find_spaces(walls), count);
    artifacts_.resize(count);
  }

  std::vector<Artifact> run() {
    list_sides();
    regions_ = UnionFind(sides_.size());
    for (std::size_t k = 0; k < sides_.size(); ++k) {
      for (const VertexIndex behind : complex_.facet(sides_[k])) turn(k, behind);
    }
    for (const Crossing& c : crossings_) {
      Artifact& artifact = artifacts_[artifact_behind(sides_[c.from])];
      ++artifact.boundary_edges;
      if (regions_.find(c.from) == regions_.find(c.to)) artifact.hull_hole = true;
    }
    for (Artifact& a : artifacts_) {
      std::ranges::sort(a.vertices);
      a.vertices.erase(std::unique(a.vertices.begin(), a.vertices.end()), a.vertices.end());
    }
    return std::move(artifacts_);
  }

 private:
  /// An edge of L, between two sides of H(T).
  struct Crossing {
    std::size_t from;
    std::size_t to;
  };

  std::uint32_t artifact_behind(SideIndex s) const { return artifact_of_[complex_.neighbour(s)]; }

  /// Sides of H(T): facets of a sliver set seen from elsewhere.
  void list_sides() {
    number_of_.assign(4 * complex_.cells(), kNone);
    for (std::size_t s = 0; s < number_of_.size(); ++s) {
      const std::uint32_t artifact = artifact_behind(SideIndex(s));
      if (artifact == kNone || artifact == artifact_of_[s / 4]) continue;
      number_of_[s] = static_cast<std::uint32_t>(sides_.size());
      sides_.emplace_back(s);
      for (const VertexIndex v : complex_.facet(SideIndex(s))) artifacts_[artifact].vertices.push_back(v);
    }
  }

  /// From a side of H(T) over the edge opposite `behind`, around it outside T, to the next side of H(T). The edge
  /// belongs to L if other triangles of BC are passed on the way.
  void turn(std::size_t k, VertexIndex behind) {
    const std::uint32_t artifact = artifact_behind(sides_[k]);
    bool passed = false;
    for (SideIndex entry = sides_[k];;) {
      std::size_t exit = entry / 4 * 4;
      while (complex_.vertex(exit) != behind) ++exit;
      if (artifact_behind(SideIndex(exit)) == artifact) {
        if (passed) {
          crossings_.push_back({k, number_of_[exit]});
        } else {
          regions_.unite(k, number_of_[exit]);
        }
        return;
      }
      passed = passed || walls_.contains(SideIndex(exit));
      behind = complex_.vertex(entry);
      entry = complex_.mate(exit);
    }
  }

  const Walls& walls_;
  const DelaunayComplex& complex_;
  std::vector<std::uint32_t> artifact_of_;
  std::vector<Artifact> artifacts_;
  std::vector<std::uint32_t> number_of_;
  std::vector<SideIndex> sides_;
  UnionFind regions_{0};
  std::vector<Crossing> crossings_;
};

}  // namespace

std::vector<Artifact> find_artifacts(const Walls& walls) { return Finder(walls).run(); }

}  // namespace surfaced::boundary
