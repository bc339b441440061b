// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: the ways to cover a hole, in the order in which they are tried.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "hole_filling/hole_filling.hpp"
#include "hole_filling/patch.hpp"

namespace surfaced::filling {

/// Longest loop that is small.
inline constexpr std::size_t kSmall = 30;
/// Longest loops that the advancing front and the library are given; their cost grows faster than the hole.
inline constexpr std::size_t kLongestForAngles = 4000;
inline constexpr std::size_t kLongestForLibrary = 1000;

enum class Cover : std::uint8_t { angles, library, corners };

/// How a hole is filled: what covers it, and how far its new points go from the membrane over the rim to where the
/// surface around it leads.
struct Way {
  Cover cover;
  double share;
};

inline constexpr auto kWays = std::to_array<Way>({{Cover::angles, 1},
                                                  {Cover::angles, 0.75},
                                                  {Cover::angles, 0.5},
                                                  {Cover::angles, 0.25},
                                                  {Cover::angles, 0},
                                                  {Cover::library, 1},
                                                  {Cover::library, 0.5},
                                                  {Cover::library, 0},
                                                  {Cover::corners, 0}});

/// @return  none if the hole is longer than the way allows, or what covers it stops.
std::optional<Patch> cover(const Hole& hole, const Way& way, Rotation rotation);

}  // namespace surfaced::filling
