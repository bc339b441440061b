// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: the stage `fill_holes` behind a method that leaves holes.
#pragma once

#include "hole_filling/hole_filling.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced {

/// Schema of the parameter `fill_holes`.
Json fill_holes_property(std::string_view default_value);
/// Schema of the parameter `rotation`.
Json rotation_property();
Rotation rotation_of(const Json& parameters);

/// Fills the holes of what a method made, turns parts that are closed now outwards, and says in warnings and in
/// `hole_filling` what was done and what stays.
Status run_hole_stage(Reconstruction& result, const FillParameters& parameters, Context& context);

/// The same as the parameter `fill_holes` says: all, small or none.
Status run_hole_parameter(Reconstruction& result, const Json& parameters, Context& context);

}  // namespace surfaced
