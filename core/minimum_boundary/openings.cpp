// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/openings.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "minimum_boundary/measures.hpp"

namespace surfaced::boundary {
namespace {

/// Vertices that only sheets touch keep the least of them; without it they would be in no triangle.
void keep_every_vertex(const TriangleMesh& mesh, std::vector<std::uint8_t>& cut) {
  std::vector<std::uint8_t> covered(mesh.positions.size(), 0);
  for (std::size_t t = 0; t < cut.size(); ++t) {
    if (cut[t] != 0) continue;
    for (const VertexIndex v : mesh.triangles[t]) covered[v] = 1;
  }
  for (std::size_t t = 0; t < cut.size(); ++t) {
    if (cut[t] == 0) continue;
    const bool alone = std::ranges::any_of(mesh.triangles[t], [&](VertexIndex v) { return covered[v] == 0; });
    if (!alone) continue;
    cut[t] = 0;
    for (const VertexIndex v : mesh.triangles[t]) covered[v] = 1;
  }
}

class Cutter {
 public:
  explicit Cutter(const TriangleMesh& mesh)
      : mesh_(mesh), cut_(mark_sheets(mesh.positions, mesh.triangles)), starts_(mesh.positions.size() + 1, 0) {
    keep_every_vertex(mesh, cut_);
    for (const Triangle& t : mesh.triangles) {
      for (const VertexIndex v : t) ++starts_[v + 1];
    }
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) starts_[v + 1] += starts_[v];
    corners_.resize(3 * mesh.triangles.size());
    std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
    for (std::size_t k = 0; k < corners_.size(); ++k) corners_[next[mesh.triangles[k / 3][k % 3]]++] = k;
  }

  /// Closes gaps again until every vertex has one fan; triangles only come back, so it ends.
  std::vector<std::uint8_t> run() {
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t v = 0; v < mesh_.positions.size(); ++v) changed |= leave_one_gap(v);
    }
    return std::move(cut_);
  }

 private:
  VertexIndex following(std::size_t corner) const { return mesh_.triangles[corner / 3][(corner % 3 + 1) % 3]; }
  VertexIndex preceding(std::size_t corner) const { return mesh_.triangles[corner / 3][(corner % 3 + 2) % 3]; }

  /// Corners at v in the order of its umbrella, from the first triangle that stays on; empty if none or all stay.
  std::vector<std::size_t> umbrella(std::size_t v) const {
    std::vector<std::size_t> ordered;
    const auto begin = corners_.begin() + static_cast<std::ptrdiff_t>(starts_[v]);
    const auto end = corners_.begin() + static_cast<std::ptrdiff_t>(starts_[v + 1]);
    const auto stays = [&](std::size_t corner) { return cut_[corner / 3] == 0; };
    const auto first = std::find_if(begin, end, stays);
    if (first == end || std::all_of(begin, end, stays)) return ordered;
    std::size_t at = *first;
    do {
      ordered.push_back(at);
      at = *std::find_if(begin, end, [&](std::size_t corner) { return following(corner) == preceding(at); });
    } while (at != *first);
    return ordered;
  }

  double width(std::size_t corner) const {
    return norm(mesh_.positions[following(corner)] - mesh_.positions[preceding(corner)]);
  }

  bool leave_one_gap(std::size_t v) {
    const std::vector<std::size_t> around = umbrella(v);
    if (around.empty()) return false;
    std::vector<std::vector<std::size_t>> gaps;
    for (std::size_t k = 0; k < around.size(); ++k) {
      if (cut_[around[k] / 3] == 0) continue;
      if (cut_[around[k - 1] / 3] == 0) gaps.emplace_back();  // the first one stays, so k > 0
      gaps.back().push_back(around[k]);
    }
    if (gaps.size() < 2) return false;
    const auto total = [&](const std::vector<std::size_t>& gap) {
      double sum = 0;
      for (const std::size_t corner : gap) sum += width(corner);
      return sum;
    };
    const auto widest = std::ranges::max_element(gaps, {}, total) - gaps.begin();
    for (std::size_t g = 0; g < gaps.size(); ++g) {
      if (static_cast<std::ptrdiff_t>(g) == widest) continue;
      for (const std::size_t corner : gaps[g]) cut_[corner / 3] = 0;
    }
    return true;
  }

  const TriangleMesh& mesh_;
  std::vector<std::uint8_t> cut_;
  /// Corners 3t+i of vertex v: corners_[starts_[v]] .. corners_[starts_[v+1]-1].
  std::vector<std::size_t> starts_;
  std::vector<std::size_t> corners_;
};

}  // namespace

std::size_t cut_openings(TriangleMesh& mesh) {
  const std::vector<std::uint8_t> cut = Cutter(mesh).run();
  std::size_t removed = 0;
  std::vector<Triangle> kept;
  for (std::size_t t = 0; t < cut.size(); ++t) {
    if (cut[t] == 0) {
      kept.push_back(mesh.triangles[t]);
    } else {
      ++removed;
    }
  }
  mesh.triangles = std::move(kept);
  return removed;
}

}  // namespace surfaced::boundary
