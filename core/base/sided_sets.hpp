// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace surfaced {

/// Disjoint sets over 0..n-1, n below 2^31, that know whether two members have the same side up.
class SidedSets {
 public:
  explicit SidedSets(std::size_t n) : link_(n) {
    for (std::size_t v = 0; v < n; ++v) link_[v] = static_cast<std::uint32_t>(v) << 1U;
  }

  /// Root of v, and in the lowest bit whether v is turned over against it.
  std::uint32_t find(std::uint32_t v) {
    std::uint32_t turned = 0;
    std::uint32_t at = v;
    while (link_[at] >> 1U != at) {
      const std::uint32_t up = link_[at];
      const std::uint32_t above = link_[up >> 1U];
      link_[at] = above ^ (up & 1U);
      turned ^= link_[at] & 1U;
      at = link_[at] >> 1U;
    }
    return at << 1U | turned;
  }

  /// Demands that a and b have the same side up, or (turned = 1) opposite ones. False if that contradicts earlier
  /// demands.
  bool unite(std::uint32_t a, std::uint32_t b, std::uint32_t turned) {
    const std::uint32_t ra = find(a);
    const std::uint32_t rb = find(b);
    turned ^= (ra ^ rb) & 1U;
    if (ra >> 1U == rb >> 1U) return turned == 0;
    const std::uint32_t low = std::min(ra >> 1U, rb >> 1U);
    const std::uint32_t high = std::max(ra >> 1U, rb >> 1U);
    link_[high] = low << 1U | turned;
    return true;
  }

  bool apart(std::uint32_t a, std::uint32_t b) { return find(a) >> 1U != find(b) >> 1U; }

 private:
  std::vector<std::uint32_t> link_;  // 2 * parent + turned against it
};

}  // namespace surfaced
