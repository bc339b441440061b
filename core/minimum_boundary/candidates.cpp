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
#include "minimum_boundary/winding.hpp"

namespace surfaced::boundary {
namespace {

/// Votes below these, in units of the ball ratio, are not followed.
constexpr float kWeakVote = 0.3F;
constexpr float kStrongVote = 1.0F;

/// So many, made in different ways, are witnesses.
constexpr std::size_t kManyCandidates = 10;
/// What each thin vertex of a hollow candidate costs, in mean λ: of the 2 that a vertex adds to Σλ.
constexpr double kThinVertex = 1;

/// Below so many points a candidate takes a few milliseconds.
constexpr std::size_t kSmallCloud = 5000;
/// Open edges and unused points of the guiding surface, for each point, up to which it counts as closed.
constexpr double kFewOpenEdges = 0.01;
constexpr double kFewUnusedPoints = 0.001;
constexpr std::array kFurtherLevels{1.6F, 1.5F, 1.3F, 1.2F, 1.1F};

std::vector<std::uint8_t> first_labels(const Material& m, const Recipe& recipe, const Context& context) {
  if (recipe.kind == Recipe::Kind::guided) return guided_labels(m.complex, m.rated, m.guides[recipe.guide]);
  if (recipe.kind == Recipe::Kind::wound) return wound_labels(m.complex, m.guides[recipe.guide], context, 1);
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
  Candidate candidate{recipe, Labelling(m.complex), {}, {}, {}, {}};
  candidate.labels.assign(first_labels(m, recipe, context), 1);
  Result<Inflated> inflated = Inflated{};
  if (recipe.kind == Recipe::Kind::flooded) {
    inflated = inflate(candidate.labels, m.boundary.facets, m.criterion, context, 1);
  } else {
    Repairer repairer(candidate.labels, m.criterion, 1);
    if (!repairer.repair_all(context)) return std::nullopt;
    inflated = inflate_known(candidate.labels, m.boundary.facets, m.criterion, repairer.good_vertices(), context);
  }
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
  if (recipe.kind == Recipe::Kind::guided) return "guided " + std::to_string(recipe.guide);
  if (recipe.kind == Recipe::Kind::wound) return "wound " + std::to_string(recipe.guide);
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
  for (const Recipe& recipe : recipes) {
    if (recipe.level > 0) levels.push_back(recipe.level);
  }
  std::ranges::sort(levels, std::greater<>());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  return levels;
}

namespace {

using Made = std::vector<std::optional<Candidate>>;

/// Makes those of the recipes that are wanted and not yet made; false if cancelled.
bool make_some(const Material& material, const std::function<bool(const Recipe&)>& wanted, Made& made,
               Context& context) {
  std::vector<std::size_t> left;
  for (std::size_t k = 0; k < made.size(); ++k) {
    if (!made[k] && wanted(material.recipes[k])) left.push_back(k);
  }
  std::atomic<std::size_t> finished{made.size() - left.size()};
  parallel_tasks(context.threads(), left.size(), [&](std::size_t k) {
    made[left[k]] = make_candidate(material, material.recipes[left[k]], context);
    context.report(static_cast<double>(++finished) / static_cast<double>(made.size()));
  });
  return std::ranges::all_of(left, [&](std::size_t k) { return made[k].has_value(); });
}

/// Scans have small openings, and points that fit nowhere.
bool nearly_closed(const GuidingSurface& guide) {
  const auto points = static_cast<double>(guide.positions.size());
  return static_cast<double>(guide.open_edges) <= kFewOpenEdges * points &&
         static_cast<double>(guide.unused_points) <= kFewUnusedPoints * points;
}

/// Whether all that were made leave no point inside and show the same topology.
bool agree(const Made& made) {
  const Measures* first = nullptr;
  for (const std::optional<Candidate>& c : made) {
    if (!c) continue;
    const Measures& m = c->measures;
    if (first == nullptr) first = &m;
    if (m.interior > 0 || m.components != first->components || m.handles() != first->handles()) return false;
  }
  return true;
}

Result<std::vector<Candidate>> those_of(Made made) {
  std::vector<Candidate> candidates;
  for (std::optional<Candidate>& candidate : made) {
    if (candidate) candidates.push_back(std::move(*candidate));
    candidate.reset();
  }
  return candidates;
}

Error cancelled_while_making() { return {ErrorCode::cancelled, "cancelled while making candidates"}; }

/// All, of which some may be made already.
Result<std::vector<Candidate>> make_all(const Material& material, Made made, Context& context) {
  const auto any = [](const Recipe&) { return true; };
  if (!make_some(material, any, made, context)) return cancelled_while_making();
  return those_of(std::move(made));
}

}  // namespace

Result<std::vector<Candidate>> make_candidates(const Material& material, Context& context) {
  return make_all(material, Made(material.recipes.size()), context);
}

Result<std::vector<Candidate>> make_candidates_until_sure(const Material& material, Context& context) {
  Made made(material.recipes.size());
  const GuidingSurface& guide = material.guides.front();
  if (made.size() < kManyCandidates && nearly_closed(guide)) {
    const auto of_two_ways = [](const Recipe& r) {
      return r.kind == Recipe::Kind::guided || r.kind == Recipe::Kind::coloured;
    };
    if (!make_some(material, of_two_ways, made, context)) return cancelled_while_making();
    if (agree(made)) return those_of(std::move(made));
  }
  return make_all(material, std::move(made), context);
}

std::int64_t usual_handles(const std::vector<Candidate>& candidates) {
  if (candidates.size() < kManyCandidates) return 0;
  for (const Candidate& c : candidates) {
    const auto same = std::ranges::count_if(
        candidates, [&](const Candidate& other) { return other.measures.handles() == c.measures.handles(); });
    if (2 * static_cast<std::size_t>(same) > candidates.size()) return c.measures.handles();
  }
  return 0;
}

bool hollow(const Candidate& c) { return c.angles && c.angles->thin_share() > SolidAngles::kHollowShare; }

void measure_angles(std::vector<Candidate>& candidates, unsigned threads) {
  parallel_tasks(threads, candidates.size(), [&](std::size_t k) {
    if (!candidates[k].angles) candidates[k].angles = solid_angles(candidates[k].labels, 1);
  });
}

std::size_t best_of(const std::vector<Candidate>& candidates, std::size_t bodies) {
  const Measures& first = candidates.front().measures;
  const Judge judge{static_cast<double>(first.energy) / static_cast<double>(first.facets), usual_handles(candidates)};
  const double component = Judge::component_price(first.vertices + first.interior);
  const auto rank = [&](const Candidate& c) {
    const std::size_t components = c.measures.components;
    const std::size_t off = bodies == 0 ? 0 : std::max(components, bodies) - std::min(components, bodies);
    return judge.score(c.measures) + component * static_cast<double>(off) +
           (hollow(c) ? kThinVertex * static_cast<double>(c.angles->thin) : 0);
  };
  std::size_t best = 0;
  for (std::size_t k = 1; k < candidates.size(); ++k) {
    if (rank(candidates[k]) < rank(candidates[best])) best = k;
  }
  return best;
}

}  // namespace surfaced::boundary
