// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/sampling.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"
#include "minimum_boundary/ball_ratio.hpp"

namespace surfaced::boundary {
namespace {

double longest_edge_at(const Labelling& labels, SideIndex corner) {
  const DelaunayComplex& complex = labels.complex();
  const std::size_t cell = corner / 4;
  const Point3& v = complex.positions[complex.vertex(corner)];
  double longest = 0;
  for (unsigned bits = labels.border(CellIndex(cell)) & ~(1U << (corner % 4)); bits != 0; bits &= bits - 1) {
    const auto beyond = static_cast<std::size_t>(std::countr_zero(bits));
    for (std::size_t i = 0; i < 4; ++i) {
      if (i == beyond || 4 * cell + i == corner) continue;
      longest = std::max(longest, norm(complex.positions[complex.vertex(4 * cell + i)] - v));
    }
  }
  return longest;
}

double epsilon_at(const Labelling& labels, const BallRatio& balls, VertexIndex v) {
  double inner = 0;
  double outer = 0;
  double longest = 0;
  for (const SideIndex corner : labels.complex().star(v)) {
    const CellIndex c = DelaunayComplex::cell_of(corner);
    const double radius =
        labels.complex().infinite(c) ? std::numeric_limits<double>::infinity() : static_cast<double>(balls.radius(c));
    double& pole = labels.in(c) ? inner : outer;
    pole = std::max(pole, radius);
    if (labels.in(c)) longest = std::max(longest, longest_edge_at(labels, corner));
  }
  const double feature = std::min(inner, outer);
  return feature > 0 ? longest / std::sqrt(3.0) / feature : 0;
}

}  // namespace

Sampling sampling_of(const Labelling& labels, unsigned threads) {
  const DelaunayComplex& complex = labels.complex();
  const BallRatio balls(complex, threads);
  Sampling sampling;
  sampling.epsilon.resize(complex.points());
  parallel_ranges(threads, complex.points(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      sampling.epsilon[v] = static_cast<float>(epsilon_at(labels, balls, VertexIndex(v)));
    }
  });
  std::vector<float> known;
  for (const float e : sampling.epsilon) {
    if (e > 0) known.push_back(e);
  }
  if (known.empty()) return sampling;
  std::ranges::sort(known);
  sampling.median = static_cast<double>(known[known.size() / 2]);
  sampling.high = static_cast<double>(known[known.size() - 1 - known.size() / 20]);
  const auto above = known.end() - std::ranges::upper_bound(known, 1.0F);
  sampling.share_above_one = static_cast<double>(above) / static_cast<double>(known.size());
  return sampling;
}

}  // namespace surfaced::boundary
