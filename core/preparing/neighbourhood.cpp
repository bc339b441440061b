// SPDX-License-Identifier: GPL-3.0-or-later
#include "preparing/neighbourhood.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>

#include "base/parallel.hpp"

namespace surfaced {
namespace preparing {
namespace {

/// What nanoflann asks of a set of points.
struct Adaptor {
  const std::vector<Point3>& positions;
  std::size_t kdtree_get_point_count() const { return positions.size(); }
  double kdtree_get_pt(std::size_t v, std::size_t axis) const { return positions[v][axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Adaptor>, Adaptor, 3, std::uint32_t>;

}  // namespace

std::vector<double> mean_distances(const std::vector<Point3>& positions, std::size_t k, unsigned threads) {
  const Adaptor adaptor{positions};
  const Tree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  std::vector<double> means(positions.size(), 0);
  parallel_ranges(threads, positions.size(), [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> index(k + 1);
    std::vector<double> squared(k + 1);
    for (std::size_t v = begin; v < end; ++v) {
      const std::size_t found = tree.knnSearch(positions[v].data(), k + 1, index.data(), squared.data());
      double sum = 0;
      for (std::size_t i = 0; i < found; ++i) sum += std::sqrt(squared[i]);
      if (found > 1) means[v] = sum / static_cast<double>(found - 1);
    }
  });
  return means;
}

std::vector<std::uint32_t> neighbour_table(const std::vector<Point3>& positions, std::size_t k, unsigned threads) {
  const Adaptor adaptor{positions};
  const Tree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  std::vector<std::uint32_t> table(positions.size() * k, VertexIndex::kNone);
  parallel_ranges(threads, positions.size(), [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> index(k + 1);
    std::vector<double> squared(k + 1);
    std::vector<std::pair<double, std::uint32_t>> order;
    for (std::size_t v = begin; v < end; ++v) {
      const std::size_t found = tree.knnSearch(positions[v].data(), k + 1, index.data(), squared.data());
      order.clear();
      for (std::size_t i = 0; i < found; ++i) {
        if (index[i] != v) order.emplace_back(squared[i], index[i]);
      }
      std::ranges::sort(order);
      for (std::size_t i = 0; i < std::min(k, order.size()); ++i) table[v * k + i] = order[i].second;
    }
  });
  return table;
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace preparing

Nearest nearest_points(const std::vector<Point3>& positions, const std::vector<Point3>& places, unsigned threads) {
  const preparing::Adaptor adaptor{positions};
  const preparing::Tree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  Nearest nearest;
  nearest.index.resize(places.size());
  nearest.distance.resize(places.size());
  parallel_ranges(threads, places.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::uint32_t index = 0;
      double squared = std::numeric_limits<double>::infinity();
      tree.knnSearch(places[i].data(), 1, &index, &squared);
      nearest.index[i] = VertexIndex(index);
      nearest.distance[i] = std::sqrt(squared);
    }
  });
  return nearest;
}

double spacing_of(const std::vector<Point3>& positions, unsigned threads) {
  constexpr std::size_t kNeighbours = 6;
  return preparing::median_of(preparing::mean_distances(positions, kNeighbours, threads));
}

}  // namespace surfaced
