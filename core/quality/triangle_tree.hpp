// SPDX-License-Identifier: GPL-3.0-or-later
// The tree of CGAL in which the rays and distances of this room are looked up.
#pragma once

#include <CGAL/AABB_tree.h>
#include <CGAL/version.h>
#if CGAL_VERSION_NR >= 1060000000
#include <CGAL/AABB_traits_3.h>
#include <CGAL/AABB_triangle_primitive_3.h>
#else
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_triangle_primitive.h>
#endif
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <vector>

#include "base/base.hpp"

namespace surfaced::quality {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangles = std::vector<Kernel::Triangle_3>;
#if CGAL_VERSION_NR >= 1060000000
using Primitive = CGAL::AABB_triangle_primitive_3<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits_3<Kernel, Primitive>>;
#else
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;
#endif

inline Kernel::Point_3 point(const Point3& p) { return {p[0], p[1], p[2]}; }

}  // namespace surfaced::quality
