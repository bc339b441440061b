// Several labellings made in different ways, each brought to a manifold; the best is kept.
#pragma once

#include <string_view>
#include <vector>

#include "minimum_boundary/descent.hpp"
#include "minimum_boundary/inflating.hpp"
#include "minimum_boundary/measures.hpp"
#include "minimum_boundary/watershed.hpp"

namespace surfaced::boundary {

/// How a candidate's first labels are made.
enum class Recipe : std::uint8_t {
  /// Outside is what the watershed joins to infinity down to the thorough level.
  flooded,
  /// The same down to the cautious level only: for noise.
  cautious,
  /// Parity colouring that follows weak votes; cavities and islands cleaned; symmetric repair.
  coloured,
  /// Parity colouring that follows strong votes only; cavities cleaned; symmetric repair.
  coloured_strictly,
};
std::string_view name_of(Recipe recipe);

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
  const Clusters& thorough;
  const Clusters& colouring;
  const Clusters& cautious;
};

/// Makes all candidates, in the order of Recipe, each on one thread, several at a time.
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
