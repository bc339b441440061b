#include "minimum_boundary/candidates.hpp"

#include <array>
#include <atomic>
#include <optional>

#include "base/parallel.hpp"
#include "minimum_boundary/colouring.hpp"
#include "minimum_boundary/repair.hpp"

namespace surfaced::boundary {
namespace {

constexpr std::array kRecipes{Recipe::flooded, Recipe::cautious, Recipe::coloured, Recipe::coloured_strictly};
/// Votes below these, in units of the ball ratio, are not followed.
constexpr float kWeakVote = 0.3F;
constexpr float kStrongVote = 1.0F;

std::vector<std::uint8_t> first_labels(const Material& m, Recipe recipe) {
  switch (recipe) {
    case Recipe::flooded:
      return inside_of(m.thorough);
    case Recipe::cautious:
      return inside_of(m.cautious);
    case Recipe::coloured:
    case Recipe::coloured_strictly:
      break;
  }
  const bool strict = recipe == Recipe::coloured_strictly;
  std::vector<std::uint8_t> in = parity_colouring(m.complex, m.rated, m.colouring, strict ? kStrongVote : kWeakVote);
  clean(m.complex, !strict, in);
  return in;
}

/// One candidate from first labels to a manifold; none if cancelled.
std::optional<Candidate> make_candidate(const Material& m, Recipe recipe, const Context& context) {
  Candidate candidate{recipe, Labelling(m.complex), {}, {}, {}};
  candidate.labels.assign(first_labels(m, recipe), 1);
  if (recipe == Recipe::coloured || recipe == Recipe::coloured_strictly) {
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

std::string_view name_of(Recipe recipe) {
  switch (recipe) {
    case Recipe::flooded:
      return "flooded";
    case Recipe::cautious:
      return "cautious";
    case Recipe::coloured:
      return "coloured";
    case Recipe::coloured_strictly:
      return "coloured-strictly";
  }
  return {};
}

Result<std::vector<Candidate>> make_candidates(const Material& material, Context& context) {
  std::array<std::optional<Candidate>, kRecipes.size()> made;
  std::atomic<std::size_t> finished{0};
  parallel_tasks(context.threads(), kRecipes.size(), [&](std::size_t k) {
    made[k] = make_candidate(material, kRecipes[k], context);
    context.report(static_cast<double>(++finished) / kRecipes.size());
  });
  std::vector<Candidate> candidates;
  for (std::optional<Candidate>& candidate : made) {
    if (!candidate) return Error{ErrorCode::cancelled, "cancelled while making candidates"};
    candidates.push_back(std::move(*candidate));
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
