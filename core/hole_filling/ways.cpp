// SPDX-License-Identifier: GPL-3.0-or-later
#include "hole_filling/ways.hpp"

#include <algorithm>

#include "base/vectors.hpp"
#include "hole_filling/angle_front.hpp"
#include "hole_filling/library_patch.hpp"
#include "hole_filling/refinement.hpp"

namespace surfaced::filling {
namespace {

/// New points that a hole of n corners may take: a flat disc with n edges around it has n²/11 points as dense.
constexpr std::size_t kShareOfSquare = 4;
constexpr std::size_t kAlwaysAllowed = 100;

/// As a disc takes with as long a rim.
std::size_t most_points(const Hole& hole) {
  const std::size_t n = hole.corners.size();
  double steps = 0;
  for (std::size_t i = 0; i < n; ++i) steps += norm(hole.corners[(i + 1) % n] - hole.corners[i]) / hole.spacings[i];
  const double around = std::clamp(steps, static_cast<double>(n), static_cast<double>(kLongestForAngles));
  return kAlwaysAllowed + static_cast<std::size_t>(around * around) / kShareOfSquare;
}

std::optional<Patch> cover_by_corners(const Hole& hole) {
  LoopLimits limits;
  limits.may_join = [&](std::size_t i, std::size_t j) {
    return !hole.joined(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
  };
  auto triangles = triangulate_loop({hole.corners, hole.beyond}, limits);
  if (!triangles) return std::nullopt;
  return Patch{hole.corners, std::move(*triangles)};
}

}  // namespace

std::optional<Patch> cover(const Hole& hole, const Way& way, Rotation rotation) {
  const std::size_t n = hole.corners.size();
  if (way.cover == Cover::corners) return n <= kSmall ? cover_by_corners(hole) : std::nullopt;
  const bool by_angles = way.cover == Cover::angles;
  if (n > (by_angles ? kLongestForAngles : kLongestForLibrary)) return std::nullopt;
  std::optional<Patch> patch = by_angles ? cover_by_angles(hole, most_points(hole)) : cover_by_library(hole);
  if (!patch) return patch;
  if (way.share == 1) {
    refine(*patch, hole, rotation);
    return patch;
  }
  Patch led = *patch;
  refine(*patch, hole, Rotation::none);
  if (way.share == 0) return patch;
  refine(led, hole, rotation);
  for (std::size_t i = n; i < patch->points.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      patch->points[i][axis] += way.share * (led.points[i][axis] - patch->points[i][axis]);
    }
  }
  return patch;
}

}  // namespace surfaced::filling
