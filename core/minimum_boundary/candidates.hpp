// SPDX-License-Identifier: GPL-3.0-or-later
// Several labellings made in different ways, each brought to a manifold; the best is kept.
#pragma once

#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "minimum_boundary/descent.hpp"
#include "minimum_boundary/guiding_surface.hpp"
#include "minimum_boundary/inflating.hpp"
#include "minimum_boundary/measures.hpp"
#include "minimum_boundary/solid_angles.hpp"
#include "minimum_boundary/watershed.hpp"

namespace surfaced::boundary {

/// How a candidate's first labels are made, from the clusters at one level of the watershed.
struct Recipe {
  enum class Kind : std::uint8_t {
    /// Outside is what the watershed has joined to infinity.
    flooded,
    /// Parity colouring that follows weak votes; cavities and islands cleaned; symmetric repair.
    coloured,
    /// Parity colouring that follows strong votes only; cavities cleaned; symmetric repair.
    coloured_strictly,
    /// Labels spread from a guiding surface through the points; symmetric repair.
    guided,
    /// Labels by the winding number of a guiding surface through other points; symmetric repair.
    wound,
  };
  Kind kind = Kind::flooded;
  float level = 0;
  /// Of kinds guided and wound: which guiding surface.
  std::size_t guide = 0;
};
/// As "coloured at 1.40", "guided 0".
std::string name_of(const Recipe& recipe);

/// The recipes for a cloud of so many points: flood at the thorough level, colouring, strict colouring, flood at
/// the cautious level (for noise), in this order; for small clouds, where time does not matter and sampling is
/// sparse, further levels.
std::vector<Recipe> recipes_for(std::size_t points);
/// Their levels, descending.
std::vector<float> levels_of(const std::vector<Recipe>& recipes);

struct Candidate {
  Recipe recipe;
  Labelling labels;
  Measures measures;
  Inflated inflated;
  Descent descent;
  /// Measured where there is reason to.
  std::optional<SolidAngles> angles = std::nullopt;
};

/// What the candidates are made from.
struct Material {
  const DelaunayComplex& complex;
  const Criterion& criterion;
  const BoundaryComplex& boundary;
  const RatedFacets& rated;
  const std::vector<Recipe>& recipes;
  const std::vector<float>& levels;
  /// At each level.
  const std::vector<Clusters>& clusters;
  const std::vector<GuidingSurface>& guides;
};

/// Makes all candidates, in the order of the recipes, each on one thread, several at a time.
/// @return  cancelled.
Result<std::vector<Candidate>> make_candidates(const Material& material, Context& context);
/// The same for a large cloud; only the coloured and the guided one where the guiding surface is nearly closed through
/// nearly all points and the two, which were made in ways that have nothing in common, leave no point inside and have
/// the same topology.
Result<std::vector<Candidate>> make_candidates_until_sure(const Material& material, Context& context);

/// Weighs Σλ in units of a mean λ against interior vertices and handles that are missing or too many; less is better.
struct Judge {
  double mean_energy;
  std::int64_t usual_handles = 0;
  static constexpr double kInterior = 6;
  /// A handle too many, and one that is missing or too many where most candidates agree on a number.
  static constexpr double kHandle = 3;
  static constexpr double kWitnessed = 6;
  /// What a component too many or too few costs, in mean λ for each point: a fortieth of the Σλ of a body. Bridges join
  /// an islet; a cage, whose Σλ is a fifth higher, stays one.
  static constexpr double kComponent = 0.05;
  static double component_price(std::size_t points) { return kComponent * static_cast<double>(points); }
  static double handle_price(std::int64_t usual) { return usual > 0 ? kWitnessed : kHandle; }
  double score(const Measures& m) const {
    return static_cast<double>(m.energy) / mean_energy + kInterior * static_cast<double>(m.interior) +
           handle_price(usual_handles) * static_cast<double>(std::abs(m.handles() - usual_handles));
  }
};

/// The handles that more than half of the candidates have, where they are many; else 0.
std::int64_t usual_handles(const std::vector<Candidate>& candidates);

/// Whether a candidate whose angles were measured is in large part a ribbon that turns back upon itself.
bool hollow(const Candidate& candidate);

/// Measures the angles of all candidates.
void measure_angles(std::vector<Candidate>& candidates, unsigned threads);

/// The candidate of least score, hollow ones at a disadvantage, among those whose number of components is nearest to
/// `bodies`; among all if that is 0.
std::size_t best_of(const std::vector<Candidate>& candidates, std::size_t bodies);

}  // namespace surfaced::boundary
