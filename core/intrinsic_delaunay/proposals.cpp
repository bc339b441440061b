// SPDX-License-Identifier: GPL-3.0-or-later
// Source: paper 3, §3.2.
#include "intrinsic_delaunay/proposals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"
#include "base/vectors.hpp"
#include "intrinsic_delaunay/registration.hpp"

namespace surfaced::idt {
namespace {

/// Patches of nearest signatures that are compared by similarity.
constexpr std::size_t kCandidates = 16;
/// Share of ε by which a patch may miss.
constexpr double kFit = 0.25;

/// Root of the mean squared distance from the target's points to the surface through the moved ones. From point to
/// point two samples of one surface are half a spacing apart, so that distance refuses all but copies.
double misfit(std::span<const Point3> moved, std::span<const Point3> target, const LocalShape& target_shape) {
  const auto surface = fit_shape(moved, target_shape.origin, target_shape.frame[2]);
  if (!surface) return std::numeric_limits<double>::infinity();
  double sum = 0;
  for (const Point3& p : target) {
    const Point3 miss = surface->above(p) - p;
    sum += dot(miss, miss);
  }
  return std::sqrt(sum / static_cast<double>(target.size()));
}

}  // namespace

Surroundings::Surroundings(std::span<const Point3> positions, std::span<const Point3> normals, double epsilon)
    : positions_(positions), normals_(normals), epsilon_(epsilon), tree_(positions) {}

std::vector<Point3> Surroundings::points_of(std::span<const std::uint32_t> indices) const {
  std::vector<Point3> points;
  points.reserve(indices.size());
  for (const std::uint32_t i : indices) points.push_back(positions_[i]);
  return points;
}

Point3 Surroundings::up_at(std::span<const std::uint32_t> indices) const {
  Point3 up{};
  for (const std::uint32_t i : indices) up += normals_[i];
  return up;
}

std::optional<LocalShape> Surroundings::shape_at(const Point3& place) const {
  const auto near = tree_.nearest(place, kPatch);
  return fit_shape(points_of(near), place, up_at(near));
}

Point3 Surroundings::gaussian_mean(const Point3& place) const {
  Point3 sum = place;
  double weights = 1;
  for (const Point3& p : points_of(tree_.nearest(place, kPatch))) {
    const double weight = std::exp(-dot(p - place, p - place) / (epsilon_ * epsilon_));
    sum += weight * p;
    weights += weight;
  }
  return (1 / weights) * sum;
}

double Surroundings::distance_to_nearest(const Point3& place) const {
  const auto nearest = tree_.nearest(place, 1);
  // So far from all that the square of the distance is none that a double holds.
  if (nearest.empty()) return std::numeric_limits<double>::infinity();
  return norm(positions_[nearest.front()] - place);
}

void Surroundings::describe_patches(Context& context) {
  curvatures_.resize(positions_.size());
  signatures_.resize(positions_.size());
  parallel_ranges(context.threads(), positions_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && !context.cancelled(); ++i) {
      if (const auto shape = shape_at(positions_[i])) curvatures_[i] = shape->curvature_at(positions_[i]);
    }
  });
  parallel_ranges(context.threads(), positions_.size(), [&](std::size_t begin, std::size_t end) {
    std::vector<LocalShape::Curvature> patch;
    for (std::size_t i = begin; i < end && !context.cancelled(); ++i) {
      patch.clear();
      for (const std::uint32_t j : tree_.nearest(positions_[i], kPatch + 1)) patch.push_back(curvatures_[j]);
      signatures_[i] = signature_of(patch, epsilon_);
    }
  });
  signature_tree_.emplace(signatures_);
}

std::optional<Point3> Surroundings::from_similar_patch(const Point3& guess) const {
  const auto near = tree_.nearest(guess, kPatch);
  const std::vector<Point3> target = points_of(near);
  const auto shape = fit_shape(target, guess, up_at(near));
  if (!shape) return std::nullopt;
  std::vector<LocalShape::Curvature> patch;
  for (const std::uint32_t j : near) patch.push_back(curvatures_[j]);
  patch.push_back(shape->curvature_at(guess));
  const Signature signature = signature_of(patch, epsilon_);

  // A patch around one of the neighbours would give back the points that are here already.
  std::optional<std::uint32_t> best;
  for (const std::uint32_t i : signature_tree_->nearest(signature, kCandidates + kPatch)) {
    if (std::ranges::find(near, i) != near.end()) continue;
    if (!best || similarity(signature, signatures_[i]) > similarity(signature, signatures_[*best])) best = i;
  }
  if (!best) return std::nullopt;
  const auto others = tree_.nearest(positions_[*best], kPatch + 1);
  const std::vector<Point3> other = points_of(others);
  const auto other_shape = fit_shape(other, positions_[*best], up_at(others));
  if (!other_shape) return std::nullopt;
  const auto aligned = align(target, *shape, other, *other_shape);
  if (!aligned || !(misfit(aligned->points, target, *shape) <= kFit * epsilon_)) return std::nullopt;
  return *std::ranges::min_element(aligned->points, {}, [&](const Point3& p) { return norm(p - guess); });
}

}  // namespace surfaced::idt
