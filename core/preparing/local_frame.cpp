// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "preparing/preparing.hpp"

namespace surfaced {

LocalFrame::LocalFrame(const std::vector<Point3>& positions) : origin_(bounds_of(positions).low), exponent_(0) {
  int exponent = 0;
  std::frexp(std::ranges::max(bounds_of(positions).high - origin_), &exponent);
  exponent_ = kExtentExponent - exponent;
}

Point3 LocalFrame::to_local(const Point3& p) const {
  Point3 local = p - origin_;
  for (double& x : local) x = std::ldexp(std::nearbyint(std::ldexp(x, exponent_ + kStepExponent)), -kStepExponent);
  return local;
}

double LocalFrame::to_local(double length) const { return std::ldexp(length, exponent_); }

Point3 LocalFrame::to_input(const Point3& local) const {
  return {std::ldexp(local[0], -exponent_) + origin_[0], std::ldexp(local[1], -exponent_) + origin_[1],
          std::ldexp(local[2], -exponent_) + origin_[2]};
}

}  // namespace surfaced
