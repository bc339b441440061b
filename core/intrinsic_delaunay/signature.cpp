// SPDX-License-Identifier: GPL-3.0-or-later
// Source: paper 3, §3.2.
#include "intrinsic_delaunay/signature.hpp"

#include <algorithm>
#include <cmath>

namespace surfaced::idt {
namespace {

/// Keeps a spread finite where both ends are 0.
constexpr double kFlat = 1e-6;

double spread(double low, double high) { return (high - low) / (std::abs(high) + std::abs(low) + kFlat); }

}  // namespace

Signature signature_of(std::span<const LocalShape::Curvature> curvatures, double epsilon) {
  if (curvatures.empty()) return {};
  double least_h = 0, most_h = 0, least_k = 0, most_k = 0, sum_h = 0, sum_k = 0;
  bool first = true;
  for (const LocalShape::Curvature& each : curvatures) {
    const double h = each.mean * epsilon;
    const double k = each.gaussian * epsilon * epsilon;
    least_h = first ? h : std::min(least_h, h);
    most_h = first ? h : std::max(most_h, h);
    least_k = first ? k : std::min(least_k, k);
    most_k = first ? k : std::max(most_k, k);
    sum_h += h;
    sum_k += k;
    first = false;
  }
  const auto count = static_cast<double>(curvatures.size());
  return {least_h,       most_h,       least_k, most_k, spread(least_h, most_h), spread(least_k, most_k),
          sum_h / count, sum_k / count};
}

double similarity(const Signature& f, const Signature& g) {
  double ff = 0;
  double gg = 0;
  double fg = 0;
  for (std::size_t i = 0; i < f.size(); ++i) {
    ff += f[i] * f[i];
    gg += g[i] * g[i];
    fg += f[i] * g[i];
  }
  const double below = ff + gg - fg;
  return below > 0 ? fg / below : 1;
}

}  // namespace surfaced::idt
