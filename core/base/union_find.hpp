// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace surfaced {

/// Disjoint sets over 0..n-1. The root of a set is its least member, so that results do not depend
/// on the order of the unions.
class UnionFind {
 public:
  explicit UnionFind(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0U); }

  std::uint32_t find(std::size_t x) {
    auto i = static_cast<std::uint32_t>(x);
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  /// Joins two sets; false if they were one already.
  bool unite(std::size_t x, std::size_t y) {
    std::uint32_t a = find(x);
    std::uint32_t b = find(y);
    if (a == b) return false;
    if (b < a) std::swap(a, b);
    parent_[b] = a;
    return true;
  }

  /// Asks for the memory of x ahead of a call of find.
  void prefetch(std::size_t x) const { __builtin_prefetch(&parent_[x]); }
  /// A member of the same set, nearer to its root; the root of a root.
  std::uint32_t next(std::size_t x) const { return parent_[x]; }

  std::size_t size() const { return parent_.size(); }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace surfaced
