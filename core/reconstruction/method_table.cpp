// SPDX-License-Identifier: GPL-3.0-or-later
#include "reconstruction/method_table.hpp"

namespace surfaced {

std::vector<Method> all_methods() {
  return {minimum_boundary_method(), local_delaunay_method(), intrinsic_delaunay_method(), advancing_front_method(),
          scale_space_method(),      poisson_method(),        alpha_wrap_method()};
}

}  // namespace surfaced
