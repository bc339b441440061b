// SPDX-License-Identifier: GPL-3.0-or-later
#include "minimum_boundary/candidates.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <optional>

#include "base/parallel.hpp"
#include "minimum_boundary/colouring.hpp"
#include "minimum_boundary/repair.hpp"

namespace surfaced::boundary {
namespace {

/// Votes below these, in units of the ball ratio, are not followed.
constexpr float kWeakVote = 0.3F;
constexpr float kStrongVote = 1.0F;

/// Below so many points a candidate takes a few milliseconds.
constexpr std::size_t kSmallCloud = 5000;
constexpr std::array kFurtherLevels{1.6F, 1.5F, 1.3F, 1.2F, 1.1F};

std::vector<std::uint8_t> first_labels(const Material& m, const Recipe& recipe) {
  const auto level = std::ranges::find(m.levels, recipe.level) - m.levels.begin();
  const Clusters& clusters = m.clusters[static_cast<std::size_t>(level)];
  if (recipe.kind == Recipe::Kind::flooded) return inside_of(clusters);
  const bool strict = recipe.kind == Recipe::Kind::coloured_strictly;
  std::vector<std::uint8_t> in = parity_colouring(m.complex, m.rated, clusters, strict ? kStrongVote : kWeakVote);
  clean(m.complex, !strict, in);
  return in;
}

/// One candidate from first labels to a manifold; none if cancelled.
std::optional<Candidate> make_candidate(const Material& m, const Recipe& recipe, const Context& context) {
  Candidate candidate{recipe, Labelling(m.complex), {}, {}, {}};
  candidate.labels.assign(first_labels(m, recipe), 1);
  if (recipe.kind != Recipe::Kind::flooded) {
    if (!Repairer(candidate.labels, m.criterion, 1).repair_all(context)) return std::nullopt;
  }
  const Result<Inflated> inflated = inflate(candidate.labels, m.boundary.facets, m.criterion, context, 1);
  if (!inflated) return std::nullopt;
  const Result<Descent> descent = descend(candidate.labels, m.criterion, context, 1);
  if (!descent) return std::nullopt;
  candidate.inflated = *inflated;
  candidate.descent = *descent;
  candidate.measures = measure(candidate.labels, m.criterion);
  return candidate;
}

}  // namespace

std::string name_of(const Recipe& recipe) {
  constexpr std::array kNames{"flooded", "coloured", "coloured-strictly"};
  const long hundredths = std::lround(100 * recipe.level);
  return std::string(kNames[static_cast<std::size_t>(recipe.kind)]) + " at " + std::to_string(hundredths / 100) + "." +
         std::to_string(hundredths % 100 / 10) + std::to_string(hundredths % 10);
}

std::vector<Recipe> recipes_for(std::size_t points) {
  using Kind = Recipe::Kind;
  std::vector<Recipe> recipes{{Kind::flooded, kThoroughLevel},
                              {Kind::coloured, kColouringLevel},
                              {Kind::coloured_strictly, kColouringLevel},
                              {Kind::flooded, kCautiousLevel}};
  if (points >= kSmallCloud) return recipes;
  for (const float level : kFurtherLevels) {
    for (const Kind kind : {Kind::flooded, Kind::coloured, Kind::coloured_strictly}) recipes.push_back({kind, level});
  }
  return recipes;
}

std::vector<float> levels_of(const std::vector<Recipe>& recipes) {
  std::vector<float> levels;
  for (const Recipe& recipe : recipes) levels.push_back(recipe.level);
  std::ranges::sort(levels, std::greater<>());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  return levels;
}

Result<std::vector<Candidate>> make_candidates(const Material& material, Context& context) {
  std::vector<std::optional<Candidate>> made(material.recipes.size());
  std::atomic<std::size_t> finished{0};
  parallel_tasks(context.threads(), made.size(), [&](std::size_t k) {
    made[k] = make_candidate(material, material.recipes[k], context);
    context.report(static_cast<double>(++finished) / static_cast<double>(made.size()));
  });
  std::vector<Candidate> candidates;
  for (std::optional<Candidate>& candidate : made) {
    if (!candidate) return Error{ErrorCode::cancelled, "cancelled while making candidates"};
    candidates.push_back(std::move(*candidate));
    candidate.reset();
  }
  return candidates;
}

std::size_t best_of(const std::vector<Candidate>& candidates, bool one_component) {
  const Measures& first = candidates.front().measures;
  const Judge judge{static_cast<double>(first.energy) / static_cast<double>(first.facets)};
  std::size_t best = 0;
  for (std::size_t k = 1; k < candidates.size(); ++k) {
    const Measures& a = candidates[k].measures;
    const Measures& b = candidates[best].measures;
    if (one_component && a.components != b.components) {
      if (a.components < b.components) best = k;
    } else if (judge.score(a) < judge.score(b)) {
      best = k;
    }
  }
  return best;
}

}  // namespace surfaced::boundary
