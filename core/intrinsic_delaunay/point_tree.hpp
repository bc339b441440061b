// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: nearest points of any place, where core/spatial knows only places that are points.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <nanoflann.hpp>
#include <span>
#include <vector>

#include "base/base.hpp"

namespace surfaced::idt {

/// A kd-tree over vectors of N numbers. Keeps a view of them.
template <std::size_t N>
class VectorTree {
 public:
  using Vector = std::array<double, N>;

  explicit VectorTree(std::span<const Vector> vectors) : view_{vectors}, tree_(static_cast<int>(N), view_) {}

  /// The k nearest, nearest first; of those found at the same distance the lower index first.
  std::vector<std::uint32_t> nearest(const Vector& place, std::size_t k) const {
    std::vector<std::uint32_t> found(k);
    std::vector<double> squares(k);
    const std::size_t count = tree_.knnSearch(place.data(), k, found.data(), squares.data());
    std::vector<std::pair<double, std::uint32_t>> order;
    for (std::size_t i = 0; i < count; ++i) order.emplace_back(squares[i], found[i]);
    std::ranges::sort(order);
    found.resize(count);
    for (std::size_t i = 0; i < count; ++i) found[i] = order[i].second;
    return found;
  }

 private:
  struct View {
    std::span<const Vector> vectors;
    std::size_t kdtree_get_point_count() const { return vectors.size(); }
    double kdtree_get_pt(std::size_t i, std::size_t axis) const { return vectors[i][axis]; }
    template <class Box>
    bool kdtree_get_bbox(Box& /*unused*/) const {
      return false;
    }
  };
  View view_;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, View>, View, static_cast<int>(N),
                                      std::uint32_t>
      tree_;
};

using PointTree = VectorTree<3>;

}  // namespace surfaced::idt
