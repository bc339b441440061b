// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: a set of positions as one flat table.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/base.hpp"

namespace surfaced {

/// Positions without NaN and -0, of which there are at most as many as announced. For tens of millions of them
/// std::unordered_set takes six times as long.
/// @cost  36 bytes per position announced.
class PositionSet {
 public:
  explicit PositionSet(std::size_t most) : slots_(most + most / 2 + 1, kEmpty) {}

  /// @return  whether it is new.
  bool insert(const Point3& p) {
    Point3& slot = slots_[slot_of(p)];
    if (slot == p) return false;
    slot = p;
    return true;
  }

  bool contains(const Point3& p) const { return slots_[slot_of(p)] == p; }

 private:
  static constexpr Point3 kEmpty{std::numeric_limits<double>::quiet_NaN(), 0, 0};

  /// Where p is, or else the empty slot in which it would be.
  std::size_t slot_of(const Point3& p) const {
    std::uint64_t hash = 0;
    for (const double x : p) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0x9E3779B97F4A7C15U;
      hash ^= hash >> 32U;
    }
    std::size_t at = hash % slots_.size();
    while (!std::isnan(slots_[at][0]) && slots_[at] != p) at = at + 1 < slots_.size() ? at + 1 : 0;
    return at;
  }

  std::vector<Point3> slots_;
};

}  // namespace surfaced
