// SPDX-License-Identifier: GPL-3.0-or-later
// Surgery on 3-loops: removes handles one triangle thin.
#pragma once

#include <cstdint>
#include <limits>

#include "minimum_boundary/connectivity.hpp"
#include "minimum_boundary/criterion.hpp"
#include "minimum_boundary/fusing.hpp"
#include "minimum_boundary/labelling.hpp"

namespace surfaced::boundary {

struct Surgery {
  std::size_t loops = 0;
  std::size_t removed_handles = 0;
  /// How near the closest decision was, in λ of the loop; infinite if there was none to make.
  double margin = std::numeric_limits<double>::infinity();
};

/// Tries every facet inside or outside whose three edges all lie on the surface: flipping its cells caps the
/// loop from both sides. Neighbours are repaired without touching these cells; the whole is kept only if every
/// vertex is good again, χ rises, no vertex becomes interior, no component is
/// added, and Σλ rises by less than three λ of the loop, or, where no handle is too many, falls by more. Precondition
/// and postcondition: every vertex is good.
/// @return  cancelled.
Result<Surgery> operate(Labelling& labels, const Criterion& criterion, Handles& handles, SurfaceSearch& search,
                        const Context& context, unsigned threads);

}  // namespace surfaced::boundary
