// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <vector>

#include "base/parallel.hpp"
#include "delaunay/delaunay.hpp"

namespace surfaced {
namespace {

/// Lists the greater ends of the edges of a run of vertices.
class EdgeLister {
 public:
  explicit EdgeLister(const DelaunayComplex& complex) : complex_(complex), seen_from_(complex.points()) {}

  /// Appends the greater ends of the edges whose lesser end is v, ascending; returns their number.
  std::uint32_t list(VertexIndex v, std::vector<VertexIndex>& greater) {
    const std::size_t before = greater.size();
    for (const SideIndex corner : complex_.star(v)) {
      // A cell's vertices ascend.
      for (std::size_t i = corner % 4 + 1; i < 4; ++i) {
        const VertexIndex other = complex_.table[corner / 4].vertices[i];
        if (other == complex_.points() || seen_from_[other] == v) continue;
        seen_from_[other] = v;
        greater.push_back(other);
      }
    }
    std::sort(greater.begin() + static_cast<std::ptrdiff_t>(before), greater.end());
    return static_cast<std::uint32_t>(greater.size() - before);
  }

 private:
  const DelaunayComplex& complex_;
  std::vector<VertexIndex> seen_from_;
};

}  // namespace

EdgeNumbering number_edges(const DelaunayComplex& complex, unsigned threads) {
  EdgeNumbering numbering;
  numbering.starts.assign(complex.points() + 1, 0);
  std::vector<std::vector<VertexIndex>> parts(threads);
  parallel_tasks(threads, threads, [&](std::size_t part) {
    EdgeLister lister(complex);
    const std::size_t end = complex.points() * (part + 1) / threads;
    for (std::size_t v = complex.points() * part / threads; v < end; ++v) {
      numbering.starts[v + 1] = lister.list(VertexIndex(v), parts[part]);
    }
  });
  for (std::size_t v = 0; v < complex.points(); ++v) numbering.starts[v + 1] += numbering.starts[v];
  numbering.greater = std::move(parts.front());
  numbering.greater.reserve(numbering.starts.back());
  for (std::size_t part = 1; part < parts.size(); ++part) {
    numbering.greater.insert(numbering.greater.end(), parts[part].begin(), parts[part].end());
    parts[part] = {};
  }
  return numbering;
}

EdgeIndex EdgeNumbering::find(VertexIndex a, VertexIndex b) const {
  // Halves without branches: which way it goes is a toss, and guessing wrong costs more than the step.
  const VertexIndex* first = greater.data() + starts[a];
  for (std::size_t left = starts[a + 1] - starts[a]; left > 1;) {
    const std::size_t half = left / 2;
    first += first[half - 1] < b ? half : 0;
    left -= half;
  }
  return EdgeIndex(static_cast<std::size_t>(first - greater.data()));
}

}  // namespace surfaced
