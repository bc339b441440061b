#pragma once

#include "front/front.hpp"

namespace surfaced::ldt {

/// A triangle of points without faces: v, the nearest such neighbour, and the one of least circumradius whose smallest
/// circumscribing ball is empty. Only where no face is near. @return false if there is none.
bool seed_triangle(front::Fans& fans, front::Places& places, std::uint32_t v);

/// The paper's start (algorithm 1, step 4): the 2-D Delaunay triangulation of v and its n nearest neighbours in the
/// tangent plane of v, all of it. Only where no face is near. @return false if it would not be manifold.
bool seed_local_triangulation(front::Fans& fans, front::Places& places, std::uint32_t v, std::size_t n);

/// Exact: whether all points lie on one line.
bool all_on_a_line(std::span<const Point3> points);

}  // namespace surfaced::ldt
