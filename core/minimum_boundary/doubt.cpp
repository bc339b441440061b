// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/doubt.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "minimum_boundary/solid_angles.hpp"

namespace surfaced::boundary {
namespace {

/// A margin of so many mean λ counts a third of none.
constexpr double kMargin = 10;

struct Term {
  double weight;
  double value;
};

}  // namespace

// As doubt_fit.py prints it.
const double kDoubtful = 0.456;

double doubt_of(const MinimumBoundaryStatistics& s, std::size_t points) {
  const MinimumBoundaryEvidence& e = *s.evidence;
  const auto n = static_cast<double>(points);
  const auto root_of_share = [&](std::size_t count) { return std::sqrt(static_cast<double>(count) / n); };
  const auto genus = static_cast<std::size_t>(std::max<std::int64_t>(0, s.genus));
  const double margin = s.topology_margin.value_or(std::numeric_limits<double>::infinity());
  const double thin = std::min(SolidAngles::kHollowShare, static_cast<double>(s.thin_vertices) / n);
  const std::array terms{
      Term{-7.102, 1},
      Term{1.260, e.more_handles},
      Term{1.885, e.fewer_handles},
      Term{2.927, e.guide_agrees ? 0.0 : 1.0},
      Term{3.095, 1 - e.guide_shared},
      Term{-2.459, std::sqrt(e.opposed_triangles)},
      Term{7.892, std::sqrt(s.sampling->share_above_one)},
      Term{1.366, std::exp(-margin / kMargin)},
      Term{-10.141, std::sqrt(thin)},
      Term{8.469, root_of_share(s.buried_vertices)},
      Term{38.899, root_of_share(genus)},
      Term{1.649, std::max(0.0, 1 - e.candidates_agreeing - e.more_handles - e.fewer_handles)},
  };
  double sum = 0;
  for (const Term& term : terms) sum += term.weight * term.value;
  return 1 / (1 + std::exp(-sum));
}

}  // namespace surfaced::boundary
