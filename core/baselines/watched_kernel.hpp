// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: the kernels of CGAL that its methods use.
#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include "baselines/watch.hpp"

namespace surfaced::baselines {

using ExactKernel = CGAL::Exact_predicates_inexact_constructions_kernel;

/// CGAL's kernel, ticking in the predicate that Delaunay triangulations spend their time around and in the access to
/// coordinates that kd-trees do.
struct TickingKernel : ExactKernel {
  struct Side_of_oriented_sphere_3 : ExactKernel::Side_of_oriented_sphere_3 {
    template <class... Points>
    auto operator()(const Points&... points) const {
      Watch::tick();
      return ExactKernel::Side_of_oriented_sphere_3::operator()(points...);
    }
  };
  Side_of_oriented_sphere_3 side_of_oriented_sphere_3_object() const { return {}; }

  struct Construct_cartesian_const_iterator_3 : ExactKernel::Construct_cartesian_const_iterator_3 {
    template <class... Arguments>
    auto operator()(const Arguments&... arguments) const {
      Watch::tick();
      return ExactKernel::Construct_cartesian_const_iterator_3::operator()(arguments...);
    }
  };
  Construct_cartesian_const_iterator_3 construct_cartesian_const_iterator_3_object() const { return {}; }
};

/// A name of its own, for which constructions of CGAL can be guarded.
struct WatchedKernel : TickingKernel {};

}  // namespace surfaced::baselines
