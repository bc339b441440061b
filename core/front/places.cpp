// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>

#include "front/sewing.hpp"

namespace surfaced::front {

Places::Places(const BoxTree& tree, const LocalStars& stars, const SewingParameters& parameters)
    : tree_(tree), stars_(stars), parameters_(parameters), search_(tree), list_of_(tree.points(), kNoVertex) {}

Point3 Places::normal(std::uint32_t v) const {
  const Normal3& n = stars_.normals[v];
  return {static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])};
}

std::size_t Places::list_of(std::uint32_t v) {
  if (list_of_[v] != kNoVertex) return list_of_[v];
  search_.nearest_anywhere(v, parameters_.reach, found_);
  list_of_[v] = static_cast<std::uint32_t>(lists_.size());
  lists_.push_back(static_cast<std::uint32_t>(found_.count));
  lists_.insert(lists_.end(), found_.index.begin(), found_.index.begin() + static_cast<std::ptrdiff_t>(found_.count));
  return list_of_[v];
}

std::span<const std::uint32_t> Places::neighbours(std::uint32_t v) {
  const std::size_t at = list_of(v);
  return {lists_.data() + at + 1, lists_[at]};
}

bool Places::short_enough(std::uint32_t a, std::uint32_t b) const {
  if (!parameters_.max_edge) return true;
  const double length = norm(position(a) - position(b));
  return within_longest(length, a) || within_longest(length, b);
}

bool Places::within_longest(double length, std::uint32_t v) const {
  return !parameters_.max_edge || length <= *parameters_.max_edge * spacing(v);
}

bool Places::in_capsule(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  if (!parameters_.capsule) return true;
  const std::optional<double>& epsilon = parameters_.capsule->epsilon;
  const double radius = 2 * (epsilon ? *epsilon * tree_.scale() : std::max(spacing(a), spacing(b)));
  const Point3 from = position(a);
  const Point3 along = position(b) - from;
  const Point3 to = position(c) - from;
  const double length2 = dot(along, along);
  const double share = length2 > 0 ? std::clamp(dot(to, along) / length2, 0.0, 1.0) : 0;
  const Point3 off{to[0] - share * along[0], to[1] - share * along[1], to[2] - share * along[2]};
  return norm(off) <= radius;
}

bool Places::allows(const Face& f) const {
  if (!short_enough(f[0], f[1]) || !short_enough(f[1], f[2]) || !short_enough(f[2], f[0])) return false;
  return in_capsule(f[0], f[1], f[2]) || in_capsule(f[1], f[2], f[0]) || in_capsule(f[2], f[0], f[1]);
}

Point3 area_normal(const Places& places, const Face& face) {
  const Point3 a = places.position(face[0]);
  return cross(places.position(face[1]) - a, places.position(face[2]) - a);
}

double circumradius(const Places& places, const Face& f) {
  const Point3 a = places.position(f[0]);
  const Point3 b = places.position(f[1]);
  const Point3 c = places.position(f[2]);
  const double area = norm(area_normal(places, f));
  if (!(area > 0)) return std::numeric_limits<double>::infinity();
  return norm(b - a) * norm(c - b) * norm(a - c) / (2 * area);
}

double cosine(const Point3& a, const Point3& b) {
  const double lengths = norm(a) * norm(b);
  return lengths > 0 ? dot(a, b) / lengths : -1;
}

}  // namespace surfaced::front
