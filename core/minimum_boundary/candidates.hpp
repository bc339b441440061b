// SPDX-License-Identifier: GPL-3.0-or-later
// Several labellings made in different ways, each brought to a manifold; the best is kept.
#pragma once

#include <string>
#include <vector>

#include "minimum_boundary/descent.hpp"
#include "minimum_boundary/inflating.hpp"
#include "minimum_boundary/measures.hpp"
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
  };
  Kind kind = Kind::flooded;
  float level = 0;
};
/// As "coloured at 1.40".
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
};

/// Makes all candidates, in the order of the recipes, each on one thread, several at a time.
/// @return  cancelled.
Result<std::vector<Candidate>> make_candidates(const Material& material, Context& context);

/// Weighs Σλ in units of a mean λ against interior vertices and handles; less is better.
struct Judge {
  double mean_energy;
  static constexpr double kInterior = 6;
  static constexpr double kHandle = 3;
  double score(const Measures& m) const {
    return static_cast<double>(m.energy) / mean_energy + kInterior * static_cast<double>(m.interior) +
           kHandle * static_cast<double>(m.handles());
  }
};

/// The candidate of least (components, score), or of least score where several components are welcome.
std::size_t best_of(const std::vector<Candidate>& candidates, bool one_component);

}  // namespace surfaced::boundary
