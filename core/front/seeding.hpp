// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>

#include "front/sewing.hpp"

namespace surfaced::front {

/// Whether v or one of its nearest points has faces already.
bool surface_is_near(const Fans& fans, Places& places, std::uint32_t v);

/// A triangle of points without faces: v, the nearest such neighbour, and the one of least circumradius whose smallest
/// circumscribing ball is empty. Only where no face is near. @return false if there is none.
bool seed_triangle(Fans& fans, Places& places, std::uint32_t v);

/// Exact: whether all points lie on one line.
bool all_on_a_line(std::span<const Point3> points);

}  // namespace surfaced::front
