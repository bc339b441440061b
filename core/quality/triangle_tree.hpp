// SPDX-License-Identifier: GPL-3.0-or-later
// The tree of CGAL in which the rays and distances of this room are looked up.
#pragma once

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <vector>

#include "base/base.hpp"

namespace surfaced::quality {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

inline Kernel::Point_3 point(const Point3& p) { return {p[0], p[1], p[2]}; }

}  // namespace surfaced::quality
