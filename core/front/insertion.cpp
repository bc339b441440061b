// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <optional>

#include "front/closing.hpp"

namespace surfaced::front {
namespace {

/// How well the point fits into the face: the least cosine between the face and the three that replace it.
double fit(const Places& places, const Face& face, std::uint32_t v) {
  const Point3 normal = area_normal(places, face);
  double least = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    least = std::min(least, cosine(normal, area_normal(places, {face[i], face[(i + 1) % 3], v})));
  }
  return least;
}

struct Choice {
  Face face;
  double fit;
};

/// The face at v's neighbours into which v fits best.
std::optional<Choice> best_face(const Fans& fans, Places& places, std::uint32_t v) {
  constexpr double kLeastFit = 0.2;
  std::optional<Choice> best;
  for (const std::uint32_t u : places.neighbours(v)) {
    for (const Wedge& w : fans.wedges(u)) {
      if (u > w.first || u > w.second) continue;
      const Face face{u, w.first, w.second};
      const double value = fit(places, face, v);
      if (value < kLeastFit || (best && value <= best->fit)) continue;
      const bool all_short = std::ranges::all_of(face, [&](std::uint32_t c) { return places.short_enough(v, c); });
      if (all_short) best = Choice{face, value};
    }
  }
  return best;
}

}  // namespace

std::size_t insert_leftovers(Fans& fans, Places& places) {
  std::size_t inserted = 0;
  for (const std::uint32_t v : fans.unsettled()) {
    if (fans.around(v) != Around::nothing) continue;
    const std::optional<Choice> choice = best_face(fans, places, v);
    if (!choice) continue;
    const Face& f = choice->face;
    fans.remove(f);
    for (std::size_t i = 0; i < 3; ++i) fans.add({f[i], f[(i + 1) % 3], v});
    ++inserted;
  }
  return inserted;
}

}  // namespace surfaced::front
